//! The rules of the server that could silently break: most through its router, the rest over real sockets.

// A test that cannot go on may panic; clippy takes only the functions marked #[test] for tests.
#![allow(clippy::unwrap_used)]

mod api;
mod bad_input;
#[cfg(target_os = "linux")]
mod budgets;
mod comparisons;
mod conditions;
mod data;
mod descriptions;
mod environments;
mod events;
mod evolutions;
mod guard;
mod jobs;
mod kills;
mod offline;
mod priors;
mod process;
mod recovery;
mod request_log;
mod robots;
mod shutdown;
mod sockets;
mod steps;
mod stops;
mod stores;
mod submissions;
mod upgrades;
mod watch;
