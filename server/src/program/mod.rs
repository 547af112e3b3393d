//! The program: its command line, its settings, and the server that it puts together and runs.

mod arguments;
pub(crate) mod config;
mod memory;
mod run;
pub(crate) mod serve;

pub use run::main;
