//! Methods of others, to be compared with: each is a [`Compensation`] of the same controller.
//!
//! They drive the same tasks under the same limits and know the same robot; what is theirs is how they deal with delay.
//! None of them identifies the floor or slows down for what it does not know.

use crate::controller::compensation::Compensation;
use crate::controller::settings::Settings;
use crate::geometry::Pose;
use crate::prediction::Prediction;

/// Steers by the last pose as if the robot stood there now: no delay is made up for.
///
/// What a controller does that was written for a wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoCompensation;

impl Compensation for NoCompensation {
    fn loop_delay(&self, _: &Settings) -> f64 {
        // Its commands come into force as soon as they arrive.
        0.0
    }

    fn predict(
        &self,
        settings: &Settings,
        _: f64,
        observed: Pose,
        _: f64,
        _: Prediction,
    ) -> Prediction {
        Prediction::moments(observed, settings.noise)
    }
}

/// Predicts as the thesis does but stops for everything late: the server where the newest pose is old, the robot where no
/// command comes.
///
/// What operators ask of a robot that has no other remedy: a timeout of a quarter of a second (ROS 2 controllers, see the
/// field facts).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StopWhenStale;

impl StopWhenStale {
    /// Time in s for which the robot holds a command that no other one follows.
    pub const WATCHDOG: f64 = 0.10;

    /// Time in s beyond the nominal loop delay after which a pose is stale.
    const STALE: f64 = 0.10;
}

impl Compensation for StopWhenStale {
    fn patience(&self, settings: &Settings) -> f64 {
        settings.loop_delay + Self::STALE
    }
}
