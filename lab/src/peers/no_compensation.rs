//! `no-compensation`: what a controller does that was written for a wire.

use umwelt_core::controller::compensation::{
    Compensation, DelayModel, PoseEstimator, QuadraticCurve,
};
use umwelt_core::geometry::Pose;
use umwelt_core::prediction::Prediction;
use umwelt_core::settings::Settings;
use umwelt_core::time::RobotTime;

/// Steers by the last pose as if the robot stood there now: no delay is made up for.
///
/// It knows when its own commands changed, and so does not mistake a robot that it stopped for one that drives; it does
/// not know that what it sees is old. Over a loop of 0.3 s the slowest speed carries a robot on by 7 mm, so that it drives
/// past its waypoint and has to come back; where it lags besides and its controller does not know (`systematic`), it passes
/// the tolerance of 10 mm each time and does not arrive at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoCompensation;

impl NoCompensation {
    /// What it decides by.
    pub fn compensation() -> Compensation<Self, Self> {
        Compensation { estimator: Self, delay: Self, follower: QuadraticCurve }
    }
}

impl DelayModel for NoCompensation {
    fn loop_delay(&self, _: &Settings) -> f64 {
        // Its commands come into force as soon as they arrive.
        0.0
    }
}

impl PoseEstimator for NoCompensation {
    fn predict_pose(
        &self,
        settings: &Settings,
        _: RobotTime,
        observed: Pose,
        _: RobotTime,
        _: Prediction,
    ) -> Prediction {
        Prediction::moments(settings.drive.kind, observed, settings.noise)
    }
}
