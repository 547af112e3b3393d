//! Commanded motion, as predictions take it in.

use crate::geometry::Twist;

/// A commanded motion over some time, at one speed or several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Signed arc length in m.
    pub length: f64,
    /// Turn in rad.
    pub turn: f64,
    /// Duration in s.
    pub duration: f64,
    /// int v^2 dt in m^2/s: what errors white in time grow with.
    pub length_power: f64,
    /// int omega^2 dt in rad^2/s.
    pub turn_power: f64,
}

impl Motion {
    /// None yet: what others are added to.
    pub const NONE: Self =
        Self { length: 0.0, turn: 0.0, duration: 0.0, length_power: 0.0, turn_power: 0.0 };

    /// The motion of holding `twist` for `duration` s.
    pub fn new(twist: Twist, duration: f64) -> Self {
        let (length, turn) = (twist.linear * duration, twist.angular * duration);
        let (length_power, turn_power) = (twist.linear * length, twist.angular * turn);
        Self { length, turn, duration, length_power, turn_power }
    }

    /// The motion along an arc of `length` m that turns by `turn` rad in `duration` s.
    pub fn arc(length: f64, turn: f64, duration: f64) -> Self {
        Self::new(Twist::new(length / duration, turn / duration), duration)
    }

    /// This motion followed by `next`.
    pub fn then(self, next: Self) -> Self {
        Self {
            length: self.length + next.length,
            turn: self.turn + next.turn,
            duration: self.duration + next.duration,
            length_power: self.length_power + next.length_power,
            turn_power: self.turn_power + next.turn_power,
        }
    }

    /// Whether anything moves.
    pub fn is_motion(self) -> bool {
        self.length != 0.0 || self.turn != 0.0
    }
}
