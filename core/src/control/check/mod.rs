//! The check of a robot: a wiggle of some 20 s, and what it says of robot and tracker.
//!
//! The wiggle is open loop: rest, turns in place and short drives, each followed by a rest ([`Wiggle`]). The poses are
//! taken as they come, before any is set aside, and with them the commands in force ([`Trace`]). Rests are compared with
//! rests, so nothing needs to be known of the delay between command and motion: it is found ([`Levels`]). What the motions
//! came to ([`Response`]) names what is wrong ([`Finding`]), each with its remedy. `docs/check.md` has them in a table.
//!
//! Nothing is learned of the floor, and all storage has a fixed size.

mod finding;
mod frame;
mod levels;
mod report;
mod response;
mod trace;
mod verdict;
mod wiggle;
mod words;

pub use finding::{Clock, Fault, Finding, Findings, Mirror, Quarter};
pub use frame::Frame;
pub use levels::{Change, Levels};
pub use report::{Numbers, Report};
pub use response::Response;
pub use trace::Trace;
pub use wiggle::{MOTIONS, Part, Wiggle};

#[cfg(test)]
mod tests;
