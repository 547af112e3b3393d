//! The straight part of a calibration: ahead and back, unsteered. Whatever the heading does, it ends where the robot is beside
//! the point that it was to come to.

use super::super::compensation::PathFollower;
use super::phase::{Phase, REST_SLOTS};
use super::roll::Roll;
use crate::geometry::{Displacement, Pose, Twist};
use crate::steering;
use crate::task::{Limit, Task};
use crate::time::RobotTime;

impl<F: PathFollower> Roll<'_, F> {
    /// The way out or back; at its end since `since`.
    pub(super) fn straight(
        &mut self,
        task: &Task,
        outbound: bool,
        origin: Pose,
        since: Option<RobotTime>,
    ) -> Option<Twist> {
        let forward = task.calibration.map_or(0.0, |calibration| calibration.straight);
        let ahead = Displacement { forward, ..Displacement::default() };
        let (target, side) = if outbound { (origin.then(ahead), 1.0) } else { (origin, -1.0) };
        let remaining = side * self.coasted().toward(target.point()).0;
        let (drive, law) = (&self.settings.drive, &self.settings.steering);
        let (overrun, _) = self.floors.overrun(drive, self.state.previous);
        if since.is_none() && remaining > law.stop_radius + overrun {
            let stoppable = steering::stopping_speed(
                remaining - law.stop_radius / 2.0,
                drive.max_linear_acceleration,
                self.settings.slot,
            );
            let fastest = drive.max_linear.min(law.alpha);
            let speed = stoppable.max(self.least.linear).min(fastest);
            self.limit = Some(if speed < fastest { Limit::Waypoint } else { Limit::Drive });
            return Some(Twist::new(side * speed, 0.0));
        }
        let since = since.unwrap_or(self.state.time);
        if self.rests() && self.has_passed(since, f64::from(REST_SLOTS) * self.settings.slot) {
            self.state.phase = if outbound {
                Phase::Straight { outbound: false, origin, since: None }
            } else {
                Phase::Settling
            };
            return None;
        }
        self.state.phase = Phase::Straight { outbound, origin, since: Some(since) };
        Some(Twist::ZERO)
    }
}
