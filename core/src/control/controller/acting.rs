//! The settings as they are over the link and with the drive as both are identified, as far as they are not described.

use super::Controller;
use super::compensation::{DelayModel, MAX_AHEAD, PathFollower, PoseEstimator};
use crate::derived;
use crate::horizon::SLOT;
use crate::kinematics::Drive;
use crate::settings::Settings;

/// A change of the loop delay in s that is more than the jitter of a link.
const OTHER_DELAY: f64 = 2.0 * SLOT;

/// Step in s in which an identified loop delay is followed.
const DELAY_STEP: f64 = 0.01;

/// A change in s of dead time and lag together from which on a drive is another one: what it taught meanwhile is wrong.
const OTHER_DRIVE: f64 = 0.015;

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
        let drive = follows.belief.acting(&described);
        let acting = Drive { lag: acting.lag, dead_time: acting.dead_time, ..described };
        let (sum, lag) = SAME_DRIVE;
        let is_same =
            (late(&drive) - late(&acting)).abs() < sum && (drive.lag - acting.lag).abs() < lag;
        if is_same { acting } else { drive }
    }
}

/// How late a drive follows, in s.
fn late(drive: &Drive) -> f64 {
    drive.dead_time + drive.lag
}
