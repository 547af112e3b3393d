//! The check of a robot: the wiggle that a task may be, and its report.

mod report;

pub use report::{Fault, Finding, Report};

use crate::check::{Check, Range, Validate};
use crate::robot::Drive;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// A motion at less than a tenth of the largest speed is hard to see.
pub const SPEED_SHARE: Range = Range::new(0.1, 1.0, "");
/// The noise of the poses takes a second to be seen; more than ten say nothing new.
pub const REST: Range = Range::new(1.0, 10.0, "s");
/// A turn or a drive of less than half a second is hard to see, and one of ten needs much room.
pub const MOTION: Range = Range::new(0.5, 10.0, "s");
/// A rest is a few poses; one of more than five seconds says nothing new.
pub const PAUSE: Range = Range::new(0.4, 5.0, "s");

/// Angular velocity in rad/s that is enough.
const TURN: f64 = 0.375;
/// Times the smallest speed described that is commanded at least.
const ABOVE_LEAST: f64 = 1.25;
/// Length in m of a drive that is enough, and the same in track widths.
const LENGTH: (f64, f64) = (0.15, 0.4);
/// Rest in s after the last motion, beside the delay described.
const LAST_REST: f64 = 1.7;
/// Turns of the wiggle in turns of the first one, and its drives.
const TURNS_AND_DRIVES: (f64, f64) = (4.0, 4.0);
/// Rests between its motions.
const PAUSES: f64 = 6.0;

/// A wiggle by which is found what is wrong with robot or tracker: rest, turn left, ahead, back, turn right twice as far,
/// ahead, back, turn left, each followed by a rest. The defaults take some 20 s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = TaskCheck)]
pub struct Wiggle {
    /// Speed of turns and drives as a part of the largest one of the drive; what is faster than the check needs is slowed
    /// down.
    pub speed_share: f64,
    /// Time of the rest before the first motion.
    pub rest_s: f64,
    /// Time of a turn in place; the one in the middle takes twice as long.
    pub turn_s: f64,
    /// Time of each drive.
    pub drive_s: f64,
    /// Time of the rest between two motions.
    pub pause_s: f64,
}

impl Default for Wiggle {
    fn default() -> Self {
        Self { speed_share: 0.7, rest_s: 2.0, turn_s: 2.0, drive_s: 1.2, pause_s: 0.6 }
    }
}

impl Validate for Wiggle {
    fn check(&self, check: &mut Check) {
        check.number("speed_share", self.speed_share, SPEED_SHARE);
        check.number("rest_s", self.rest_s, REST);
        check.number("turn_s", self.turn_s, MOTION);
        check.number("drive_s", self.drive_s, MOTION);
        check.number("pause_s", self.pause_s, PAUSE);
    }
}

impl Wiggle {
    /// How far in m a robot with this drive drives from where it stands, in either of two directions and back.
    pub fn length_m(&self, drive: &Drive) -> f64 {
        let wheels = drive.max_wheel_speed_rad_per_s * drive.wheel_radius_m;
        let full = drive.max_linear_m_per_s.min(wheels);
        let enough = LENGTH.0.max(LENGTH.1 * drive.track_width_m) / self.drive_s;
        let speed = enough.min(self.speed_share * full);
        speed.max(ABOVE_LEAST * drive.min_linear_m_per_s).min(full) * self.drive_s
    }

    /// How far in rad it turns to either side.
    pub fn turn_rad(&self, drive: &Drive) -> f64 {
        let wheels = drive.max_wheel_speed_rad_per_s * drive.wheel_radius_m;
        let full = drive.max_angular_rad_per_s.min(2.0 * wheels / drive.track_width_m);
        let speed = TURN.min(self.speed_share * full);
        speed.max(ABOVE_LEAST * drive.min_angular_rad_per_s).min(full) * self.turn_s
    }

    /// Time in s that it takes, without ramps and the link.
    pub fn duration_s(&self, drive: &Drive) -> f64 {
        let (turns, drives) = TURNS_AND_DRIVES;
        let moving = turns * self.turn_s + drives * self.drive_s;
        let rest = self.rest_s + PAUSES * self.pause_s + LAST_REST;
        moving + rest + drive.lag_s + drive.dead_time_s
    }
}
