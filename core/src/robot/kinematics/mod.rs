//! What a robot's wheels make of its commands: the [motion model](MotionModel) of its kind, its limits, its actuator lag, and
//! exact-arc integration.
//!
//! Two kinds: differential drive, and skid steer, which turns by a ratio that depends on speed, about a centre that lies
//! ahead of or behind the point that is tracked. A [`Drive`] is what is described of a robot; it has the model of its
//! [`Kind`].

mod arc;
mod differential;
mod drive;
mod lag;
mod limits;
mod model;
mod skid_steer;

pub use arc::{arc, integrate};
pub use differential::Differential;
pub use drive::{Drive, Kind, forward, inverse, travel};
pub use lag::{follow, left_over};
pub use model::{Errors, MotionModel};
pub use skid_steer::{SkidSteer, SkidSteering, TURN_RATIO};

/// Below this angular velocity in rad/s a motion counts as straight (thesis table 1).
pub const STRAIGHT_BELOW: f64 = 0.01;

#[cfg(test)]
mod tests;
