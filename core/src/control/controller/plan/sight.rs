//! A point as a robot sees it that turns in place about a centre ahead of its middle or behind it.

use crate::geometry::{Displacement, Point, Pose, length};
use std::f64::consts::FRAC_PI_2;

/// Times the distance of the turning centre from the middle within which a point counts as near to the centre: the robot
/// drives to it head or tail first, whichever it has there, and whether the task says reverse or not.
///
/// A middle that lies ahead of its centre is swung past what is near by any turn toward it.
const NEAR: f64 = 1.5;

/// A point as seen from a robot that stands at `pose`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pose: Pose,
    target: Point,
    /// How far the middle lies ahead of the turning centre.
    sideways: f64,
    /// How far in m the point lies ahead of the middle, and to its left.
    pub(super) ahead: f64,
    aside: f64,
    /// How far it is from the middle, and from the turning centre.
    pub(super) distance: f64,
    pub(super) range: f64,
    is_near: bool,
}

impl Sight {
    /// `target` as seen from `pose`, of a robot whose middle lies `sideways` m ahead of its turning centre.
    pub(super) fn new(pose: Pose, target: Point, sideways: f64) -> Self {
        let (ahead, aside) = pose.toward(target);
        let distance = length(ahead, aside);
        let range = if sideways == 0.0 { distance } else { length(ahead + sideways, aside) };
        let is_near = range < NEAR * sideways.abs();
        Self { pose, target, sideways, ahead, aside, distance, range, is_near }
    }

    fn ahead_of_centre(&self) -> f64 {
        if self.sideways == 0.0 { self.ahead } else { self.ahead + self.sideways }
    }

    /// Whether the robot is to drive there in reverse, where the task allows that.
    pub(super) fn is_behind(&self) -> bool {
        self.ahead_of_centre() < 0.0
    }

    /// Whether the robot is to drive there in reverse, where the task has it that way.
    pub(super) fn reverse(&self, task: bool) -> bool {
        if self.is_near { self.ahead < 0.0 } else { task }
    }

    /// The turn in place in rad after which the robot drives straight to the point; it may have its tail there where it may
    /// `reverse`.
    pub(super) fn turn(&self, reverse: bool) -> f64 {
        heading_error(self.ahead_of_centre(), self.aside, reverse || self.is_near)
    }

    /// How far off the heading the point lies in rad, from where that is less: as a centre passes over the point that the
    /// middle is still to come to, its own direction means nothing.
    pub(super) fn off_heading(&self, reverse: bool) -> f64 {
        let turn = self.turn(reverse).abs();
        if self.sideways == 0.0 {
            return turn;
        }
        turn.min(heading_error(self.ahead, self.aside, reverse || self.is_near).abs())
    }

    /// From where and to where the robot is steered: the hindmost of middle and turning centre goes to the point, straight
    /// once the centre has passed it.
    pub(super) fn steered(&self, reverse: bool) -> (Pose, Point) {
        let Self { pose, target, sideways, ahead, .. } = *self;
        let lead = if reverse { -sideways } else { sideways };
        let forward = |forward| Displacement { forward, ..Displacement::default() };
        if lead > 0.0 {
            return (pose.then(forward(-sideways)), target);
        }
        let has_passed = lead < 0.0 && self.ahead_of_centre() * ahead <= 0.0;
        (pose, if has_passed { pose.then(forward(ahead)).point() } else { target })
    }
}

/// The turn in rad that points the robot, or its tail where it may reverse to what lies behind, at a point.
fn heading_error(ahead: f64, aside: f64, reverse: bool) -> f64 {
    let error = aside.atan2(ahead);
    if reverse && error.abs() > FRAC_PI_2 { (-aside).atan2(-ahead) } else { error }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Guards against: a robot that turns in place for ever, because it turns about another point than it aims from.
        #[test]
        fn after_the_turn_the_point_lies_straight_ahead_or_behind(
            (x, y, heading) in (-0.5..0.5f64, -0.5..0.5f64, -3.0..3.0f64),
            sideways in -0.1..0.1f64,
            reverse: bool,
        ) {
            let (pose, target) = (Pose::new(0.1, 0.2, heading), Point::new(x, y));
            let sight = Sight::new(pose, target, sideways);
            prop_assume!(sight.range > 1e-3);
            let centre = pose.then(Displacement { forward: -sideways, ..Displacement::default() });
            let turned = centre.then(Displacement { turn: sight.turn(reverse), ..Displacement::default() });
            let after = turned.then(Displacement { forward: sideways, ..Displacement::default() });
            let seen = Sight::new(after, target, sideways);
            prop_assert!(seen.aside.abs() < 1e-9 && (seen.range - sight.range).abs() < 1e-9);
            prop_assert!(seen.off_heading(reverse) < 1e-6);
            // Forward, unless the task allows the other or the point is about as near as the turning centre.
            let goes_back = seen.reverse(reverse && seen.is_behind());
            prop_assert!(reverse || sight.is_near || !goes_back);
            prop_assert!(goes_back == (seen.ahead < 0.0) || seen.distance < 1e-9, "{seen:?}");
        }

        #[test]
        fn where_middle_and_centre_are_one_it_is_seen_from_there(
            (x, y, heading) in (-0.5..0.5f64, -0.5..0.5f64, -3.0..3.0f64),
            reverse: bool,
        ) {
            let (pose, target) = (Pose::new(0.1, 0.2, heading), Point::new(x, y));
            let sight = Sight::new(pose, target, 0.0);
            let (ahead, aside) = pose.toward(target);
            prop_assert_eq!(sight.turn(reverse), heading_error(ahead, aside, reverse));
            prop_assert_eq!(sight.off_heading(reverse), sight.turn(reverse).abs());
            prop_assert_eq!(sight.steered(reverse), (pose, target));
            prop_assert_eq!((sight.distance, sight.reverse(reverse)), (sight.range, reverse));
        }
    }
}
