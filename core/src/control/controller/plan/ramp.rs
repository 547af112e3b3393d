//! The ramp before a calibration: turning in place to and fro, faster and faster, each speed for long enough to see whether the wheels
//! turn, up to the first at which they surely do. It shows the dead band where that is to be identified.

use super::super::compensation::PathFollower;
use super::phase::Phase;
use super::roll::Roll;
use crate::drive::shows;
use crate::geometry::Twist;
use crate::task::Task;
use crate::time::RobotTime;

/// Speed of the wheels in rad/s at the first level: below the smallest of any robot here.
const FIRST: f64 = 0.3;

/// From level to level it grows by this factor.
const STEP: f64 = 1.3;

/// Part of the largest turn at which it ends: what stands there is stuck.
const LAST: f64 = 0.95;

/// Speeds in rad/s that differ by less than this are the same.
const SAME_SPEED: f64 = 1e-6;

/// Longest time in s beside that of following for one level: where the noise of the poses asks for more nothing is shown.
const LONGEST_LEVEL: f64 = 1.5;

impl<F: PathFollower> Roll<'_, F> {
    /// Whether wheels may stand at the speeds of a ramp.
    pub(super) fn is_worth_a_ramp(&self) -> bool {
        self.settings.identifies_band() && self.level(0).is_some()
    }

    /// The turn in rad/s of a level; none where there is nothing more to see.
    fn level(&self, level: u32) -> Option<f64> {
        let drive = &self.settings.drive;
        let wheels = FIRST * STEP.powi(level.min(64) as i32);
        let angular = 2.0 * drive.wheel_radius / drive.track_width * wheels;
        let is_worth = wheels <= self.state.may_stand && angular <= LAST * drive.max_angular;
        is_worth.then_some(angular)
    }

    /// The level of a ramp; then the rotations of the calibration.
    pub(super) fn ramp(
        &mut self,
        task: &Task,
        level: u32,
        since: Option<RobotTime>,
    ) -> Option<Twist> {
        let angular = self.level(level).filter(|_| task.calibration.is_some());
        let Some(angular) = angular else {
            self.state.phase = Phase::Calibrating { turn: 0, since: Some(self.state.time) };
            return None;
        };
        // To and fro, so that it ends about as it began.
        let side = if level.is_multiple_of(2) { 1.0 } else { -1.0 };
        let twist = self.settings.drive.limited(Twist::new(0.0, side * angular));
        let is_reached = (self.state.previous.angular - twist.angular).abs() < SAME_SPEED;
        let since = since.or_else(|| is_reached.then_some(self.state.time));
        let shown = (shows(angular, self.settings.noise) + self.state.between).min(LONGEST_LEVEL);
        if since.is_some_and(|since| self.has_passed(since, self.state.settles + shown)) {
            self.state.phase = Phase::Ramping { level: level + 1, since: None };
            return None;
        }
        self.state.phase = Phase::Ramping { level, since };
        Some(twist)
    }

    /// The speed in rad/s of a rotation that is to be as fast as `wanted`: where the dead band is identified no slower than
    /// the wheels turn.
    pub(super) fn turning_speed(&self, wanted: f64) -> f64 {
        let least = if self.settings.identifies_band() { self.least.angular } else { 0.0 };
        wanted.max(least.min(self.settings.drive.max_angular))
    }
}
