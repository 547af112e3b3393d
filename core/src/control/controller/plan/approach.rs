//! The way to a point: drive, turn, or be there.

use super::super::compensation::{PathFollower, Way};
use super::roll::Roll;
use super::sight::Sight;
use crate::geometry::{Point, Twist};
use crate::kinematics::MotionModel;
use crate::steering;
use crate::task::Limit;

/// A parabola that starts with a heading error strays from its chord by this part of error x distance.
pub(super) const STRAY: f64 = 0.25;

/// What the way to a point asks for.
pub(super) enum Approach {
    /// The robot is there, or as near as it gets.
    Reached,
    /// The point lies too far off the heading to be driven to.
    OffHeading,
    /// Drive, and what limits the speed.
    Go(Twist, Limit),
}

impl<F: PathFollower> Roll<'_, F> {
    /// A point as it is seen from the pose to which the robot coasts.
    pub(super) fn sight(&self, target: Point) -> Sight {
        Sight::new(self.coasted(), target, self.settings.drive.sideways())
    }

    /// The way to `target`, forward or in reverse, from the pose to which the robot coasts; `from` is where the leg
    /// begins.
    pub(super) fn approach(
        &self,
        from: Option<Point>,
        target: Point,
        reverse: bool,
        tolerance: f64,
    ) -> Approach {
        let (drive, law) = (&self.settings.drive, &self.settings.steering);
        let sight = self.sight(target);
        let (reverse, distance) = (sight.reverse(reverse), sight.distance);
        let onward = if reverse { -sight.ahead } else { sight.ahead };
        let error = sight.off_heading(reverse);
        // Far off, or off by so much at so great a distance that the curve would leave the path: as after a silence
        // in the middle of a turn. Close to the point neither is worth a stop.
        let strays = error > 2.0 * law.turn_tolerance && STRAY * error * distance > tolerance;
        let off_heading = error > law.turn_beyond || strays;
        let passed = onward <= 0.0;
        let (overrun, _) = self.floors.overrun(drive, self.state.previous);
        if distance <= law.stop_radius + overrun
            || (distance <= tolerance && (passed || off_heading))
        {
            return Approach::Reached;
        }
        if passed || off_heading {
            return Approach::OffHeading;
        }
        let stoppable = steering::stopping_speed(
            distance - law.stop_radius / 2.0,
            drive.max_linear_acceleration,
            self.settings.slot,
        );
        let (pose, to) = sight.steered(reverse);
        let way = Way {
            pose,
            previous: self.state.previous,
            from,
            to,
            reverse,
            stoppable,
            slowest: self.least.linear,
            is_raised: !self.floors.is_none(),
            since_change: self.state.since_change,
        };
        let (twist, limit) = self.follower.steer(self.settings, &way);
        Approach::Go(twist, limit)
    }
}
