//! What comes back from a step: the timed wheel speeds.

use super::TIME;
use crate::check::{Check, Checked, Range};
use crate::number;
use crate::problem::Problems;
use crate::robot::{MAX_INTEGER, WATCHDOG};
use crate::task;
use serde::{Deserialize, Serialize};
use umwelt_core::geometry;
use umwelt_core::horizon::{self, MAX_SLOTS};
use umwelt_core::time::RobotTime;
use utoipa::ToSchema;

/// From a fast motor controller's cycle to that of a robot nobody would call controlled.
pub const SLOT: Range = Range::new(0.001, 1.0, "s");
/// A horizon begins a slot or the longest loop delay after the request was sent, at whatever time that was.
pub const START: Range = Range::new(TIME.min, TIME.max + 10.0, "s");
/// No wheel turns faster (`robot::WHEEL_SPEED`), in either direction.
pub const WHEEL_SPEED: Range = Range::new(-1000.0, 1000.0, "rad/s");

/// Angular velocities of the two wheels, positive when driving the robot forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = step::WheelSpeeds)]
pub struct WheelSpeeds {
    /// Left wheel.
    #[serde(serialize_with = "number::finite")]
    pub left_rad_per_s: f64,
    /// Right wheel.
    #[serde(serialize_with = "number::finite")]
    pub right_rad_per_s: f64,
}

impl Checked for WheelSpeeds {
    fn check(&self, check: &mut Check) {
        check.number("left_rad_per_s", self.left_rad_per_s, WHEEL_SPEED);
        check.number("right_rad_per_s", self.right_rad_per_s, WHEEL_SPEED);
    }
}

impl From<geometry::WheelSpeeds> for WheelSpeeds {
    fn from(core: geometry::WheelSpeeds) -> Self {
        Self { left_rad_per_s: core.left, right_rad_per_s: core.right }
    }
}

/// Wheel speeds for consecutive slots, in robot time.
///
/// The robot plays the entry for now of the horizon with the highest sequence, holds the last one past the end for
/// `watchdog_s`, then ramps to rest by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = step::Horizon)]
pub struct Horizon {
    /// Number of this horizon, strictly increasing within an epoch: the highest wins.
    pub sequence: u64,
    /// Sequence of the request that it answers.
    pub answers: u64,
    /// Robot time at which the first entry begins.
    #[serde(serialize_with = "number::finite")]
    pub start_s: f64,
    /// Length of each entry.
    #[serde(serialize_with = "number::finite")]
    pub slot_s: f64,
    /// How long the last entry is held past the end; 0 holds for ever.
    #[serde(serialize_with = "number::finite")]
    pub watchdog_s: f64,
    /// Robot time after which the robot ramps to rest: end plus watchdog; null where it holds for ever.
    pub valid_until_s: Option<f64>,
    /// One entry per slot.
    pub wheel_speeds: Vec<WheelSpeeds>,
}

impl Checked for Horizon {
    fn check(&self, check: &mut Check) {
        check.integer("sequence", self.sequence, 0..=MAX_INTEGER);
        check.integer("answers", self.answers, 0..=MAX_INTEGER);
        check.number("start_s", self.start_s, START);
        check.number("slot_s", self.slot_s, SLOT);
        check.number("watchdog_s", self.watchdog_s, WATCHDOG);
        check.length("wheel_speeds", self.wheel_speeds.len(), 1..=MAX_SLOTS);
        check.items("wheel_speeds", &self.wheel_speeds);
    }
}

impl Horizon {
    /// The horizon to play. `valid_until_s` is for readers; the robot computes it from the rest.
    ///
    /// # Errors
    /// Every field that is out of its range: a robot plays nothing that it cannot believe.
    pub fn to_core(&self) -> Result<horizon::Horizon, Problems> {
        Check::all(self)?;
        let speeds = self.wheel_speeds.iter().map(|speeds| geometry::WheelSpeeds {
            left: speeds.left_rad_per_s,
            right: speeds.right_rad_per_s,
        });
        Ok(horizon::Horizon {
            sequence: self.sequence,
            answers: self.answers,
            start: RobotTime::new(self.start_s),
            slot: self.slot_s,
            watchdog: self.watchdog_s,
            speeds: speeds.collect(),
        })
    }
}

impl From<&horizon::Horizon> for Horizon {
    fn from(core: &horizon::Horizon) -> Self {
        Self {
            sequence: core.sequence,
            answers: core.answers,
            start_s: core.start.seconds(),
            slot_s: core.slot,
            watchdog_s: core.watchdog,
            valid_until_s: number::known(core.valid_until().seconds()),
            wheel_speeds: core.speeds.iter().copied().map(WheelSpeeds::from).collect(),
        }
    }
}

/// The answer to a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = step::Reply)]
pub struct Reply {
    /// What to play.
    pub horizon: Horizon,
    /// Whether the robot is told to rest until it is resumed.
    pub stopped: bool,
    /// What it is doing about its task.
    pub stage: task::Stage,
}
