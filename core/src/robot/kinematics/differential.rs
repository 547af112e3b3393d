//! Differential drive: two wheels on one axle, which roll.

use super::model::MotionModel;
use crate::geometry::elementary::most;
use crate::geometry::{Twist, WheelSpeeds};

/// Two wheels on one axle, whose middle is tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differential {
    /// Radius of both wheels in m.
    pub wheel_radius: f64,
    /// Distance between the wheels in m.
    pub track_width: f64,
    /// By what part of their mean the right wheel is larger than the left.
    pub unequal: f64,
}

impl MotionModel for Differential {
    /// v = r/2 (w_r + w_l), omega = r/W (w_r - w_l).
    ///
    /// Thesis eq. 10-11, corrected: rates, not displacements per step. Of unequal wheels each has its own radius.
    fn forward(&self, speeds: WheelSpeeds) -> Twist {
        let half = self.unequal / 2.0;
        let (sum, difference) = (speeds.right + speeds.left, speeds.right - speeds.left);
        Twist {
            linear: self.wheel_radius / 2.0 * (sum + half * difference),
            angular: self.wheel_radius / self.track_width * (difference + half * sum),
        }
    }

    /// Thesis eq. 19.
    fn inverse(&self, twist: Twist) -> WheelSpeeds {
        let (half_track, half) = (self.track_width / 2.0, self.unequal / 2.0);
        WheelSpeeds {
            left: (twist.linear - half_track * twist.angular) / (self.wheel_radius * (1.0 - half)),
            right: (twist.linear + half_track * twist.angular) / (self.wheel_radius * (1.0 + half)),
        }
    }

    fn sideways(&self) -> f64 {
        0.0
    }

    fn share(&self, twist: Twist, over: f64, fastest: f64) -> f64 {
        let wheels = self.inverse(twist);
        let over = over.max(wheels.left.abs().max(wheels.right.abs()) / fastest);
        if over > 1.0 { 1.0 / over } else { 1.0 }
    }

    fn faster(&self, linear: f64, turning: f64) -> f64 {
        linear + turning
    }

    fn linear_within(&self, room: f64, turning: f64, least: f64, _: f64) -> f64 {
        most(least, room - turning)
    }

    fn turning_within(&self, room: f64, linear: f64, least: f64) -> f64 {
        most(least, room - linear)
    }
}
