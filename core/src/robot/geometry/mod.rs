//! Poses, displacements, twists and wheel speeds; each type carries its frame.
//!
//! * [`Pose`] is always in the **world** frame: x and y in metres, heading counter-clockwise from the x axis.
//! * [`Displacement`] and [`Twist`] are always in the **body** frame: forward along the heading, lateral to its left.
//! * [`WheelSpeeds`] are always per **wheel**, positive when the wheel drives the robot forward.
//!
//! Adding quantities of different frames does not compile:
//!
//! ```compile_fail
//! use umwelt_core::geometry::{Pose, Twist};
//! let _ = Pose::default() + Twist::default();
//! ```

pub mod elementary;

use core::f64::consts::{PI, TAU};
use elementary::{sin_cos, sqrt};
use serde::{Deserialize, Serialize};

/// A direction in rad, wrapped to (-pi, pi] on construction and nowhere else.
///
/// ```
/// use umwelt_core::geometry::Angle;
/// let a = Angle::new(3.0) + 1.0;
/// assert!((a.radians() - (4.0 - std::f64::consts::TAU)).abs() < 1e-12);
/// assert!((Angle::new(-3.0).minus(Angle::new(3.0)) - (std::f64::consts::TAU - 6.0)).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "f64", into = "f64")]
pub struct Angle(f64);

impl Angle {
    /// The direction `radians`, wrapped to (-pi, pi].
    pub fn new(radians: f64) -> Self {
        if radians > -PI && radians <= PI {
            return Self(radians);
        }
        // Nearly always within a turn, where no remainder is needed.
        let wrapped = if radians > -TAU && radians < TAU {
            if radians < 0.0 { radians + TAU } else { radians }
        } else {
            let rest = radians % TAU;
            if rest < 0.0 { rest + TAU } else { rest }
        };
        Self(if wrapped > PI { wrapped - TAU } else { wrapped })
    }

    /// The direction in rad, in (-pi, pi].
    pub fn radians(self) -> f64 {
        self.0
    }

    /// The shortest signed turn from `other` to `self` in rad, in (-pi, pi].
    pub fn minus(self, other: Self) -> f64 {
        Self::new(self.0 - other.0).0
    }
}

impl From<f64> for Angle {
    fn from(radians: f64) -> Self {
        Self::new(radians)
    }
}

impl From<Angle> for f64 {
    fn from(angle: Angle) -> Self {
        angle.0
    }
}

impl core::ops::Add<f64> for Angle {
    type Output = Self;

    /// Turns the direction by `turn` rad.
    fn add(self, turn: f64) -> Self {
        Self::new(self.0 + turn)
    }
}

/// The length of (x, y), both of ordinary size: no detour around overflow.
pub fn length(x: f64, y: f64) -> f64 {
    sqrt(x * x + y * y)
}

/// A place in the world frame, in m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// World x in m.
    pub x: f64,
    /// World y in m.
    pub y: f64,
}

impl Point {
    /// The point (x, y), both in m.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The distance to `other` in m.
    pub fn distance(self, other: Self) -> f64 {
        length(self.x - other.x, self.y - other.y)
    }

    /// The distance in m from this point to the segment `from`..`to` (its nearest end where it lies beyond one).
    ///
    /// ```
    /// use umwelt_core::geometry::Point;
    /// let (a, b) = (Point::new(0.0, 0.0), Point::new(2.0, 0.0));
    /// assert_eq!(Point::new(1.0, 0.5).distance_to_segment(a, b), 0.5);
    /// assert_eq!(Point::new(3.0, 0.0).distance_to_segment(a, b), 1.0);
    /// ```
    pub fn distance_to_segment(self, from: Self, to: Self) -> f64 {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let length_squared = dx * dx + dy * dy;
        if length_squared == 0.0 {
            return self.distance(from);
        }
        let along = ((self.x - from.x) * dx + (self.y - from.y) * dy) / length_squared;
        let along = along.clamp(0.0, 1.0);
        self.distance(Self::new(from.x + along * dx, from.y + along * dy))
    }
}

/// Position and heading of a robot in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// World x in m.
    pub x: f64,
    /// World y in m.
    pub y: f64,
    /// Direction of travel, counter-clockwise from world x.
    pub heading: Angle,
}

impl Pose {
    /// The pose at (x, y) in m with `heading` in rad.
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self { x, y, heading: Angle::new(heading) }
    }

    /// The position without the heading.
    pub fn point(self) -> Point {
        Point::new(self.x, self.y)
    }

    /// The pose after moving by `displacement` from here.
    ///
    /// ```
    /// use umwelt_core::geometry::{Displacement, Pose};
    /// let d = Displacement { forward: 0.3, lateral: -0.1, turn: 0.4 };
    /// let start = Pose::new(1.0, 2.0, 0.7);
    /// let back = start.then(d).relative_to(start);
    /// assert!((back.forward - d.forward).abs() < 1e-12 && (back.lateral - d.lateral).abs() < 1e-12);
    /// ```
    pub fn then(self, displacement: Displacement) -> Self {
        let (sin, cos) = sin_cos(self.heading.radians());
        Self {
            x: self.x + cos * displacement.forward - sin * displacement.lateral,
            y: self.y + sin * displacement.forward + cos * displacement.lateral,
            heading: self.heading + displacement.turn,
        }
    }

    /// The displacement that leads from `origin` to this pose, its turn in (-pi, pi].
    pub fn relative_to(self, origin: Self) -> Displacement {
        let ahead = origin.toward(self.point());
        Displacement {
            forward: ahead.0,
            lateral: ahead.1,
            turn: self.heading.minus(origin.heading),
        }
    }

    /// `(forward, lateral)` offset in m of `target` in this pose's body frame: e_x and e_y of thesis eq. 14.
    pub fn toward(self, target: Point) -> (f64, f64) {
        let (sin, cos) = sin_cos(self.heading.radians());
        let (dx, dy) = (target.x - self.x, target.y - self.y);
        (cos * dx + sin * dy, cos * dy - sin * dx)
    }
}

/// A rigid motion in the body frame of the pose it starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// Motion along the starting heading in m.
    pub forward: f64,
    /// Motion to the left of the starting heading in m.
    pub lateral: f64,
    /// Change of heading in rad, not wrapped.
    pub turn: f64,
}

impl Displacement {
    /// This motion followed by `next`, which starts where this one ends.
    pub fn then(self, next: Self) -> Self {
        if next.forward == 0.0 && next.lateral == 0.0 {
            return Self { turn: self.turn + next.turn, ..self };
        }
        let (sin, cos) = sin_cos(self.turn);
        Self {
            forward: self.forward + cos * next.forward - sin * next.lateral,
            lateral: self.lateral + sin * next.forward + cos * next.lateral,
            turn: self.turn + next.turn,
        }
    }
}

/// Velocity in the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed in m/s, negative in reverse.
    pub linear: f64,
    /// Angular velocity in rad/s, positive to the left.
    pub angular: f64,
}

impl Twist {
    /// No motion.
    pub const ZERO: Self = Self { linear: 0.0, angular: 0.0 };

    /// The twist with `linear` in m/s and `angular` in rad/s.
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self { linear, angular }
    }

    /// Both components times `factor`: another speed along the same curve.
    pub fn scaled(self, factor: f64) -> Self {
        Self { linear: self.linear * factor, angular: self.angular * factor }
    }
}

/// Angular velocities of the two wheels in rad/s, positive when driving the robot forward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSpeeds {
    /// Left wheel in rad/s.
    pub left: f64,
    /// Right wheel in rad/s.
    pub right: f64,
}

impl WheelSpeeds {
    /// Both wheels at rest.
    pub const ZERO: Self = Self { left: 0.0, right: 0.0 };

    /// Both speeds times `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self { left: self.left * factor, right: self.right * factor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    fn displacement() -> impl Strategy<Value = Displacement> {
        (-2.0..2.0, -2.0..2.0, -6.0..6.0f64).prop_map(|(forward, lateral, turn)| Displacement {
            forward,
            lateral,
            turn,
        })
    }

    proptest! {
        #[test]
        fn an_angle_is_wrapped_and_keeps_its_direction(radians in -1e4..1e4f64) {
            let wrapped = Angle::new(radians).radians();
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!(close(wrapped.sin(), radians.sin()) && close(wrapped.cos(), radians.cos()));
        }

        #[test]
        fn relative_to_undoes_then(x in -5.0..5.0f64, y in -5.0..5.0f64, h in -4.0..4.0f64, d in displacement()) {
            let start = Pose::new(x, y, h);
            let back = start.then(d).relative_to(start);
            prop_assert!(close(back.forward, d.forward) && close(back.lateral, d.lateral));
            prop_assert!(close(back.turn, Angle::new(d.turn).radians()) || close(back.turn.abs(), PI));
        }

        #[test]
        fn composing_displacements_is_composing_poses(h in -4.0..4.0f64, a in displacement(), b in displacement()) {
            let start = Pose::new(0.3, -0.2, h);
            let one = start.then(a).then(b);
            let both = start.then(a.then(b));
            prop_assert!(close(one.x, both.x) && close(one.y, both.y));
            prop_assert!(close(one.heading.minus(both.heading), 0.0));
        }

        #[test]
        fn the_segment_is_never_farther_than_its_ends(x in -3.0..3.0f64, y in -3.0..3.0f64) {
            let (p, a, b) = (Point::new(x, y), Point::new(-1.0, 0.2), Point::new(1.0, 0.7));
            let d = p.distance_to_segment(a, b);
            prop_assert!(d <= p.distance(a) + 1e-12 && d <= p.distance(b) + 1e-12);
        }
    }

    #[test]
    fn the_angle_pi_stays_pi() {
        assert_eq!(Angle::new(PI).radians(), PI);
        assert_eq!(Angle::new(-PI).radians(), PI);
    }
}
