//! The typed client of Umwelt. The program `umwelt` is its command line.
//!
//! * [`Client`]: one async method per route of the contract, those of jobs for every kind, in the types of [`umwelt_api`].
//! * [`Client::events`]: what happens, as a stream that reconnects by itself.
//! * [`StepConnection`]: the hot path, for the agent on the robot.
//!
//! Architecture invariant: the only crate that knows reqwest; it imports nothing of the server.

mod address;
mod call;
mod client;
mod compare;
mod connection;
mod error;
mod events;
mod evolve;
mod job;
mod pages;
mod retry;
#[cfg(test)]
mod samples;
mod sse;
mod step;
#[cfg(test)]
mod test_server;
mod token;
mod whole;

pub use client::{Client, DEADLINE};
pub use error::{Error, Failure};
pub use events::{Events, JobEvents, SILENCE};
pub use job::fresh_key;
pub use step::{MAX_REPLY, STEP_DEADLINE, StepConnection};
pub use token::read_token;
pub use umwelt_api as api;
pub use whole::List;
