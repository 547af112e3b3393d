//! The speed below which a robot's motors do not turn its wheels, as it is identified.

use super::estimate::{Estimate, Status};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// The speed commanded of a wheel below which its motor does not turn it.
///
/// It is known from steady commands at which wheels were seen to turn, or to stand. Below 0.2 rad/s it is none to speak of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DriveDeadBand)]
pub struct DeadBand {
    /// How far the estimate has got; `given` where a smallest speed is described.
    pub status: Status,
    /// Part of the information that it takes until the prior no longer dominates, 1 once it does not; null where it is given.
    pub estimated_fraction: Option<f64>,
    /// The speed in rad/s; where it is given, the smallest one at which the motors turn by the description. An interval that
    /// begins at 0 leaves the rest above.
    pub speed_rad_per_s: Estimate,
    /// How often a wheel was seen to turn at a steady command, or to stand.
    pub judgements: u64,
}
