//! The two angles of UMBmark: what the return errors of both directions say of turns and of straight ways.

use crate::geometry::Point;
use crate::geometry::elementary::{sin_cos, sinc_cos};
use std::f64::consts::FRAC_PI_2;

/// Times that the formulas of first order are applied to what is left.
const STEPS: u32 = 60;

/// Error in rad of a quarter turn and a side together beyond which the figure driven is no square.
const LARGEST: f64 = 0.4;

/// What is left in m, per m of the side, where the angles are found.
const FOUND: f64 = 1e-9;

/// By how much a quarter turn falls short, and by how much a side bends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angles {
    /// Type A, alpha in rad: a quarter turn is 90 degrees less alpha, to the left and to the right alike.
    pub alpha: f64,
    /// Type B, beta in rad: a side bends by beta, to the left where positive.
    pub beta: f64,
}

impl Angles {
    /// The angles of first order, as the paper has them: errors (x, y) in m of the centres of gravity of runs to the left and to the
    /// right, in the frame of their start, with sides of `side` m.
    ///
    /// alpha = (x_cw + x_ccw)/(-4L) = (y_cw - y_ccw)/(-4L), beta = (x_cw - x_ccw)/(-4L) = (y_cw + y_ccw)/(-4L): of each pair
    /// the mean.
    fn of_first_order(left: Point, right: Point, side: f64) -> Self {
        let of = |by_x: f64, by_y: f64| f64::midpoint(by_x, by_y) / (-4.0 * side);
        Self {
            alpha: of(right.x + left.x, right.y - left.y),
            beta: of(right.x - left.x, right.y + left.y),
        }
    }

    /// The angles whose square ends where it was seen to; none where that is no square.
    ///
    /// The formulas of the paper are of first order, and 3 % of track make 5 % of alpha. They are applied to what the angles
    /// so far leave over, until nothing is left.
    pub fn of(left: Point, right: Point, side: f64) -> Option<Self> {
        let mut angles = Self::default();
        for _ in 0..STEPS {
            let [of_left, of_right] = [true, false].map(|is_left| angles.returns_to(is_left, side));
            let rest = |seen: Point, at: Point| Point::new(seen.x - at.x, seen.y - at.y);
            let left_over = (rest(left, of_left), rest(right, of_right));
            let more = Self::of_first_order(left_over.0, left_over.1, side);
            angles.alpha += more.alpha;
            angles.beta += more.beta;
            let together = angles.alpha.abs() + angles.beta.abs();
            if together.is_nan() || together > LARGEST {
                return None;
            }
            if more.alpha.abs() + more.beta.abs() < FOUND {
                return Some(angles);
            }
        }
        None
    }

    /// Where a run ends in m, in the frame of its start, whose sides are `side` m from end to end.
    ///
    /// Side k begins at k phi, phi = +-(90 deg - alpha) + beta, and its chord points at beta/2 from there.
    pub fn returns_to(self, is_left: bool, side: f64) -> Point {
        let turn = FRAC_PI_2 - self.alpha;
        let each = if is_left { turn } else { -turn } + self.beta;
        (0..4).fold(Point::default(), |at, k| {
            let (sin, cos) = sin_cos(f64::from(k) * each + self.beta / 2.0);
            Point::new(at.x + side * cos, at.y + side * sin)
        })
    }

    /// Error in rad of the heading at the end of a run: four turns and four sides.
    pub fn heading_after(self, is_left: bool) -> f64 {
        4.0 * (self.beta + if is_left { -self.alpha } else { self.alpha })
    }

    /// Track width per that described: b_actual/b_nominal = 90 deg/(90 deg - alpha).
    pub fn track_ratio(self) -> f64 {
        FRAC_PI_2 / (FRAC_PI_2 - self.alpha)
    }

    /// Diameter of the right wheel per that of the left one, on a track of `track` m with sides of `side` m from end to end:
    /// E_d = (R + b/2)/(R - b/2), R = (L/2)/sin(beta/2).
    pub fn wheel_ratio(self, side: f64, track: f64) -> f64 {
        // b/(2R), which is zero where the robot drives straight.
        let bend = track * sin_cos(self.beta / 2.0).0 / side;
        (1.0 + bend) / (1.0 - bend)
    }

    /// Length of a side along its arc per that from end to end: (beta/2)/sin(beta/2).
    pub fn arc_ratio(self) -> f64 {
        1.0 / sinc_cos(self.beta / 2.0).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Angle, Pose};
    use crate::kinematics::arc;
    use proptest::prelude::*;

    /// The square driven by wheels of the diameters 1 and `wheels` on a track of `track` times that described, naively.
    fn driven(is_left: bool, track: f64, wheels: f64, side: f64, described: f64) -> (Pose, f64) {
        let sign = if is_left { 1.0 } else { -1.0 };
        let (mut pose, mut chord) = (Pose::default(), 0.0);
        let (left, right) = (2.0 / (1.0 + wheels), 2.0 * wheels / (1.0 + wheels));
        for _ in 0..4 {
            let before = pose.point();
            let steps = 1000;
            for _ in 0..steps {
                let each = side / f64::from(steps);
                let (left, right) = (each * left, each * right);
                let turn = (right - left) / (track * described);
                pose = pose.then(arc(f64::midpoint(left, right), turn));
            }
            chord = before.distance(pose.point());
            pose = pose.then(arc(0.0, sign * FRAC_PI_2 / track));
        }
        (pose, chord)
    }

    proptest! {
        #[test]
        fn track_and_wheels_of_a_square_driven_step_by_step_are_found(track in 0.94..1.06f64, wheels in 0.98..1.02f64) {
            let (side, described) = (1.0, 0.1);
            let (left, chord) = driven(true, track, wheels, side, described);
            let (right, _) = driven(false, track, wheels, side, described);
            let angles = Angles::of(left.point(), right.point(), chord).unwrap();
            for (is_left, end) in [(true, left), (false, right)] {
                let off = end.heading.minus(Angle::new(angles.heading_after(is_left)));
                prop_assert!(off.abs() < 1e-6, "{off}");
            }
            prop_assert!((angles.track_ratio() - track).abs() < 1e-6, "{angles:?}");
            let ratio = angles.wheel_ratio(chord, track * described);
            prop_assert!((ratio - wheels).abs() < 1e-6, "{ratio}");
            prop_assert!((angles.arc_ratio() * chord - side).abs() < 1e-6);
        }

        /// Held against the formulas of the paper as they are printed, each pair by itself.
        #[test]
        fn small_angles_are_those_of_the_paper(alpha in -0.002..0.002f64, beta in -0.002..0.002f64) {
            let side = 4.0;
            let [ccw, cw] = [true, false].map(|is_left| Angles { alpha, beta }.returns_to(is_left, side));
            prop_assert!((cw.x - -2.0 * side * (alpha + beta)).abs() < 4e-4);
            prop_assert!((ccw.x - -2.0 * side * (alpha - beta)).abs() < 4e-4);
            prop_assert!((alpha - (cw.x + ccw.x) / (-4.0 * side)).abs() < 1e-4);
            prop_assert!((beta - (cw.x - ccw.x) / (-4.0 * side)).abs() < 1e-4);
            prop_assert!((alpha - (cw.y - ccw.y) / (-4.0 * side)).abs() < 1e-4);
            prop_assert!((beta - (cw.y + ccw.y) / (-4.0 * side)).abs() < 1e-4);
        }
    }

    #[test]
    fn what_is_no_square_is_none() {
        assert_eq!(Angles::of(Point::new(3.0, 1.0), Point::new(-2.0, 5.0), 1.0), None);
        assert_eq!(Angles::of(Point::new(f64::NAN, 1.0), Point::default(), 1.0), None);
    }
}
