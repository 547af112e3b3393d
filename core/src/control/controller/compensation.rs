//! What a method of control decides: where the robot is believed to be, when and where its next command will act, what
//! error to reckon with there, and how to drive from there.
//!
//! Everything else (when a task goes on, acceleration, the variance rule, horizons, arrival) is the same for all, so
//! that methods are compared in these decisions alone. [`Identified`], the controller of the thesis and of the server,
//! takes every default; the peers of `umwelt_lab::peers` take their own.

use crate::exchange::{Delivery, Observation};
use crate::geometry::{Displacement, Point, Pose, Twist};
use crate::identification::{Belief, Samples};
use crate::prediction::{ErrorModel, Prediction};
use crate::settings::Settings;

/// Longest time in s that a pose is predicted ahead; beyond it the robot rests until a fresh pose comes.
const MAX_AHEAD: f64 = 2.0;

/// One decision each; the defaults are the thesis's method, which predicts by what it has identified.
pub trait Compensation {
    /// Whether the [watch](crate::watch) looks after the robot. Methods of others are driven as they were published: it
    /// does not.
    fn is_watched(&self) -> bool {
        false
    }

    /// A reply's loop delay was reported.
    fn learn(&mut self, delivery: &Delivery) {
        let _ = delivery;
    }

    /// Samples came of a window of motion from `start` s on, before `belief` takes them in.
    fn witness(&mut self, belief: &Belief, samples: &Samples, start: f64) {
        let _ = (belief, samples, start);
    }

    /// Poses begin anew with `observation`: nothing is known of the motion before it.
    fn begin(&mut self, observation: Observation) {
        let _ = observation;
    }

    /// The pose to go on from, where one was observed at `taken` s. By the commands alone the robot has moved by `moved`
    /// since the last pose gone on from, and stands at `predicted`.
    fn believe(
        &mut self,
        taken: f64,
        observed: Pose,
        predicted: Pose,
        moved: Displacement,
    ) -> Pose {
        let _ = (taken, predicted, moved);
        observed
    }

    /// Time in s from a pose being taken to the command that answers it being in force.
    fn loop_delay(&self, settings: &Settings) -> f64 {
        settings.loop_delay
    }

    /// Time in s between a pose and the command that answers it beyond which the robot is to rest.
    fn patience(&self, settings: &Settings) -> f64 {
        let _ = settings;
        MAX_AHEAD
    }

    /// The errors to reckon with around `pose`.
    fn model(&self, belief: &Belief, pose: Pose) -> ErrorModel {
        let _ = pose;
        belief.model()
    }

    /// The pose when the next command comes into force at `begins` s, where `observed` was gone on from at `taken` s and
    /// the commands in flight lead to `predicted`.
    fn predict(
        &self,
        settings: &Settings,
        taken: f64,
        observed: Pose,
        begins: f64,
        predicted: Prediction,
    ) -> Prediction {
        let _ = (settings, taken, observed, begins);
        predicted
    }

    /// The twist to drive with; none for the quadratic curve at the speed that the way allows.
    fn steer(&self, settings: &Settings, way: &Way) -> Option<Twist> {
        let _ = (settings, way);
        None
    }
}

/// Where a driving robot is, and where it is to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Where it would come to rest if the command were zero from now on, by prediction.
    pub pose: Pose,
    /// The command in force until now.
    pub previous: Twist,
    /// Where the leg begins; none for the first leg, which begins wherever the robot stood.
    pub from: Option<Point>,
    /// Where it ends.
    pub to: Point,
    /// Whether it is driven in reverse.
    pub reverse: bool,
    /// The fastest speed in m/s from which the robot can still stop there, at least the slowest at which it moves.
    pub speed: f64,
    /// Time in s since the command in force began.
    pub since_change: f64,
}

/// The method of the thesis and of the server: everything follows from what was identified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identified;

impl Compensation for Identified {
    fn is_watched(&self) -> bool {
        true
    }
}
