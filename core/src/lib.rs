//! The pure domain of Umwelt: a controller that drives two-wheel robots over bad links by first recognising the
//! environment they are in.
//!
//! Architecture invariant: this crate does no I/O, reads no clock, starts no thread and owns no random number
//! generator. Time and seeds are arguments; the same state and input give the same result, bit for bit.
//!
//! The way of one pose: [`exchange`] (the robot's side) -> [`controller`] = [`identification`] -> [`prediction`] ->
//! [`steering`] -> [`horizon`] -> [`actuation`] (the robot again). [`episode`] closes that loop in simulated time over a
//! simulated [`link`] and [`plant`].

mod control;
mod robot;
mod simulation;

pub mod comparison;
pub mod evolution;
pub mod peers;
mod seeds;

pub use control::{
    commands, conjugate, controller, identification, prediction, settings, steering, task, watch,
};
pub use robot::{actuation, exchange, geometry, horizon, kinematics, local};
pub(crate) use simulation::draws;
pub use simulation::{episode, fixed_models, link, plant};
