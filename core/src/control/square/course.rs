//! The motions of a square: what is commanded, in which order, and how much room and time it takes.

use crate::geometry::Twist;
use crate::geometry::elementary::{least, most};
use crate::kinematics::Drive;
use crate::task::Square;
use std::f64::consts::FRAC_PI_2;

/// Motions of a run: four sides, a turn after each.
pub const MOTIONS: u32 = 8;

/// The side in track widths where none is said: 1 m for a robot of 0.1 m. UMBmark drives 4 m with one of 0.35 m.
const SIDE_TRACKS: f64 = 10.0;

/// The side in m where none is said is at least so long, and at most as UMBmark has it.
const SIDE: (f64, f64) = (0.5, 4.0);

/// A motor turns surely at so many times the smallest speed described.
const ABOVE_LEAST: f64 = 1.25;

/// Time in s after which a robot rests to which zero is commanded, beside its own delay: what of that may not be described.
const SETTLE: f64 = 0.4;

/// Lags after which nothing is left of a speed: one part in 150.
const LAGS: f64 = 5.0;

/// Time in s for which a robot at rest is seen after a motion.
const REST: f64 = 0.6;

/// The same at the beginning and the end of a run, whose poses make its return error.
const LONG_REST: f64 = 1.2;

/// A part of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// Rest for so many s, from when zero is commanded.
    Rest(f64),
    /// Drive so many m ahead.
    Side(f64),
    /// Turn in place by so many rad, to the left where positive.
    Turn(f64),
}

/// The course of one robot: all runs of its square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    square: Square,
    side: f64,
    /// Speeds in m/s and rad/s.
    fastest: Twist,
    drive: Drive,
}

impl Course {
    /// The course of a robot with this drive.
    pub fn new(square: Square, drive: &Drive) -> Self {
        let (shortest, longest) = SIDE;
        let derived = (SIDE_TRACKS * drive.track_width).clamp(shortest, longest);
        let full = drive.limited(Twist::new(drive.max_linear, 0.0)).linear;
        let turn = drive.limited(Twist::new(0.0, drive.max_angular)).angular;
        let linear = most(square.speed * full, ABOVE_LEAST * drive.min_linear);
        let angular = most(square.speed * turn, ABOVE_LEAST * drive.min_angular);
        let fastest = Twist::new(least(linear, full), least(angular, turn));
        Self { square, side: square.side.unwrap_or(derived), fastest, drive: *drive }
    }

    /// The square as it was asked for.
    pub fn square(&self) -> Square {
        self.square
    }

    /// Number of runs, both ways together.
    pub fn runs(&self) -> u32 {
        2 * self.square.runs
    }

    /// Whether a run turns to the left; runs do in turn.
    pub fn is_left(run: u32) -> bool {
        run.is_multiple_of(2)
    }

    /// The part of this number of a run, rests and motions in turn; none after its last motion.
    pub fn part(&self, run: u32, number: u32) -> Option<Part> {
        if run >= self.runs() || number > 2 * MOTIONS - 1 {
            return None;
        }
        if number.is_multiple_of(2) {
            let rest = if number == 0 { self.long_rest() } else { self.settling() + REST };
            return Some(Part::Rest(rest));
        }
        Some(self.motion(run, number / 2))
    }

    /// The motion of this number of a run: sides and turns in turn.
    pub fn motion(&self, run: u32, number: u32) -> Part {
        if number.is_multiple_of(2) {
            Part::Side(self.side)
        } else {
            Part::Turn(if Self::is_left(run) { FRAC_PI_2 } else { -FRAC_PI_2 })
        }
    }

    /// Length of a side in m.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// Largest speeds in m/s and rad/s.
    pub fn fastest(&self) -> Twist {
        self.fastest
    }

    /// Time in s after zero is commanded after which the robot rests.
    pub fn settling(&self) -> f64 {
        SETTLE + self.drive.dead_time + LAGS * self.drive.lag
    }

    /// Time in s of the rest at the beginning of a run, and at its end.
    pub fn long_rest(&self) -> f64 {
        self.settling() + LONG_REST
    }

    /// Time in s from the beginning to the end, without ramps and the link.
    pub fn duration(&self) -> f64 {
        let motions = 4.0 * (self.side / self.fastest.linear + FRAC_PI_2 / self.fastest.angular);
        let rests = f64::from(MOTIONS - 1) * (self.settling() + REST) + 2.0 * self.long_rest();
        f64::from(self.runs()) * (motions + rests)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::kinematics::arc;

    fn parts(course: &Course, run: u32) -> Vec<Part> {
        (0..).map_while(|number| course.part(run, number)).collect()
    }

    #[test]
    fn a_run_ends_where_it_begins_to_the_left_and_then_to_the_right() {
        let course = Course::new(Square { runs: 2, ..Square::default() }, &Drive::default());
        assert_eq!((course.runs(), course.side()), (4, 1.0));
        for run in 0..4 {
            let (mut pose, mut farthest) = (Pose::default(), 0.0_f64);
            for part in parts(&course, run) {
                pose = pose.then(match part {
                    Part::Rest(_) => arc(0.0, 0.0),
                    Part::Side(length) => arc(length, 0.0),
                    Part::Turn(angle) => arc(0.0, angle),
                });
                farthest = if pose.y.abs() > farthest.abs() { pose.y } else { farthest };
            }
            assert!(pose.x.abs() + pose.y.abs() + pose.heading.radians().abs() < 1e-12);
            let side = if Course::is_left(run) { 1.0 } else { -1.0 };
            assert!((farthest - side).abs() < 1e-12, "run {run}: {farthest}");
        }
        assert_eq!(course.part(4, 0), None);
    }

    #[test]
    fn the_side_follows_the_robot_where_none_is_said() {
        let side = |track_width: f64, side: Option<f64>| {
            let drive = Drive { track_width, ..Drive::default() };
            Course::new(Square { side, ..Square::default() }, &drive).side()
        };
        assert_eq!([side(0.02, None), side(0.2, None), side(1.3, None)], [0.5, 2.0, 4.0]);
        assert_eq!(side(0.2, Some(0.7)), 0.7);
    }

    #[test]
    fn speeds_are_within_the_limits_of_any_drive() {
        let slow = Drive { min_linear: 0.12, min_angular: 1.2, ..Drive::default() };
        let weak = Drive { max_wheel_speed: 1.0, ..Drive::default() };
        for drive in [Drive::default(), slow, weak] {
            let Twist { linear, angular } = Course::new(Square::default(), &drive).fastest();
            for twist in [Twist::new(linear, 0.0), Twist::new(0.0, angular)] {
                assert_eq!(drive.limited(twist), twist);
            }
            assert!(linear >= drive.min_linear && angular >= drive.min_angular);
        }
    }
}
