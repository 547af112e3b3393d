//! The decisions in which methods of control differ: where the robot is and will be ([`PoseEstimator`]), how late commands
//! act ([`DelayModel`]), and how to drive to a point ([`PathFollower`]).
//!
//! Everything else (when a task goes on, acceleration, the variance rule, horizons, arrival) is the same for all, so
//! that methods are compared in these decisions alone. A [`Compensation`] holds one of each. That of the thesis and of the
//! server is [`Identified`], [`NominalDelay`] and [`QuadraticCurve`]; a peer of `umwelt_lab::peers` replaces those in which
//! it differs.

use crate::exchange::{Delivery, Observation};
use crate::geometry::{Displacement, Point, Pose, Twist};
use crate::identification::Belief;
use crate::prediction::{ErrorModel, Prediction};
use crate::settings::Settings;
use crate::steering;
use crate::task::Limit;
use crate::time::RobotTime;

/// Longest time in s that a pose is predicted ahead; beyond it the robot rests until a fresh pose comes.
pub(super) const MAX_AHEAD: f64 = 2.0;

/// Where the robot is, and where it will be when its next command acts. The defaults are the thesis's method: poses are
/// taken as observed, and predicted by the errors that were identified.
pub trait PoseEstimator {
    /// Poses begin anew with `observation`: nothing is known of the motion before it.
    fn reset(&mut self, observation: Observation) {
        let _ = observation;
    }

    /// The pose to go on from, where one was observed at `taken`. By the commands alone the robot has moved by `moved`
    /// since the last pose gone on from, and stands at `predicted`.
    fn filter_pose(
        &mut self,
        taken: RobotTime,
        observed: Pose,
        predicted: Pose,
        moved: Displacement,
    ) -> Pose {
        let _ = (taken, predicted, moved);
        observed
    }

    /// The errors to reckon with around `pose`.
    fn error_model(&self, belief: &Belief, pose: Pose) -> ErrorModel {
        let _ = pose;
        belief.model()
    }

    /// The pose when the next command comes into force at `begins`, where `observed` was gone on from at `taken` and
    /// the commands in flight lead to `predicted`.
    fn predict_pose(
        &self,
        settings: &Settings,
        taken: RobotTime,
        observed: Pose,
        begins: RobotTime,
        predicted: Prediction,
    ) -> Prediction {
        let _ = (settings, taken, observed, begins);
        predicted
    }
}

/// How late commands act, and how old a pose may be. The defaults are the thesis's: the delay is as described.
pub trait DelayModel {
    /// A reply's loop delay was reported.
    fn on_delivery(&mut self, delivery: &Delivery) {
        let _ = delivery;
    }

    /// Time in s from a pose being taken to the command that answers it being in force.
    fn loop_delay(&self, settings: &Settings) -> f64 {
        settings.loop_delay
    }

    /// Time in s between a pose and the command that answers it beyond which the robot is to rest.
    fn max_pose_age(&self, settings: &Settings) -> f64 {
        let _ = settings;
        MAX_AHEAD
    }
}

/// How to drive to a point.
pub trait PathFollower {
    /// The twist to drive with, and what limits its speed.
    fn steer(&self, settings: &Settings, way: &Way) -> (Twist, Limit);
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
    /// The fastest speed in m/s from which the robot can still stop there.
    pub stoppable: f64,
    /// The slowest speed in m/s at which the robot moves.
    pub slowest: f64,
    /// Whether the watch raised the smallest speeds.
    pub is_raised: bool,
    /// Time in s since the command in force began.
    pub since_change: f64,
}

impl Way {
    /// The fastest speed in m/s for the next slot: one from which the robot can still stop, at least the slowest at which it
    /// moves.
    pub fn speed(&self, settings: &Settings) -> f64 {
        self.stoppable.clamp(self.slowest, settings.drive.max_linear)
    }
}

/// A method of control: one decision of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compensation<E = Identified, D = NominalDelay, F = QuadraticCurve> {
    /// Where the robot is and will be.
    pub estimator: E,
    /// How late commands act.
    pub delay: D,
    /// How to drive to a point.
    pub follower: F,
}

impl Compensation {
    /// The method of the thesis and of the server.
    pub const STANDARD: Self =
        Self { estimator: Identified, delay: NominalDelay, follower: QuadraticCurve };
}

/// The estimator of the thesis and of the server: everything follows from what was identified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identified;

impl PoseEstimator for Identified {}

/// The delay model of the thesis and of the server: the loop delay of the settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NominalDelay;

impl DelayModel for NominalDelay {}

/// The path follower of the thesis and of the server: a [quadratic curve](steering::curve) to the point, at a speed from
/// which the robot can stop there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QuadraticCurve;

impl PathFollower for QuadraticCurve {
    fn steer(&self, settings: &Settings, way: &Way) -> (Twist, Limit) {
        let drive = &settings.drive;
        let (ahead, aside) = way.pose.toward(way.to);
        let wanted = steering::curve(ahead, aside, settings.steering.alpha);
        let limited = drive.limited(wanted);
        let allowed = limited.linear.abs().min(way.stoppable);
        let speed = allowed.max(way.slowest);
        let limit = if speed > allowed && way.is_raised {
            Limit::Watch
        } else if way.stoppable < limited.linear.abs() {
            Limit::Waypoint
        } else if limited.linear.abs() < wanted.linear.abs() {
            Limit::Drive
        } else {
            Limit::Alpha
        };
        // The curve belongs to the speed that is really reached.
        let forward = Twist::new(speed.copysign(wanted.linear), 0.0);
        let reached = drive.reach(way.previous, forward, way.since_change).linear;
        let bend = wanted.angular / wanted.linear;
        let angular = (bend * reached).clamp(-drive.max_angular, drive.max_angular);
        let limit = if reached.abs() < speed { Limit::Acceleration } else { limit };
        (Twist::new(reached, angular), limit)
    }
}
