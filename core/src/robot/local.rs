//! What a robot itself allows its wheels, whatever is commanded: a bumper, a lidar field, an e-stop button.
//!
//! It acts on the robot at once, in [`crate::actuation`], and needs no link. The controller hears of it with the next
//! request and plans accordingly.

use crate::geometry::Twist;
use crate::kinematics::Drive;

/// What a robot itself allows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalLimits {
    /// Whether it is to rest.
    pub hold: bool,
    /// Largest speed in m/s, forward and in reverse; none where only the drive's own limit holds. A turn in place is not
    /// limited by it.
    pub max_speed: Option<f64>,
}

impl LocalLimits {
    /// Nothing but the drive's own limits.
    pub const NONE: Self = Self { hold: false, max_speed: None };

    /// Whether a robot with `drive` is to rest: it holds, or is allowed no speed at which its motors turn.
    pub fn is_hold(&self, drive: &Drive) -> bool {
        let can_drive = |max: f64| max > 0.0 && max >= drive.min_linear;
        self.hold || self.max_speed.is_some_and(|max| !can_drive(max))
    }

    /// `twist`, slowed down along its own curve to the speed that is allowed.
    pub fn limited(&self, twist: Twist) -> Twist {
        match self.max_speed {
            Some(max) if twist.linear.abs() > max => twist.scaled(max / twist.linear.abs()),
            _ => twist,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_at_which_no_motor_turns_is_a_hold() {
        let drive = Drive::default();
        let is_hold = |max| LocalLimits { hold: false, max_speed: max }.is_hold(&drive);
        assert!(!is_hold(None) && !is_hold(Some(0.05)) && !is_hold(Some(drive.min_linear)));
        assert!(is_hold(Some(0.022)) && is_hold(Some(0.0)) && is_hold(Some(-1.0)));
        assert!(is_hold(Some(f64::NAN)));
        assert!(LocalLimits { hold: true, max_speed: Some(0.1) }.is_hold(&drive));
    }

    #[test]
    fn a_curve_keeps_its_shape_and_a_turn_in_place_its_speed() {
        let limits = LocalLimits { hold: false, max_speed: Some(0.05) };
        let slow = limits.limited(Twist::new(-0.1, 0.4));
        assert!((slow.linear + 0.05).abs() < 1e-12 && (slow.angular - 0.2).abs() < 1e-12);
        assert_eq!(limits.limited(Twist::new(0.0, 1.2)), Twist::new(0.0, 1.2));
        assert_eq!(limits.limited(Twist::new(0.04, 1.2)), Twist::new(0.04, 1.2));
    }
}
