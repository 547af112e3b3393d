//! A waypoint that was missed by little: what a robot does that stands a few tolerances off.
//!
//! It drives ahead or in reverse on an arc where the waypoint lies within a cone before or behind it, whose edges pass the
//! waypoint at half its tolerance. Otherwise it turns, head or tail first, whichever is nearer, and no further than into that
//! cone. Two arcs, out and back in an S, would displace it aside without a turn: by y they take 4 sqrt(y/(v w)) + 2 v/a at a
//! speed v and a rate of turn w, for the thesis's robot and 10 mm as long as the turn takes, and stray by 2 sqrt(y v/w), which
//! is five times as far. So it turns.

use super::super::compensation::PathFollower;
use super::roll::Roll;
use crate::geometry::elementary::least;
use crate::geometry::{Point, Twist, length};
use crate::kinematics::MotionModel;
use crate::settings::Method;
use crate::steering;
use crate::task::Task;

/// Tolerances from a waypoint within which it was missed by little.
const NEAR: f64 = 3.0;

/// Part of the tolerance by which the way there may pass the waypoint aside.
const ASIDE: f64 = 0.5;

impl<F: PathFollower> Roll<'_, F> {
    /// Whether a robot that would come to rest where it is predicted to has missed `target` by little.
    fn is_near(&self, task: &Task, target: Point) -> bool {
        // One that turns about another point has a way of its own; one that does not move slowly strays by arcs.
        self.settings.method == Method::Adaptive
            && self.floors.is_none()
            && self.settings.drive.sideways() == 0.0
            && self.coasted().point().distance(target) <= NEAR * task.tolerance
    }

    /// Whether `target` may lie behind the robot that turns to it: where the task says so, and where it was missed by little.
    pub(super) fn may_reverse(&self, task: &Task, target: Point) -> bool {
        task.reverse || self.is_near(task, target)
    }

    /// Whether the robot is to drive to `target` in reverse. Within the tolerance it keeps its direction: what it passes there
    /// it has reached.
    pub(super) fn reverses(&self, task: &Task, target: Point) -> bool {
        let pose = self.coasted();
        let (ahead, _) = pose.toward(target);
        let speed = self.state.previous.linear;
        if !self.is_near(task, target) {
            task.reverse && self.sight(target).is_behind()
        } else if speed != 0.0 && pose.point().distance(target) <= task.tolerance {
            speed < 0.0
        } else {
            ahead < 0.0
        }
    }

    /// Heading error in rad up to which driving straight on passes `target` well within the tolerance, where it was missed by
    /// little: asin(tolerance/2 / distance). Otherwise none is good enough, which is 0.
    pub(super) fn good_enough(&self, task: &Task, target: Point) -> f64 {
        if !self.is_near(task, target) {
            return 0.0;
        }
        let distance = self.coasted().point().distance(target);
        (ASIDE * task.tolerance / distance).min(1.0).asin()
    }

    /// The twist along the arc that leads from the heading, or the tail, to `target`, where that was missed by little: the quadratic curve
    /// is as slow there as it bends, alpha/(1 + |a| 1 m), which is far below what robot and way allow.
    ///
    /// Its curvature is 2 e_y/(e_x^2 + e_y^2). The speed is the fastest from which the robot can stop, and at which it can turn
    /// enough to pass the waypoint well within the tolerance.
    pub(super) fn arc(&self, task: &Task, target: Point, reversing: bool) -> Option<Twist> {
        if !self.is_near(task, target) {
            return None;
        }
        let (drive, law) = (&self.settings.drive, &self.settings.steering);
        let (ahead, aside) = self.coasted().toward(target);
        let distance = length(ahead, aside);
        let bend = 2.0 * aside / (distance * distance);
        let stoppable = steering::stopping_speed(
            distance - law.stop_radius / 2.0,
            drive.max_linear_acceleration,
            self.settings.slot,
        );
        let off = (aside.abs() - ASIDE * task.tolerance).max(0.0);
        let speed = least(stoppable, drive.max_angular * distance * distance / (2.0 * off));
        let speed = speed.clamp(self.least.linear, drive.max_linear);
        let onward = if reversing { -speed } else { speed };
        let wanted = Twist::new(onward, 0.0);
        let reached = drive.reach(self.state.previous, wanted, self.state.since_change).linear;
        let angular = (bend * reached).clamp(-drive.max_angular, drive.max_angular);
        Some(Twist::new(reached, angular))
    }
}
