//! Two-wheel drive: radius, track, limits, actuator lag; forward, inverse and exact-arc integration.

use crate::geometry::elementary::{exp, least, most, sinc_cos};
use crate::geometry::{Displacement, Twist, WheelSpeeds};

/// Below this angular velocity in rad/s a motion counts as straight (thesis table 1).
pub const STRAIGHT_BELOW: f64 = 0.01;

/// A two-wheel drive. Every field is positive and finite; `lag` and `dead_time` may be zero.
///
/// Radius, track width and acceleration are not given by the thesis: the defaults are a robot of the 0.1 m class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Radius of both wheels in m.
    pub wheel_radius: f64,
    /// Distance between the wheels in m (W of thesis eq. 11).
    pub track_width: f64,
    /// By what part of their mean the right wheel is larger than the left; 0 where they are equal.
    pub unequal: f64,
    /// Largest speed of either wheel in rad/s.
    pub max_wheel_speed: f64,
    /// Largest forward or reverse speed in m/s (thesis table 1).
    pub max_linear: f64,
    /// Smallest forward or reverse speed in m/s at which the motors turn (thesis table 1).
    pub min_linear: f64,
    /// Largest angular velocity in rad/s (thesis table 1).
    pub max_angular: f64,
    /// Smallest angular velocity in rad/s of a turn in place (thesis table 1).
    pub min_angular: f64,
    /// Largest change of forward speed in m/s^2 (thesis eq. 20, a constant it does not give).
    pub max_linear_acceleration: f64,
    /// Largest change of angular velocity in rad/s^2 (thesis eq. 20 for the heading).
    pub max_angular_acceleration: f64,
    /// Time constant in s with which the wheels follow a command; 0 follows at once.
    pub lag: f64,
    /// Time in s before the wheels begin to follow a command.
    pub dead_time: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            wheel_radius: 0.03,
            track_width: 0.10,
            unequal: 0.0,
            max_wheel_speed: 8.0,
            max_linear: 0.130,
            min_linear: 0.023,
            max_angular: 1.25,
            min_angular: 0.20,
            max_linear_acceleration: 0.3,
            max_angular_acceleration: 3.0,
            lag: 0.0,
            dead_time: 0.0,
        }
    }
}

impl Drive {
    /// Scales `twist` along its own curve until body and wheel limits hold.
    ///
    /// ```
    /// use umwelt_core::{geometry::Twist, kinematics::Drive};
    /// let limited = Drive::default().limited(Twist::new(0.26, 0.4));
    /// assert!((limited.linear - 0.13).abs() < 1e-12 && (limited.angular - 0.2).abs() < 1e-12);
    /// ```
    pub fn limited(&self, twist: Twist) -> Twist {
        let wheels = inverse(self, twist);
        let over = (twist.linear.abs() / self.max_linear)
            .max(twist.angular.abs() / self.max_angular)
            .max(wheels.left.abs().max(wheels.right.abs()) / self.max_wheel_speed);
        if over > 1.0 { twist.scaled(1.0 / over) } else { twist }
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
    /// The faster wheel runs at (|v| + W/2 |omega|)/r. Between two twists that it can do only one component grows where
    /// it cannot do what lies between, and cut back that one still lies between the two.
    fn held_to_wheels(&self, from: Twist, reached: Twist) -> Twist {
        let (room, half_track) = (self.max_wheel_speed * self.wheel_radius, self.track_width / 2.0);
        let (linear, turning) = (reached.linear.abs(), half_track * reached.angular.abs());
        if linear + turning <= room {
            return reached;
        }
        let (before, turned) = (from.linear.abs(), half_track * from.angular.abs());
        if linear > before {
            let linear = most(before, room - turning).copysign(reached.linear);
            Twist { linear, ..reached }
        } else if turning > turned {
            let angular = (most(turned, room - linear) / half_track).copysign(reached.angular);
            Twist { angular, ..reached }
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

/// The body twist of turning the wheels at `speeds`: v = r/2 (w_r + w_l), omega = r/W (w_r - w_l).
///
/// Thesis eq. 10-11, corrected: rates, not displacements per step. Of unequal wheels each has its own radius.
pub fn forward(drive: &Drive, speeds: WheelSpeeds) -> Twist {
    let half = drive.unequal / 2.0;
    let (sum, difference) = (speeds.right + speeds.left, speeds.right - speeds.left);
    Twist {
        linear: drive.wheel_radius / 2.0 * (sum + half * difference),
        angular: drive.wheel_radius / drive.track_width * (difference + half * sum),
    }
}

/// The wheel speeds that make the body move with `twist` (thesis eq. 19).
///
/// ```
/// use umwelt_core::{geometry::Twist, kinematics::{forward, inverse, Drive}};
/// let (drive, twist) = (Drive { unequal: 0.02, ..Drive::default() }, Twist::new(0.1, -0.7));
/// let back = forward(&drive, inverse(&drive, twist));
/// assert!((back.linear - twist.linear).abs() < 1e-15 && (back.angular - twist.angular).abs() < 1e-15);
/// ```
pub fn inverse(drive: &Drive, twist: Twist) -> WheelSpeeds {
    let (half_track, half) = (drive.track_width / 2.0, drive.unequal / 2.0);
    WheelSpeeds {
        left: (twist.linear - half_track * twist.angular) / (drive.wheel_radius * (1.0 - half)),
        right: (twist.linear + half_track * twist.angular) / (drive.wheel_radius * (1.0 + half)),
    }
}

/// The motion of holding `twist` for `duration` s: the exact arc, a straight line as its limit.
///
/// Thesis eq. 8-9, corrected: displacement = rate x duration, and along the arc, not the starting tangent.
pub fn integrate(twist: Twist, duration: f64) -> Displacement {
    arc(twist.linear * duration, twist.angular * duration)
}

/// The motion along an arc of `length` m that turns by `turn` rad.
///
/// The chord is `length` sinc(turn/2), at half the turn.
pub fn arc(length: f64, turn: f64) -> Displacement {
    if length == 0.0 {
        return Displacement { forward: 0.0, lateral: 0.0, turn };
    }
    let half = turn / 2.0;
    let (sinc, cos) = sinc_cos(half);
    let chord = length * sinc;
    Displacement { forward: chord * cos, lateral: chord * (half * sinc), turn }
}

/// How the wheels get from `current` toward `command` in `duration` s with first-order lag:
/// their speeds at the end, and their mean speeds over the time.
///
/// w' = (u - w)/tau: w(t) = u + (w_0 - u) e^(-t/tau), mean = u + (w_0 - u) tau/t (1 - e^(-t/tau)).
pub fn follow(
    lag: f64,
    current: WheelSpeeds,
    command: WheelSpeeds,
    duration: f64,
) -> (WheelSpeeds, WheelSpeeds) {
    if lag <= 0.0 {
        return (command, command);
    }
    if duration <= 0.0 {
        return (current, current);
    }
    let (decay, mean) = left_over(lag, duration);
    let (left, right) = (current.left - command.left, current.right - command.right);
    (
        WheelSpeeds { left: command.left + left * decay, right: command.right + right * decay },
        WheelSpeeds { left: command.left + left * mean, right: command.right + right * mean },
    )
}

/// What a first-order lag leaves of a difference after `duration` s: at the end, and on average. Both are positive.
pub fn left_over(lag: f64, duration: f64) -> (f64, f64) {
    let share = duration / lag;
    let decay = exp(-share);
    (decay, (1.0 - decay) / share)
}

/// How the robot gets from wheel speeds `current` toward `command` in `duration` s with its own lag: its wheel speeds at
/// the end, and its mean twist over the time.
pub fn travel(
    drive: &Drive,
    current: WheelSpeeds,
    command: WheelSpeeds,
    duration: f64,
) -> (WheelSpeeds, Twist) {
    let (end, mean) = follow(drive.lag, current, command, duration);
    (end, forward(drive, mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use proptest::prelude::*;

    #[test]
    fn the_arc_is_what_small_steps_sum_to() {
        let twist = Twist::new(0.12, 1.1);
        let steps = 200_000;
        let mut pose = Pose::default();
        for _ in 0..steps {
            let h = 0.7 / f64::from(steps);
            let mid = pose.heading.radians() + twist.angular * h / 2.0;
            pose = Pose::new(
                pose.x + twist.linear * h * mid.cos(),
                pose.y + twist.linear * h * mid.sin(),
                pose.heading.radians() + twist.angular * h,
            );
        }
        let exact = Pose::default().then(integrate(twist, 0.7));
        assert!((pose.x - exact.x).abs() < 1e-9 && (pose.y - exact.y).abs() < 1e-9);
    }

    #[test]
    fn following_is_what_small_steps_sum_to() {
        let (from, to) =
            (WheelSpeeds { left: 1.0, right: -2.0 }, WheelSpeeds { left: 4.0, right: 3.0 });
        let (lag, duration, steps) = (0.1, 0.07, 400_000);
        let h = duration / f64::from(steps);
        let (mut speed, mut sum) = (from.left, 0.0);
        for _ in 0..steps {
            let next = speed + (to.left - speed) / lag * h;
            sum += (speed + next) / 2.0 * h;
            speed = next;
        }
        let (end, mean) = follow(lag, from, to, duration);
        assert!((end.left - speed).abs() < 1e-6);
        assert!((mean.left - sum / duration).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn the_arc_tends_to_the_straight_line(v in -0.2..0.2f64, t in 0.0..1.0f64, w in -1e-3..1e-3f64) {
            let d = integrate(Twist::new(v, w), t);
            prop_assert!((d.forward - v * t).abs() < 1e-6 && d.lateral.abs() < 1e-3);
        }

        #[test]
        fn two_halves_of_an_arc_are_the_arc(v in -0.2..0.2f64, w in -3.0..3.0f64, t in 0.0..2.0f64) {
            let half = integrate(Twist::new(v, w), t / 2.0);
            let (both, whole) = (half.then(half), integrate(Twist::new(v, w), t));
            prop_assert!((both.forward - whole.forward).abs() < 1e-12);
            prop_assert!((both.lateral - whole.lateral).abs() < 1e-12);
        }

        #[test]
        fn limits_hold_and_keep_the_curve(v in -1.0..1.0f64, w in -9.0..9.0f64) {
            let drive = Drive::default();
            let limited = drive.limited(Twist::new(v, w));
            prop_assert!(limited.linear.abs() <= drive.max_linear + 1e-12);
            prop_assert!(limited.angular.abs() <= drive.max_angular + 1e-12);
            let wheels = inverse(&drive, limited);
            prop_assert!(wheels.left.abs().max(wheels.right.abs()) <= drive.max_wheel_speed + 1e-12);
            prop_assert!((limited.linear * w - limited.angular * v).abs() < 1e-9);
        }

        /// Guards against: a robot with slow wheels that speeds up out of a curve, and one wheel is commanded too much.
        #[test]
        fn between_what_the_wheels_can_do_they_are_commanded_no_more(
            (a, b, wa, wb) in (-1.0..1.0f64, -1.0..1.0f64, -9.0..9.0f64, -9.0..9.0f64),
            (max_wheel_speed, track_width, duration) in (0.2..8.0f64, 0.01..1.0f64, 1e-6..0.03f64),
        ) {
            let drive = Drive { max_wheel_speed, track_width, ..Drive::default() };
            let (from, to) = (drive.limited(Twist::new(a, wa)), drive.limited(Twist::new(b, wb)));
            let reached = drive.reach(from, to, duration);
            let wheels = inverse(&drive, reached);
            let fastest = wheels.left.abs().max(wheels.right.abs());
            prop_assert!(fastest <= max_wheel_speed * (1.0 + 1e-9), "{fastest}: {reached:?}");
            prop_assert!(drive.change_time(from, reached) <= duration + 1e-9, "{reached:?}");
        }

        #[test]
        fn what_is_reached_keeps_the_acceleration_limit_and_gets_there(a in -0.13..0.13f64, b in -0.13..0.13f64, wa in -1.2..1.2f64, wb in -1.2..1.2f64) {
            let drive = Drive::default();
            let (mut at, to) = (Twist::new(a, wa), Twist::new(b, wb));
            for _ in 0..100 {
                let next = drive.reach(at, to, 0.03);
                prop_assert!(drive.change_time(at, next) <= 0.03 + 1e-9);
                at = next;
            }
            prop_assert_eq!(at, to);
        }

        #[test]
        fn part_way_takes_its_share_of_the_time(a in -0.13..0.13f64, b in -0.13..0.13f64, wa in -1.2..1.2f64, wb in -1.2..1.2f64, share in 0.0..1.0f64) {
            let drive = Drive::default();
            let (from, to) = (Twist::new(a, wa), Twist::new(b, wb));
            let part = drive.part_way(from, to, share);
            let (first, rest) = (drive.change_time(from, part), drive.change_time(part, to));
            let whole = drive.change_time(from, to);
            prop_assert!((first - share * whole).abs() < 1e-9 && (rest - (1.0 - share) * whole).abs() < 1e-9);
        }

        #[test]
        fn following_ends_between_where_it_was_and_the_command(a in -8.0..8.0f64, b in -8.0..8.0f64, t in 0.0..1.0f64) {
            let from = WheelSpeeds { left: a, right: b };
            let to = WheelSpeeds { left: b, right: a };
            let (end, mean) = follow(0.08, from, to, t);
            for value in [end.left, mean.left, end.right, mean.right] {
                prop_assert!(value >= a.min(b) - 1e-9 && value <= a.max(b) + 1e-9);
            }
        }
    }
}
