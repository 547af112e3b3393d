//! What comes back from a step: the timed wheel speeds.

use super::TIME;
use crate::check::{Check, Range, Validate};
use crate::number;
use crate::robot::{Drive, MAX_INTEGER, MAX_SLOTS, WATCHDOG};
use crate::schema::ToSchema;
use crate::task;
use serde::{Deserialize, Serialize};

/// From a fast motor controller's cycle to that of a robot no one would call controlled.
pub const SLOT: Range = Range::new(0.001, 1.0, "s");
/// A horizon begins a slot or the longest loop delay after the request was sent, at whatever time that was.
pub const START: Range = Range::new(TIME.min, TIME.max + 10.0, "s");
/// No wheel turns faster (`robot::WHEEL_SPEED`), in either direction.
pub const WHEEL_SPEED: Range = Range::new(-1000.0, 1000.0, "rad/s");

/// Angular velocities of the two wheels, positive when driving the robot forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = WheelSpeeds)]
pub struct WheelSpeeds {
    /// Left wheel.
    #[serde(serialize_with = "number::finite")]
    pub left_rad_per_s: f64,
    /// Right wheel.
    #[serde(serialize_with = "number::finite")]
    pub right_rad_per_s: f64,
}

impl Validate for WheelSpeeds {
    fn check(&self, check: &mut Check) {
        check.number("left_rad_per_s", self.left_rad_per_s, WHEEL_SPEED);
        check.number("right_rad_per_s", self.right_rad_per_s, WHEEL_SPEED);
    }
}

/// Wheel speeds for consecutive slots, in robot time.
///
/// The robot plays the entry for now of the horizon with the highest sequence, holds the last one past the end for
/// `watchdog_s`, then ramps to rest by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Horizon)]
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

impl Validate for Horizon {
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

/// The answer to a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = StepReply)]
pub struct Reply {
    /// What to play.
    pub horizon: Horizon,
    /// Whether the robot is told to rest until it is resumed.
    pub stopped: bool,
    /// What it is doing about its task.
    pub stage: task::Stage,
    /// The drive by which the robot is to move; left out where the request has its tag, or does not ask for one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Box<TaggedDrive>>,
}

/// No wheels are told wrong by more without that being mended first.
pub const CORRECTION: Range = Range::new(1.0, 2.0, "");

/// The drive of a robot, as the server was told it, and the tag by which both sides know it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TaggedDrive)]
pub struct TaggedDrive {
    /// Another one with each drive, never 0.
    pub tag: u64,
    /// Geometry, limits and lag.
    pub drive: Drive,
    /// How many times its largest speeds the robot may be commanded, as described: what its wheels really do is identified,
    /// and commands are corrected by it. Left out where they are not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corrected_up_to: Option<f64>,
}

impl Validate for TaggedDrive {
    fn check(&self, check: &mut Check) {
        check.integer("tag", self.tag, 1..=MAX_INTEGER);
        if let Some(factor) = self.corrected_up_to {
            check.number("corrected_up_to", factor, CORRECTION);
        }
        check.field("drive", |check| self.drive.check(check));
    }
}
