//! The motions of a square: each comes to exactly what it is to be, whenever plans begin.

use super::super::compensation::PathFollower;
use super::phase::Phase;
use super::roll::Roll;
use crate::geometry::Twist;
use crate::geometry::elementary::least;
use crate::settings::Settings;
use crate::square::{Course, Limits, Part, pace};
use crate::task::Task;
use crate::time::RobotTime;

/// What differs by less than this many s, m or rad is done.
const SAME: f64 = 1e-6;

impl<F: PathFollower> Roll<'_, F> {
    /// The `part` of a `run` of a square, of which so much was `done` at `at`; at rest after the last, until the run was seen
    /// to end.
    pub(super) fn square(
        &mut self,
        task: &Task,
        (run, part): (u32, u32),
        at: Option<RobotTime>,
        done: f64,
    ) -> Option<Twist> {
        let course = task.square.map(|square| Course::new(square, &self.settings.drive))?;
        let Some(motion) = course.part(run, part) else { return Some(Twist::ZERO) };
        let (previous, fastest) = (self.state.previous, course.fastest());
        let past = at.map_or(0.0, |at| self.state.time - at);
        let (done, whole) = match motion {
            Part::Rest(seconds) => (if self.rests() { done + past } else { 0.0 }, seconds),
            Part::Side(length) => (done + past * previous.linear, length),
            Part::Turn(angle) => (done + past * previous.angular * angle.signum(), angle.abs()),
        };
        let remaining = whole - done;
        if remaining <= SAME {
            self.state.phase = Phase::Squaring { run, part: part + 1, at: None, done: 0.0 };
            return None;
        }
        self.state.phase = Phase::Squaring { run, part, at: Some(self.state.time), done };
        let Settings { drive, slot, .. } = self.settings;
        // A plan may take the place of one that began at the same moment within a slot: it may change no more than that.
        let first = if past > 0.0 { least(self.state.since_change, past) } else { *slot };
        let pace = |fastest, free, acceleration, previous: f64| {
            let limits = Limits { fastest, least: free, acceleration, slot: *slot, first };
            pace(&limits, previous.abs(), remaining)
        };
        Some(match motion {
            Part::Rest(_) => Twist::ZERO,
            Part::Side(_) => {
                let (free, acceleration) = (drive.min_linear, drive.max_linear_acceleration);
                Twist::new(pace(fastest.linear, free, acceleration, previous.linear), 0.0)
            }
            Part::Turn(angle) => {
                let (free, acceleration) = (drive.min_angular, drive.max_angular_acceleration);
                let speed = pace(fastest.angular, free, acceleration, previous.angular);
                Twist::new(0.0, speed.copysign(angle))
            }
        })
    }
}
