//! Support for the end-to-end tests: what they need around the programs under test.
//!
//! * [`process`]: the built programs as processes that never outlive their test; [`server`]: one of them that serves.
//! * [`said`]: programs that do one thing and end; [`data`]: a directory for what outlives a server.
//! * [`proxy`]: a link between agent and server that delays, goes dead and comes back; [`tap`]: what crossed it last.
//! * [`http`]: requests byte by byte, for what the typed client refuses to send.
//! * [`rover`]: an agent that says exactly what a test wants, and agents as they are.
//! * [`trace`]: what a robot did, and the limits that it kept.
//! * [`wait`]: until a condition holds, within a deadline.
//! * [`faults`]: everything that can go wrong, injected into all of it at once, and what must hold all the same.
//!
//! Invariant: nothing here sleeps in the hope that something will have happened by then.

pub mod data;
pub mod faults;
pub mod http;
pub mod process;
pub mod proxy;
pub mod rover;
pub mod said;
pub mod server;
pub mod tap;
pub mod trace;
pub mod wait;
