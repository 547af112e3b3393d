//! The square by which a robot is calibrated (UMBmark), and its report.

mod report;

pub use report::{Direction, Ending, Error, Report, Return, Systematic};

use crate::check::{Check, Range, Validate};
use crate::robot::Drive;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// A side of 0.1 m shows nothing; one of 10 m needs a hall.
pub const SIDE: Range = Range::new(0.1, 10.0, "m");
/// The mean of five runs is known to less than half of what a single one is; more take an hour.
pub const MAX_RUNS: u64 = 5;
/// At less than a tenth of the largest speed a square takes an hour.
pub const SPEED_SHARE: Range = Range::new(0.1, 1.0, "");

/// The side in track widths where none is said, and the shortest and the longest in m.
const DERIVED: (f64, f64, f64) = (10.0, 0.5, 4.0);
/// Times the smallest speed described that is commanded at least.
const ABOVE_LEAST: f64 = 1.25;
/// Time in s that a robot takes to rest beside its dead time, and lags of it.
const SETTLING: (f64, f64) = (0.4, 5.0);
/// Time in s for which a robot at rest is seen after a motion, and at both ends of a run.
const REST: (f64, f64) = (0.6, 1.2);

/// A square driven to the left and to the right, whose return errors show how wheels and track differ from the description:
/// four sides and four quarter turns each way, open loop, with a rest after each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = TaskSquare)]
pub struct Square {
    /// Length of a side. Null or left out: ten track widths, at least 0.5 and at most 4 m.
    pub side_m: Option<f64>,
    /// Runs each way.
    pub runs: u32,
    /// Speed of sides and turns as a part of the largest one of the drive.
    pub speed_share: f64,
}

impl Default for Square {
    fn default() -> Self {
        Self { side_m: None, runs: 1, speed_share: 0.7 }
    }
}

impl Validate for Square {
    fn check(&self, check: &mut Check) {
        if let Some(side) = self.side_m {
            check.number("side_m", side, SIDE);
        }
        check.integer("runs", self.runs.into(), 1..=MAX_RUNS);
        check.number("speed_share", self.speed_share, SPEED_SHARE);
    }
}

impl Square {
    /// Length in m of a side of a robot with this drive.
    pub fn side_of_m(&self, drive: &Drive) -> f64 {
        let (tracks, shortest, longest) = DERIVED;
        self.side_m.unwrap_or((tracks * drive.track_width_m).clamp(shortest, longest))
    }

    /// Time in s that it takes, without ramps and the link.
    pub fn duration_s(&self, drive: &Drive) -> f64 {
        let wheels = drive.max_wheel_speed_rad_per_s * drive.wheel_radius_m;
        let speed = |largest: f64, least: f64| {
            (self.speed_share * largest).max(ABOVE_LEAST * least).min(largest)
        };
        let full = drive.max_linear_m_per_s.min(wheels);
        let linear = speed(full, drive.min_linear_m_per_s);
        let full = drive.max_angular_rad_per_s.min(2.0 * wheels / drive.track_width_m);
        let angular = speed(full, drive.min_angular_rad_per_s);
        let settling = SETTLING.0 + drive.dead_time_s + SETTLING.1 * drive.lag_s;
        let rests = 7.0 * (settling + REST.0) + 2.0 * (settling + REST.1);
        let turn = std::f64::consts::FRAC_PI_2;
        let motions = 4.0 * (self.side_of_m(drive) / linear + turn / angular);
        2.0 * f64::from(self.runs) * (motions + rests)
    }
}
