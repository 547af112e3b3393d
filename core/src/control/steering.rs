//! The steering law: quadratic curve to a point, forward or in reverse, and the speeds from which one can stop.

use crate::geometry::Twist;

/// Length in m that makes the curvature of thesis eq. 18 a plain number.
const CURVE_LENGTH: f64 = 1.0;

/// The twist that follows a quadratic curve to the point `ahead` m forward and `aside` m to the left
/// (e_x, e_y of thesis eq. 14), at the law's own speed.
///
/// a = e_y/e_x^2; v = sign(e_x) alpha/(1 + |a| 1 m); omega = 2 a v. Thesis eq. 15-18, corrected: as printed, the
/// sign of e_x stands in both factors of omega and cancels, so that a reversing robot steers away from its path.
/// At e_x = 0 the robot turns in place. The law does not slow down near the point: [`stopping_speed`] does.
///
/// ```
/// use umwelt_core::steering::curve;
/// let ahead = curve(0.5, 0.1, 0.13);
/// assert!(ahead.linear > 0.0 && ahead.angular > 0.0); // to the left
/// let behind = curve(-0.5, 0.1, 0.13);
/// assert!(behind.linear < 0.0 && behind.angular < 0.0); // the tail swings left
/// ```
pub fn curve(ahead: f64, aside: f64, alpha: f64) -> Twist {
    let bend = aside / (ahead * ahead);
    if !bend.is_finite() {
        // Its limit for e_x -> 0: |a| v -> alpha/(1 m).
        let side = if aside == 0.0 { 0.0 } else { aside.signum() };
        return Twist::new(0.0, side * 2.0 * alpha / CURVE_LENGTH);
    }
    let linear = alpha.copysign(ahead) / (1.0 + bend.abs() * CURVE_LENGTH);
    Twist::new(linear, 2.0 * bend * linear)
}

/// The fastest speed for the next slot from which a constant deceleration still stops within `distance`.
///
/// Thesis eq. 21 with the slot itself counted: v dt + v^2/(2 a) <= distance. For speed and heading alike.
pub fn stopping_speed(distance: f64, deceleration: f64, slot: f64) -> f64 {
    let lost = deceleration * slot;
    (lost * lost + 2.0 * deceleration * distance.max(0.0)).sqrt() - lost
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Pose};
    use crate::kinematics::integrate;
    use proptest::prelude::*;

    /// Follows the law in small steps until the point is near; how near it came.
    fn nearest(start: Pose, target: Point) -> f64 {
        let (mut pose, mut nearest) = (start, f64::INFINITY);
        for _ in 0..20_000 {
            let (ahead, aside) = pose.toward(target);
            nearest = nearest.min(ahead.hypot(aside));
            pose = pose.then(integrate(curve(ahead, aside, 0.13), 0.002));
        }
        nearest
    }

    #[test]
    fn the_curve_starts_as_the_parabola() {
        // y = a x^2 has curvature 2a at its vertex: omega/v.
        let twist = curve(0.4, 0.08, 0.13);
        assert!((twist.angular / twist.linear - 2.0 * 0.08 / 0.16).abs() < 1e-12);
    }

    #[test]
    fn beside_the_robot_it_turns_in_place() {
        assert_eq!(curve(0.0, 0.1, 0.13), Twist::new(0.0, 0.26));
        assert_eq!(curve(0.0, -0.1, 0.13), Twist::new(0.0, -0.26));
        assert_eq!(curve(0.0, 0.0, 0.13), Twist::ZERO);
    }

    proptest! {
        /// Guards against the law as printed in the thesis: in reverse the robot steers away from its path.
        #[test]
        fn it_reaches_points_ahead_and_behind(x in 0.2..1.0f64, y in -0.3..0.3f64, h in -3.0..3.0f64, reverse in any::<bool>()) {
            let start = Pose::new(0.0, 0.0, h);
            let (x, y) = if reverse { (-x, y) } else { (x, y) };
            let (sin, cos) = h.sin_cos();
            let target = Point::new(cos * x - sin * y, sin * x + cos * y);
            prop_assert!(nearest(start, target) < 0.01);
        }

        #[test]
        fn reversing_mirrors_driving(x in 0.05..1.0f64, y in -0.3..0.3f64) {
            let (forward, back) = (curve(x, y, 0.13), curve(-x, y, 0.13));
            prop_assert_eq!(forward.linear, -back.linear);
            prop_assert_eq!(forward.angular, -back.angular);
        }

        #[test]
        fn the_stopping_speed_stops_in_time(distance in 0.0..1.0f64, a in 0.05..3.0f64) {
            let v = stopping_speed(distance, a, 0.03);
            prop_assert!(v >= 0.0);
            prop_assert!((v * 0.03 + v * v / (2.0 * a) - distance).abs() < 1e-9);
        }
    }
}
