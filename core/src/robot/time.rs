//! Robot time: instants of the robot's own clock.
//!
//! An instant is no span: two of them have a difference and no sum. Spans are plain numbers in s, as speeds and lengths are
//! plain numbers in their units.

use crate::geometry::elementary::{least, most};
use core::fmt;
use core::ops::{Add, AddAssign, Sub, SubAssign};
use serde::{Deserialize, Serialize};

/// An instant of the robot's clock, which counts s from an instant of its own choice.
///
/// ```
/// use umwelt_core::time::RobotTime;
/// let taken = RobotTime::new(12.5);
/// let sent = taken + 0.25;
/// assert_eq!(sent - taken, 0.25);
/// assert!(taken < sent && sent < RobotTime::NEVER);
/// ```
///
/// An instant plus an instant means nothing, and an instant is not taken for a span:
///
/// ```compile_fail
/// use umwelt_core::time::RobotTime;
/// let sum = RobotTime::new(1.0) + RobotTime::new(2.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RobotTime(f64);

impl RobotTime {
    /// Where the clock counts from.
    pub const ZERO: Self = Self(0.0);
    /// After every instant.
    pub const NEVER: Self = Self(f64::INFINITY);
    /// Before every instant.
    pub const BEFORE_ALL: Self = Self(f64::NEG_INFINITY);

    /// The instant at which the clock reads so many s.
    #[inline]
    pub const fn new(seconds: f64) -> Self {
        Self(seconds)
    }

    /// What the clock reads, in s.
    #[inline]
    pub const fn seconds(self) -> f64 {
        self.0
    }

    /// The earlier of two instants.
    #[inline]
    #[must_use]
    pub fn earlier(self, other: Self) -> Self {
        Self(least(self.0, other.0))
    }

    /// The later of two instants.
    #[inline]
    #[must_use]
    pub fn later(self, other: Self) -> Self {
        Self(most(self.0, other.0))
    }

    /// Whether it is [`RobotTime::NEVER`].
    #[inline]
    pub fn is_never(self) -> bool {
        self == Self::NEVER
    }

    /// Whether a clock can read it.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }
}

impl Add<f64> for RobotTime {
    type Output = Self;

    #[inline]
    fn add(self, span: f64) -> Self {
        Self(self.0 + span)
    }
}

impl AddAssign<f64> for RobotTime {
    #[inline]
    fn add_assign(&mut self, span: f64) {
        self.0 += span;
    }
}

impl Sub<f64> for RobotTime {
    type Output = Self;

    #[inline]
    fn sub(self, span: f64) -> Self {
        Self(self.0 - span)
    }
}

impl SubAssign<f64> for RobotTime {
    #[inline]
    fn sub_assign(&mut self, span: f64) {
        self.0 -= span;
    }
}

impl Sub for RobotTime {
    type Output = f64;

    #[inline]
    fn sub(self, earlier: Self) -> f64 {
        self.0 - earlier.0
    }
}

impl fmt::Display for RobotTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_operations_are_those_of_the_seconds() {
        let (one, span) = (1e9 + 0.1, 0.03);
        let time = RobotTime::new(one);
        assert_eq!((time + span).seconds().to_bits(), (one + span).to_bits());
        assert_eq!((time - span).seconds().to_bits(), (one - span).to_bits());
        assert_eq!((time + span - time).to_bits(), (one + span - one).to_bits());
        let mut later = time;
        later += span;
        assert_eq!(later, time + span);
    }

    #[test]
    fn never_is_after_all_and_before_all_is_before() {
        let now = RobotTime::new(-3.0);
        assert_eq!(now.later(RobotTime::BEFORE_ALL), now);
        assert_eq!(now.earlier(RobotTime::NEVER), now);
        assert!(RobotTime::NEVER.is_never() && !now.is_never() && !RobotTime::NEVER.is_finite());
    }

    #[test]
    fn it_is_kept_as_its_seconds() {
        assert_eq!(serde_json::to_string(&RobotTime::new(0.5)).unwrap(), "0.5");
        assert_eq!(serde_json::from_str::<RobotTime>("2.25").unwrap(), RobotTime::new(2.25));
    }
}
