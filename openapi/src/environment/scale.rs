//! By how much a robot moves otherwise than its wheels and track say, as it is identified.

use super::estimate::Estimate;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// The wheels and the track with which the robot moves as it does, on the floor where it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DriveScale)]
pub struct Scale {
    /// Whether commands are corrected by it: with method `adaptive`.
    pub used: bool,
    /// Radius of the wheels in m with which it moves as it does, in the metres of its tracker.
    pub wheel_radius_m: Estimate,
    /// The radius that is described.
    pub described_wheel_radius_m: f64,
    /// Distance in m between the wheels with which it turns as it does.
    pub track_width_m: Estimate,
    /// The track that is described.
    pub described_track_width_m: f64,
    /// By what part the right wheel is larger than the left.
    pub right_larger: Estimate,
    /// Forward motion per forward motion commanded as described, less one.
    pub forward: Split,
    /// Turn per turn commanded as described, less one.
    pub turn: Split,
    /// Turn in rad per metre commanded as described.
    pub drift: Split,
    /// Floors before this one: each `environment/reset` begins another.
    pub floors: u64,
}

/// What of a scale belongs to the robot and what to the floor.
///
/// On one floor only both together are known from poses and commands: the parts of their intervals exclude each other. They
/// part over several floors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DriveScaleSplit)]
pub struct Split {
    /// Robot and floor together.
    pub together: Estimate,
    /// What of it belongs to the robot.
    pub robot: Estimate,
    /// What of it belongs to the floor.
    pub floor: Estimate,
}
