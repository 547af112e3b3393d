//! The settings as they are over the link and with the drive as both are identified, as far as they are not described.

use super::Controller;
use super::compensation::{DelayModel, MAX_AHEAD, PathFollower, PoseEstimator};
use crate::derived;
use crate::drive::DriveBelief;
use crate::horizon::SLOT;
use crate::kinematics::Drive;
use crate::prediction::Scale;
use crate::settings::{Method, Settings};

/// A change of the loop delay in s that is more than the jitter of a link.
const OTHER_DELAY: f64 = 2.0 * SLOT;

/// Step in s in which an identified loop delay is followed.
const DELAY_STEP: f64 = 0.01;

/// A change in s of dead time and lag together from which on a drive is another one: what it taught meanwhile is wrong.
const OTHER_DRIVE: f64 = 0.015;

/// Times its largest speeds that a robot is commanded at most, as described, where its wheels do less than that: what asks for
/// more is to be described anew.
pub const MOST_CORRECTED: f64 = 1.5;

/// Factor by which a robot's wheels or track may be off at most: what seems to be more is something else.
const MOST_SCALED: f64 = 3.0;

/// The same for the difference of the wheels, as a part of their mean.
const MOST_UNEQUAL: f64 = 0.3;

/// Standard deviations above the mean that are exceeded once in a hundred times.
const SURELY: f64 = 2.326;

/// Changes of that sum, and of the lag in it, that matter to no one.
const SAME_DRIVE: (f64, f64) = (0.002, 0.01);

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// Plans for link and drive as they are identified now.
    pub(super) fn act(&mut self) {
        let before = self.acting;
        let drive = self.identified_drive(&before.drive);
        let median = self.belief.link.median().filter(|_| self.settings.follows_link.loop_delay);
        let acting = median.map_or(self.settings, |median| {
            // What differs by less matters to no one, and plans that begin at other times are other plans.
            let loop_delay = (median / DELAY_STEP).ceil() * DELAY_STEP;
            derived::over_link(&self.settings, loop_delay.min(MAX_AHEAD))
        });
        self.acting = Settings { drive, ..acting };
        // What was sent for another delay was not played when that was thought: it says nothing of the floor.
        let is_other_link = (self.acting.loop_delay - before.loop_delay).abs() > OTHER_DELAY;
        if is_other_link {
            self.teaches_from = None;
        }
        if is_other_link || (late(&drive) - late(&before.drive)).abs() > OTHER_DRIVE {
            self.take_back();
        }
    }

    /// The drive as it is identified, where it has been `acting` so far.
    fn identified_drive(&self, acting: &Drive) -> Drive {
        let described = self.settings.drive;
        let Some(follows) = &self.follows else { return described };
        let drive = follows.late(&described);
        let acting = Drive { lag: acting.lag, dead_time: acting.dead_time, ..described };
        let (sum, lag) = SAME_DRIVE;
        let is_same =
            (late(&drive) - late(&acting)).abs() < sum && (drive.lag - acting.lag).abs() < lag;
        let drive = if is_same { acting } else { drive };
        self.scaled_belief().map_or(drive, |belief| scaled(&drive, belief))
    }

    /// What is believed of how the drive differs from its description, where commands are corrected by that. A square is
    /// driven as described: it shows what the description is worth.
    pub(super) fn scaled_belief(&self) -> Option<&DriveBelief> {
        let is_square = self.task.as_ref().is_some_and(|task| task.square.is_some());
        let is_corrected = self.settings.method == Method::Adaptive && !is_square;
        Some(self.follows.as_ref().filter(|_| is_corrected)?.belief())
    }
}

/// `drive` with wheels and track as they move the robot. Its largest speeds are what the robot may do, not what its wheels
/// are told: as long as the scale is not known well they are divided by how much larger it may be.
fn scaled(drive: &Drive, belief: &DriveBelief) -> Drive {
    let (Scale { forward, turn, drift }, sd) = (belief.scale(), belief.scale_sd());
    let bounded = |scale: f64| (1.0 + scale).clamp(MOST_SCALED.recip(), MOST_SCALED);
    let (forward, turn) = (bounded(forward), bounded(turn));
    let larger = |factor: f64, sd: f64| 1.0 + SURELY * sd.max(0.0) / factor;
    let track_width = drive.track_width * forward / turn;
    let unequal = (drift * track_width / forward).clamp(-MOST_UNEQUAL, MOST_UNEQUAL);
    if !(forward.is_finite() && turn.is_finite() && unequal.is_finite()) {
        return *drive;
    }
    Drive {
        wheel_radius: drive.wheel_radius * forward,
        track_width,
        unequal: drive.unequal + unequal,
        max_linear: drive.max_linear
            * (MOST_CORRECTED * forward).min(larger(forward, sd.forward).recip()),
        max_angular: drive.max_angular * (MOST_CORRECTED * turn).min(larger(turn, sd.turn).recip()),
        // The motors stand below a speed of the wheels.
        min_linear: drive.min_linear * forward,
        min_angular: drive.min_angular * turn,
        // The robot itself holds its wheels to the accelerations that are described.
        max_linear_acceleration: drive.max_linear_acceleration * forward.min(1.0),
        max_angular_acceleration: drive.max_angular_acceleration * turn.min(1.0),
        ..*drive
    }
}

/// How late a drive follows, in s.
fn late(drive: &Drive) -> f64 {
    drive.dead_time + drive.lag
}
