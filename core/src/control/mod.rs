//! The controller's side: from poses to a belief about the environment, and from that to wheel speeds.

pub mod check;
pub mod commands;
mod condition;
pub mod conjugate;
pub mod controller;
pub mod derived;
pub mod drive;
pub mod fusion;
pub mod identification;
pub mod prediction;
pub mod settings;
pub mod square;
pub mod steering;
pub mod task;
pub mod watch;
