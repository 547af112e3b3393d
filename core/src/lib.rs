//! The pure domain of Umwelt: a controller that drives two-wheel robots over bad links by first recognising the
//! environment they are in.
//!
//! Architecture invariant: this crate does no I/O, reads no clock, starts no thread and owns no random number
//! generator. Time and seeds are arguments; the same state and input give the same result, bit for bit.
//!
//! The way of one pose: [`exchange`] (the robot's side) -> [`controller`] = [`identification`] -> [`prediction`] ->
//! [`steering`] -> [`horizon`] -> [`actuation`] (the robot again). [`episode`] closes that loop in simulated time over a
//! simulated [`link`] and [`plant`].

pub mod actuation;
pub mod commands;
pub mod comparison;
pub mod conjugate;
pub mod controller;
mod draws;
pub mod episode;
pub mod evolution;
pub mod exchange;
pub mod geometry;
pub mod horizon;
pub mod identification;
pub mod kinematics;
pub mod link;
pub mod local;
pub mod peers;
pub mod plant;
pub mod prediction;
mod seeds;
pub mod steering;
pub mod watch;
