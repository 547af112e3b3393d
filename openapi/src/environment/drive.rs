//! How late a robot's drive follows its commands, as it is identified.

use super::band::DeadBand;
use super::estimate::{Estimate, Status};
use super::kind::Kind;
use super::scale::Scale;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is known of how late a robot's drive follows its commands.
///
/// From poses and commands alone the sum is known well: of dead time, lag and whatever the stamps of the poses are late by.
/// How it parts shows in the shape of starts and stops, as far as the noise of the poses allows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentDrive)]
pub struct Drive {
    /// How far the estimate has got; `given` where dead time or lag are described.
    pub status: Status,
    /// Part of the information that it takes until the prior no longer dominates, 1 once it does not; null where it is given.
    pub estimated_fraction: Option<f64>,
    /// Dead time and lag together, in s.
    pub delay_s: Estimate,
    /// Time constant in s with which the wheels follow a command.
    pub lag_s: Estimate,
    /// Time in s before they begin to, with the delay of the stamps in it.
    pub dead_time_s: Estimate,
    /// Stretches of motion of up to 1.5 s from which it is known.
    pub stretches: u64,
    /// Stretches that no delay explains: they say nothing.
    pub stretches_not_understood: u64,
    /// Wheels and track with which the robot moves as it does; null where nothing of the drive is identified.
    #[serde(default)]
    pub scale: Option<Scale>,
    /// Whether it moves as skid steer does; null before the first stretch, where nothing of the drive is identified, and where
    /// it is described as skid steer.
    #[serde(default)]
    pub kind: Option<Kind>,
    /// The speed below which the motors do not turn the wheels; null where nothing of the drive is identified.
    #[serde(default)]
    pub dead_band: Option<DeadBand>,
}
