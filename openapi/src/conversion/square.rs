//! The square of a task, and its report.

use crate::square::{Direction, Ending, Error, Report, Return, Square, Systematic};
use umwelt_core::geometry::Point;
use umwelt_core::square;
use umwelt_core::task;

impl From<task::Square> for Square {
    fn from(core: task::Square) -> Self {
        Self { side_m: core.side, runs: core.runs, speed_share: core.speed }
    }
}

impl Square {
    /// In core's terms.
    pub(super) fn convert(&self) -> task::Square {
        task::Square { side: self.side_m, runs: self.runs, speed: self.speed_share }
    }
}

impl From<square::Ending> for Ending {
    fn from(core: square::Ending) -> Self {
        match core {
            square::Ending::Driven => Self::Driven,
            square::Ending::TooFewPoses => Self::TooFewPoses,
            square::Ending::Interrupted => Self::Interrupted,
            square::Ending::TooFar => Self::TooFar,
        }
    }
}

impl From<Point> for Error {
    fn from(core: Point) -> Self {
        Self { x_m: core.x, y_m: core.y }
    }
}

impl From<&square::Return> for Return {
    fn from(core: &square::Return) -> Self {
        Self {
            direction: if core.is_left { Direction::Left } else { Direction::Right },
            error: core.error.into(),
            heading_rad: core.heading,
            side_m: core.side,
        }
    }
}

impl From<square::Systematic> for Systematic {
    fn from(core: square::Systematic) -> Self {
        Self {
            figure_m: core.figure,
            left: core.left.into(),
            right: core.right.into(),
            alpha_rad: core.angles.alpha,
            beta_rad: core.angles.beta,
            track_width_m: core.track_width,
            wheel_ratio: core.wheel_ratio,
            length_ratio: core.length_ratio,
            wheel_radius_m: core.wheel_radius,
            track_width_with_radius_m: core.track_width_with_radius,
        }
    }
}

impl From<&square::Report> for Report {
    fn from(core: &square::Report) -> Self {
        Self {
            ending: core.ending.into(),
            side_m: core.side,
            returns: core.returns.iter().map(Return::from).collect(),
            systematic: core.systematic.map(Systematic::from),
            described_track_width_m: core.described.track_width,
            described_wheel_radius_m: core.described.wheel_radius,
            span_s: core.span,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot;
    use umwelt_core::kinematics::Drive;
    use umwelt_core::square::Course;

    #[test]
    fn names_are_those_of_the_wire() {
        for ending in [Ending::Driven, Ending::TooFewPoses, Ending::Interrupted, Ending::TooFar] {
            assert_eq!(serde_json::to_value(ending).unwrap().as_str(), Some(ending.name()));
        }
        assert_eq!(serde_json::from_str::<Ending>("\"of-tomorrow\"").unwrap(), Ending::Other);
        assert_eq!(serde_json::to_value(Direction::Left).unwrap(), Direction::Left.name());
    }

    /// What the contract says of room and time, held against core's own course.
    #[test]
    fn room_and_time_are_those_of_core() {
        assert_eq!(task::Square::default(), Square::default().convert());
        assert_eq!(u64::from(task::MAX_RUNS), crate::square::MAX_RUNS);
        let truck =
            Drive { track_width: 1.3, max_linear: 2.0, max_wheel_speed: 80.0, ..Drive::default() };
        let slow = Drive { max_wheel_speed: 1.0, dead_time: 0.4, lag: 0.1, ..Drive::default() };
        let coarse = Drive { min_linear: 0.12, min_angular: 1.2, ..Drive::default() };
        for drive in [Drive::default(), truck, slow, coarse] {
            for wire in [Square::default(), Square { side_m: Some(0.7), runs: 3, speed_share: 0.3 }]
            {
                let core = Course::new(wire.convert(), &drive);
                let described = robot::Drive::from(drive);
                assert!((core.side() - wire.side_of_m(&described)).abs() < 1e-12, "{drive:?}");
                assert!((core.duration() - wire.duration_s(&described)).abs() < 1e-9, "{drive:?}");
            }
        }
    }
}
