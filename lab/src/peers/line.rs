//! The line of a leg, as methods see it that keep to one.

use std::f64::consts::PI;
use umwelt_core::controller::compensation::Way;
use umwelt_core::geometry::{Angle, Point, Pose};

/// A robot beside the line of its leg, as it travels: in reverse tail first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Distance in m to the left of the line.
    pub cross: f64,
    /// Direction of travel against the line in rad.
    pub heading: f64,
    /// Distance in m along the line to its end.
    pub ahead: f64,
}

/// A leg shorter than this in m has no direction to keep to.
const SHORTEST_LEG: f64 = 0.02;

impl Line {
    /// Of a robot on its way. A first leg has no line: it is the one from where the robot is.
    pub(super) fn of(way: &Way) -> Self {
        let from = way.from.filter(|from| from.distance(way.to) > SHORTEST_LEG);
        Self::between(from.unwrap_or(way.pose.point()), way.to, way.pose, way.reverse)
    }

    fn between(from: Point, to: Point, pose: Pose, reverse: bool) -> Self {
        let direction = (to.y - from.y).atan2(to.x - from.x);
        let (ahead, left) = Pose::new(pose.x, pose.y, direction).toward(to);
        let back = if reverse { PI } else { 0.0 };
        let heading = (pose.heading + back).minus(Angle::new(direction));
        Self { cross: -left, heading, ahead }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_core::geometry::Twist;

    fn way(pose: Pose, reverse: bool) -> Way {
        Way {
            pose,
            previous: Twist::ZERO,
            from: Some(Point::new(0.0, 0.0)),
            to: Point::new(if reverse { -2.0 } else { 2.0 }, 0.0),
            reverse,
            stoppable: 0.13,
            slowest: 0.023,
            is_raised: false,
            since_change: 0.03,
        }
    }

    #[test]
    fn a_line_is_seen_as_it_is_travelled() {
        let pose = Pose::new(0.5, 0.02, 0.1);
        let forward = Line::of(&way(pose, false));
        assert!((forward.cross - 0.02).abs() < 1e-12 && (forward.heading - 0.1).abs() < 1e-12);
        assert!((forward.ahead - 1.5).abs() < 1e-12);
        // Toward -x the left is at -y.
        let back = Line::of(&way(pose, true));
        assert!((back.cross + 0.02).abs() < 1e-12 && (back.heading - 0.1).abs() < 1e-12);
        assert!((back.ahead - 2.5).abs() < 1e-12);
    }
}
