//! The motions of a check: what is commanded, for how long, and how much room it takes.

use crate::geometry::Twist;
use crate::geometry::elementary::{least, most};
use crate::kinematics::Drive;
use crate::task::Check;

/// Motions of a check: turn left, ahead, back, turn right twice as far, ahead, back, turn left.
pub const MOTIONS: usize = 7;

/// Angular velocity in rad/s that is enough: in degrees it is 2.1 "rad" between two poses of a camera of 10 Hz, which is
/// still told from a turn the other way.
const TURN: f64 = 0.375;

/// A motor turns surely at so many times the smallest speed described.
const ABOVE_LEAST: f64 = 1.25;

/// Length in m of a drive that is enough: a hundred standard deviations of a camera, twenty of a poor one.
const LENGTH: f64 = 0.15;

/// The same in track widths, for robots whose trackers have a larger scale.
const LENGTH_TRACKS: f64 = 0.4;

/// Times its drive that a robot may be seen away from where it began; a robot whose wheels are described five times too
/// small comes so far.
const ALLOWED: f64 = 6.0;

/// Times the speed commanded at which no robot moves: wheels are described ten times too small at most, and centimetres are
/// a hundred times as many.
const IMPOSSIBLE: f64 = 30.0;

/// Rest in s after the last motion, beside the delay that is described: the motion is seen by then whatever is not.
const LAST_REST: f64 = 1.7;

/// A part of the wiggle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// What is commanded; zero for a rest.
    pub twist: Twist,
    /// For how long, in s; that of a rest counts from when zero is commanded.
    pub duration: f64,
}

/// The wiggle of one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wiggle {
    check: Check,
    /// Speeds in m/s and rad/s.
    linear: f64,
    angular: f64,
    drive: Drive,
}

impl Wiggle {
    /// The wiggle of a robot with this drive.
    pub fn new(check: Check, drive: &Drive) -> Self {
        let full = drive.limited(Twist::new(drive.max_linear, 0.0)).linear;
        let enough = most(LENGTH, LENGTH_TRACKS * drive.track_width) / check.drive;
        let linear = most(least(check.speed * full, enough), ABOVE_LEAST * drive.min_linear);
        let turn = drive.limited(Twist::new(0.0, drive.max_angular)).angular;
        let angular = most(least(check.speed * turn, TURN), ABOVE_LEAST * drive.min_angular);
        Self { check, linear: least(linear, full), angular: least(angular, turn), drive: *drive }
    }

    /// The part of this number, rests and motions in turn; none after the last motion.
    pub fn part(&self, number: u32) -> Option<Part> {
        let Check { rest, turn, drive, pause, .. } = self.check;
        let motion = number / 2;
        if motion as usize >= MOTIONS {
            return None;
        }
        if number.is_multiple_of(2) {
            let duration = if number == 0 { rest } else { pause };
            return Some(Part { twist: Twist::ZERO, duration });
        }
        let (linear, angular, duration) = match motion {
            0 | 6 => (0.0, self.angular, turn),
            3 => (0.0, -self.angular, 2.0 * turn),
            1 | 4 => (self.linear, 0.0, drive),
            _ => (-self.linear, 0.0, drive),
        };
        Some(Part { twist: Twist::new(linear, angular), duration })
    }

    /// Rest in s after the last motion.
    pub fn last_rest(&self) -> f64 {
        LAST_REST + self.drive.dead_time + self.drive.lag
    }

    /// Time in s from the beginning to the end, without the ramps.
    pub fn duration(&self) -> f64 {
        let parts = (0..).map_while(|number| self.part(number));
        parts.map(|part| part.duration).sum::<f64>() + self.last_rest()
    }

    /// How far in m the robot drives from where it stands, in either of two directions and back.
    pub fn length(&self) -> f64 {
        self.linear * self.check.drive
    }

    /// Distance in m from its beginning at which a robot is too far away.
    pub fn allowed(&self) -> f64 {
        ALLOWED * self.length()
    }

    /// Whether a robot cannot be so fast in m/s whatever is wrong with its wheels.
    pub fn is_impossible(&self, speed: f64) -> bool {
        speed > IMPOSSIBLE * self.linear
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(wiggle: &Wiggle) -> Vec<Part> {
        (0..).map_while(|number| wiggle.part(number)).collect()
    }

    #[test]
    fn it_ends_where_and_as_it_begins() {
        let wiggle = Wiggle::new(Check::default(), &Drive::default());
        let parts = parts(&wiggle);
        assert_eq!(parts.len(), 2 * MOTIONS);
        let turned: f64 = parts.iter().map(|it| it.twist.angular * it.duration).sum();
        let driven: f64 = parts.iter().map(|it| it.twist.linear * it.duration).sum();
        assert!(turned.abs() < 1e-12 && driven.abs() < 1e-12);
        assert!((18.0..24.0).contains(&wiggle.duration()), "{}", wiggle.duration());
        assert!(wiggle.length() < 0.3);
    }

    #[test]
    fn it_keeps_to_the_limits_of_any_drive() {
        let coin = Drive {
            wheel_radius: 0.005,
            track_width: 0.02,
            max_linear: 0.08,
            min_linear: 0.005,
            max_wheel_speed: 20.0,
            ..Drive::default()
        };
        let truck = Drive {
            wheel_radius: 0.1,
            track_width: 1.3,
            max_linear: 2.0,
            max_wheel_speed: 25.0,
            ..Drive::default()
        };
        for drive in [coin, Drive::default(), truck] {
            let wiggle = Wiggle::new(Check::default(), &drive);
            for Part { twist, .. } in parts(&wiggle) {
                assert_eq!(drive.limited(twist), twist);
                assert!(twist.linear == 0.0 || twist.linear.abs() > drive.min_linear);
            }
            assert!(wiggle.length() <= 2.0 * drive.track_width + 0.3);
        }
    }
}
