//! What a drive can do: speeds of body and wheels, accelerations, smallest speeds.

use super::drive::Drive;
use super::model::MotionModel;
use crate::geometry::Twist;
use crate::geometry::elementary::{least, most};

impl Drive {
    /// Scales `twist` along its own curve until body and wheel limits hold.
    ///
    /// ```
    /// use umwelt_core::{geometry::Twist, kinematics::Drive};
    /// let limited = Drive::default().limited(Twist::new(0.26, 0.4));
    /// assert!((limited.linear - 0.13).abs() < 1e-12 && (limited.angular - 0.2).abs() < 1e-12);
    /// ```
    pub fn limited(&self, twist: Twist) -> Twist {
        let over =
            (twist.linear.abs() / self.max_linear).max(twist.angular.abs() / self.max_angular);
        let share = self.share(twist, over, self.max_wheel_speed);
        if share < 1.0 { twist.scaled(share) } else { twist }
    }

    /// Seconds that the acceleration limits ask for the change from `from` to `to`.
    ///
    /// Motors do not turn below a minimum speed, so a step within the band between standstill and the
    /// minimum speed costs nothing: the limits bind above it.
    pub fn change_time(&self, from: Twist, to: Twist) -> f64 {
        let linear = beyond(to.linear, self.min_linear) - beyond(from.linear, self.min_linear);
        let angular = beyond(to.angular, self.min_angular) - beyond(from.angular, self.min_angular);
        most(
            linear.abs() / self.max_linear_acceleration,
            angular.abs() / self.max_angular_acceleration,
        )
    }

    /// The twist nearest to `to` that is reached from `from` within `duration` s, each component by itself
    /// (thesis eq. 20, for speed and heading). Where one grows faster than the other falls, it grows no further than the
    /// wheels allow.
    ///
    /// ```
    /// use umwelt_core::{geometry::Twist, kinematics::Drive};
    /// let drive = Drive::default();
    /// let next = drive.reach(Twist::ZERO, Twist::new(0.13, 0.0), 0.03);
    /// assert!((next.linear - (drive.min_linear + drive.max_linear_acceleration * 0.03)).abs() < 1e-12);
    /// assert!(drive.change_time(Twist::ZERO, next) <= 0.03 + 1e-12);
    /// ```
    pub fn reach(&self, from: Twist, to: Twist, duration: f64) -> Twist {
        let reached = Twist {
            linear: step_toward(
                from.linear,
                to.linear,
                self.max_linear_acceleration * duration,
                self.min_linear,
            ),
            angular: step_toward(
                from.angular,
                to.angular,
                self.max_angular_acceleration * duration,
                self.min_angular,
            ),
        };
        self.held_to_wheels(from, reached)
    }

    /// `reached` with the component that has grown since `from` cut back to what the faster wheel can do.
    ///
    /// Between two twists that it can do only one component grows where it cannot do what lies between, and cut back that
    /// one still lies between the two. Of wheels that roll the faster one runs at (|v| + W/2 |omega|)/r.
    fn held_to_wheels(&self, from: Twist, reached: Twist) -> Twist {
        let (room, half_track) = (self.max_wheel_speed * self.wheel_radius, self.track_width / 2.0);
        let (linear, turning) = (reached.linear.abs(), half_track * reached.angular.abs());
        if self.faster(linear, turning) <= room {
            return reached;
        }
        let (before, turned) = (from.linear.abs(), half_track * from.angular.abs());
        if linear > before {
            let within = self.linear_within(room, turning, before, linear);
            Twist { linear: within.copysign(reached.linear), ..reached }
        } else if turning > turned {
            let within = self.turning_within(room, linear, turned);
            Twist { angular: (within / half_track).copysign(reached.angular), ..reached }
        } else {
            reached
        }
    }

    /// The twist after a `share` in 0..1 of the change from `from` to `to`, both components at once: it takes that
    /// share of [`Drive::change_time`].
    pub fn part_way(&self, from: Twist, to: Twist, share: f64) -> Twist {
        Twist {
            linear: between(from.linear, to.linear, share, self.min_linear),
            angular: between(from.angular, to.angular, share, self.min_angular),
        }
    }

    /// Seconds of a ramp from `twist` to rest in which neither acceleration limit is exceeded.
    pub fn stopping_time(&self, twist: Twist) -> f64 {
        (twist.linear.abs() / self.max_linear_acceleration)
            .max(twist.angular.abs() / self.max_angular_acceleration)
    }
}

/// The part of `speed` beyond the band (-minimum, minimum), signed.
fn beyond(speed: f64, minimum: f64) -> f64 {
    speed - most(-minimum, least(minimum, speed))
}

/// A `share` of the way from `from` to `to`, of which the band (-minimum, minimum) is no part.
fn between(from: f64, to: f64, share: f64, minimum: f64) -> f64 {
    let (start, end) = (beyond(from, minimum), beyond(to, minimum));
    let part = start + share * (end - start);
    if part == 0.0 { to.clamp(-minimum, minimum) } else { part + minimum.copysign(part) }
}

/// `from` moved toward `to` by at most `step` outside the band (-minimum, minimum).
fn step_toward(from: f64, to: f64, step: f64, minimum: f64) -> f64 {
    let (start, end) = (beyond(from, minimum), beyond(to, minimum));
    if (end - start).abs() <= step {
        return to;
    }
    let next = start + step.copysign(end - start);
    if next == 0.0 { minimum.copysign(start) } else { next + minimum.copysign(next) }
}
