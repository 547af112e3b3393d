//! Tasks and how far they have got.

use crate::checked::Checked;
use crate::robot_check::Wiggle;
use crate::square::Square;
use crate::task::{Calibration, Progress, Spec, Stage, Waypoint};
use crate::watch;
use umwelt_core::geometry::Point;
use umwelt_core::task;

impl From<task::Calibration> for Calibration {
    fn from(core: task::Calibration) -> Self {
        Self {
            rotations: core.rotations,
            angular_rad_per_s: core.angular,
            rotate_s: core.rotate,
            pause_s: core.pause,
            straight_m: core.straight,
        }
    }
}

impl From<&task::Task> for Spec {
    fn from(core: &task::Task) -> Self {
        Self {
            waypoints: core.waypoints.iter().map(|at| Waypoint { x_m: at.x, y_m: at.y }).collect(),
            tolerance_m: Some(core.tolerance),
            reverse: core.reverse,
            calibration: core.calibration.map(Calibration::from),
            max_deviation_m: core.max_deviation,
            check: core.check.map(Wiggle::from),
            square: core.square.map(Square::from),
        }
    }
}

impl From<task::Stage> for Stage {
    fn from(core: task::Stage) -> Self {
        match core {
            task::Stage::Idle => Self::Idle,
            task::Stage::Calibrating => Self::Calibrating,
            task::Stage::Turning => Self::Turning,
            task::Stage::Driving => Self::Driving,
            task::Stage::Stopping => Self::Stopping,
            task::Stage::Arrived => Self::Arrived,
        }
    }
}

impl From<Stage> for task::Stage {
    fn from(wire: Stage) -> Self {
        match wire {
            Stage::Idle => Self::Idle,
            Stage::Calibrating => Self::Calibrating,
            Stage::Turning => Self::Turning,
            Stage::Driving => Self::Driving,
            Stage::Stopping => Self::Stopping,
            Stage::Arrived => Self::Arrived,
        }
    }
}

impl From<task::Progress> for Progress {
    fn from(core: task::Progress) -> Self {
        Self {
            stage: core.stage.into(),
            leg: core.leg,
            legs: core.legs,
            deviation_m: core.deviation,
            max_deviation_m: core.max_deviation,
            elapsed_s: core.elapsed,
            limited_by: core.limited_by.map(watch::Limit::from),
            watch: core.watch.map(watch::State::from),
        }
    }
}

impl From<Progress> for task::Progress {
    fn from(wire: Progress) -> Self {
        Self {
            stage: wire.stage.into(),
            leg: wire.leg,
            legs: wire.legs,
            deviation: wire.deviation_m,
            max_deviation: wire.max_deviation_m,
            elapsed: wire.elapsed_s,
            limited_by: wire.limited_by.and_then(watch::Limit::to_core),
            watch: wire.watch.and_then(watch::State::to_core),
        }
    }
}

impl Checked<Spec> {
    /// The task in core's terms, with the `tolerance` in m of the robot where it says none.
    pub fn to_core(&self, tolerance: f64) -> task::Task {
        task::Task { tolerance: self.tolerance_m.unwrap_or(tolerance), ..self.convert() }
    }
}

impl Spec {
    /// The task in core's terms, whatever its values: what a program keeps was checked when it came.
    pub fn convert(&self) -> task::Task {
        task::Task {
            waypoints: self.waypoints.iter().map(|at| Point::new(at.x_m, at.y_m)).collect(),
            tolerance: self.tolerance_m.unwrap_or(task::TOLERANCE),
            reverse: self.reverse,
            max_deviation: self.max_deviation_m,
            check: self.check.map(|check| check.convert()),
            square: self.square.map(|square| square.convert()),
            calibration: self.calibration.map(|calibration| task::Calibration {
                rotations: calibration.rotations,
                angular: calibration.angular_rad_per_s,
                rotate: calibration.rotate_s,
                pause: calibration.pause_s,
                straight: calibration.straight_m,
            }),
        }
    }
}
