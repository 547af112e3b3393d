//! Whether a robot moves as the kind that it is described as.

use super::estimate::Estimate;
use crate::robot;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is shown beside a proposal: what poses alone cannot tell.
pub const NOTE: &str = "a tracked point ahead of the axle or behind it moves sideways in turns just as skid steer does: where the marker is off, have the tracker correct for that";

/// The evidence that a robot which is described as differential is skid-steer. Nothing is changed by it: who knows the robot
/// describes it so.
///
/// From poses alone sideways motion per radian cannot be told from a marker that is mounted ahead of the axle or behind it; a
/// marker that is rotated shows as sideways motion per metre, which is no part of this.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentKind)]
pub struct Kind {
    /// What it is described as.
    pub described: robot::Kind,
    /// What it is to be described as; null where that is what it is, or the evidence is below a hundred to one.
    pub proposed: Option<robot::Kind>,
    /// Natural logarithm of the evidence of skid steer against differential drive; that marker or tyres are off by 3 % counts
    /// as differential.
    pub ln_evidence: Option<f64>,
    /// Motion of the tracked point to the left per radian of turn to the left.
    pub sideways_m_per_rad: Estimate,
    /// By what part turns grow per m/s of speed.
    pub turn_by_speed_s_per_m: Estimate,
    /// What cannot be told apart; null where nothing is proposed.
    pub note: Option<String>,
}
