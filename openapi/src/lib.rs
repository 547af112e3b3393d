//! The contract of Umwelt: what goes over the wire, how it is checked, and how it becomes `umwelt_core`.
//!
//! JSON over HTTP, snake_case with unit suffixes, described by [`DOCUMENT`] (OpenAPI 3.1). Each wire type stands in the
//! module of its subject under the subject's noun: [`step::Request`], [`robot::Spec`].
//!
//! * Outside data comes in through `read` (JSON bytes -> [`Checked`] wire type), which reports every problem at once as
//!   [`Problems`]. What is checked becomes core by `to_core`, which cannot fail; there is no other way in.
//! * The feature `core`, on by default, has these conversions. Without it, as in a client, the types and the checks
//!   stay, and core is not built. The feature `document` makes the document anew.
//! * What core computes goes out through `From`; what of evolutions, comparisons and simulated environments is for
//!   `umwelt-lab` to say stands there (`umwelt_lab::wire`). A number that does not exist (NaN, infinite) is `null` where the
//!   type says `Option`, and an error of serialisation elsewhere: it never leaves silently.
//! * A reader of responses ignores fields it does not know: the contract only grows.
//!
//! Architecture invariant: of this workspace, this crate depends on core only; no HTTP, no clock, no I/O.

pub mod body;
#[cfg(feature = "core")]
mod built_in;
mod check;
mod checked;
pub mod comparison;
#[cfg(feature = "core")]
mod conversion;
#[cfg(feature = "document")]
mod document;
pub mod endpoint;
pub mod environment;
mod estimate;
pub mod event;
pub mod evolution;
pub mod health;
mod id;
mod idempotency;
pub mod job;
mod named;
mod number;
pub mod page;
pub mod prior;
pub mod problem;
pub mod robot;
pub mod robot_check;
// Two attributes: clippy takes a module for tests by the plain one.
#[cfg(feature = "core")]
#[cfg(test)]
mod round_trip;
pub mod schema;
pub mod square;
pub mod step;
pub mod stop;
pub mod task;
mod token;
pub mod training;
pub mod visible;
pub mod watch;

pub use check::{Check, Range, Validate};
pub use checked::Checked;
#[cfg(feature = "document")]
pub use document::document;
pub use id::{ComparisonId, EnvironmentId, EvolutionId, InvalidId, PriorId, RobotId};
pub use idempotency::{IdempotencyKey, InvalidKey, MAX_KEY};
pub use named::Known;
pub use problem::{ErrorBody, Problem, Problems, Status};
pub use token::{InvalidToken, MAX_TOKEN, MIN_TOKEN, Token};

/// The contract as OpenAPI 3.1, in JSON.
///
/// ```
/// assert!(umwelt_api::DOCUMENT.contains("\"/v1/robots/{robot}/step\""));
/// ```
pub const DOCUMENT: &str = include_str!("../openapi.json");
