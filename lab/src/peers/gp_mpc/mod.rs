//! `gp-mpc`: a Gaussian process makes up for the delay, a short model predictive controller drives.
//!
//! Source: Jang et al., "Networked Operation of a UAV Using Gaussian Process-Based Delay Compensation and Model Predictive
//! Control", 2019, as the thesis describes it (model predictive control, a Gaussian process that learns the model, a delay
//! that changes with time). We did not have the paper itself.
//!
//! Taken from there: what the nominal model misses is learned from recent history by Gaussian-process regression and
//! extrapolated over the delay; the state predicted so is what the model predictive controller starts from.
//!
//! Ours:
//! - Their vehicle flies; what is regressed here is the velocity by which the robot's motion differs from the commanded one,
//!   in its body frame, over windows of about 0.1 s (at the rate of the camera it would drown in noise).
//! - Squared exponential kernel, hyperparameters fixed ([`GpTuning`]), known noise: that of two poses over a window.
//! - The controller shoots: a small grid of turns in two pieces instead of a solver ([`MpcTuning`]).
//! - One slot per packet, as the thesis says nothing of several.

mod process;
mod shooting;

pub use process::{GaussianProcess, GpTuning};
pub use shooting::{MpcTuning, ShootingMpc};

use super::without_identification;
use umwelt_core::controller::compensation::{Compensation, NominalDelay, PoseEstimator};
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Displacement, Pose};
use umwelt_core::identification::Belief;
use umwelt_core::prediction::{ErrorModel, Prediction};
use umwelt_core::settings::{Attribution, PoseNoise, Settings};
use umwelt_core::time::RobotTime;

/// A gap between poses in s, beyond which the history begins anew: what was there before says nothing of now.
const MAX_GAP: f64 = 0.5;

/// Constants of both halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpMpcTuning {
    /// Of the process of position rates (signal in m/s).
    pub position: GpTuning,
    /// Of the process of heading rates (signal in rad/s).
    pub heading: GpTuning,
    /// Shortest window in s of which the motion is a sample.
    pub window: f64,
    /// Of the controller.
    pub control: MpcTuning,
    /// What the robot is taken to have moved by.
    pub attribution: Attribution,
}

impl Default for GpMpcTuning {
    fn default() -> Self {
        Self {
            position: GpTuning { signal: 0.002, length: 3.0 },
            heading: GpTuning { signal: 0.02, length: 3.0 },
            window: 0.115,
            control: MpcTuning::default(),
            attribution: Attribution::Sent,
        }
    }
}

impl GpMpcTuning {
    /// What it decides by, for the camera that `settings` describe.
    pub fn compensation(
        &self,
        settings: &Settings,
    ) -> Compensation<GpEstimator, NominalDelay, ShootingMpc> {
        Compensation {
            estimator: GpEstimator::new(*self, settings),
            delay: NominalDelay,
            follower: ShootingMpc { tuning: self.control },
        }
    }

    /// The settings of its controller.
    pub fn settings(&self, settings: &Settings) -> Settings {
        Settings { attribution: self.attribution, ..without_identification(settings) }
    }
}

/// A window of motion that is not long enough yet.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Open {
    start: Observation,
    /// By the commands, from the start to the last pose.
    commanded: Displacement,
    /// When the last pose was taken.
    until: RobotTime,
}

/// The estimator: what the model has missed lately is extrapolated over the delay.
#[derive(Clone, Debug, PartialEq)]
pub struct GpEstimator {
    /// Shortest window in s of which the motion is a sample.
    shortest: f64,
    noise: PoseNoise,
    forward: GaussianProcess,
    lateral: GaussianProcess,
    turn: GaussianProcess,
    window: Option<Open>,
}

impl GpEstimator {
    /// An estimator for the camera that `settings` describe, which has seen nothing.
    pub fn new(tuning: GpMpcTuning, settings: &Settings) -> Self {
        let GpMpcTuning { position, heading, window, .. } = tuning;
        Self {
            shortest: window,
            noise: settings.noise,
            forward: GaussianProcess::new(position),
            lateral: GaussianProcess::new(position),
            turn: GaussianProcess::new(heading),
            window: None,
        }
    }

    /// The motion that the model is expected to miss from `from` to `until`, in the body frame: the expected rate,
    /// integrated by Simpson's rule.
    fn missed(&self, from: RobotTime, until: RobotTime) -> Displacement {
        let (from, until) = (from.seconds(), until.seconds());
        let (middle, span) = (f64::midpoint(from, until), until - from);
        let integral = |process: &GaussianProcess| {
            let [first, half, last] = [from, middle, until].map(|time| process.mean(time));
            span / 6.0 * (first + 4.0 * half + last)
        };
        Displacement {
            forward: integral(&self.forward),
            lateral: integral(&self.lateral),
            turn: integral(&self.turn),
        }
    }

    /// A sample of each rate: the motion observed over the window against the one commanded.
    fn sample(&mut self, window: &Open, end: &Observation) {
        let span = end.taken - window.start.taken;
        let expected = window.start.pose.then(window.commanded);
        let residual = end.pose.relative_to(expected);
        let time = f64::midpoint(window.start.taken.seconds(), end.taken.seconds());
        // Two poses, each with its noise.
        let noise = |sd: f64| (2.0_f64.sqrt() * sd / span).max(1e-6);
        let (position, heading) = (noise(self.noise.position), noise(self.noise.heading));
        self.forward.learn(time, residual.forward / span, position);
        self.lateral.learn(time, residual.lateral / span, position);
        self.turn.learn(time, residual.turn / span, heading);
    }
}

impl PoseEstimator for GpEstimator {
    fn reset(&mut self, observation: Observation) {
        for process in [&mut self.forward, &mut self.lateral, &mut self.turn] {
            process.forget();
        }
        let (start, until) = (observation, observation.taken);
        self.window = Some(Open { start, commanded: Displacement::default(), until });
    }

    fn filter_pose(
        &mut self,
        taken: RobotTime,
        observed: Pose,
        _: Pose,
        moved: Displacement,
    ) -> Pose {
        let end = Observation { pose: observed, taken };
        let Some(window) = self.window.filter(|window| taken - window.until <= MAX_GAP) else {
            self.reset(end);
            return observed;
        };
        let window = Open { commanded: window.commanded.then(moved), until: taken, ..window };
        self.window = if taken - window.start.taken >= self.shortest {
            self.sample(&window, &end);
            Some(Open { start: end, commanded: Displacement::default(), until: taken })
        } else {
            Some(window)
        };
        observed
    }

    fn error_model(&self, _: &Belief, _: Pose) -> ErrorModel {
        ErrorModel::PERFECT
    }

    fn predict_pose(
        &self,
        settings: &Settings,
        taken: RobotTime,
        _: Pose,
        begins: RobotTime,
        predicted: Prediction,
    ) -> Prediction {
        // How unsure the pose is does not matter: the variance rule is off.
        let pose = predicted.mean().then(self.missed(taken, begins));
        Prediction::moments(settings.drive.kind, pose, settings.noise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that slips by 3 % and drifts, seen by a perfect camera: both are found and reckoned with.
    #[test]
    fn what_the_model_misses_is_extrapolated_over_the_delay() {
        let settings = Settings { noise: PoseNoise::CAMERA, ..Settings::default() };
        let mut peer = GpEstimator::new(GpMpcTuning::default(), &settings);
        let (speed, slip, turned) = (0.13, -0.004, 0.02);
        let slot = 0.03;
        let commanded = Displacement { forward: speed * slot, ..Displacement::default() };
        let real =
            Displacement { forward: (speed + slip) * slot, lateral: 0.0, turn: turned * slot };
        let mut pose = Pose::default();
        peer.reset(Observation { pose, taken: RobotTime::ZERO });
        let mut taken = RobotTime::ZERO;
        for step in 1..60 {
            taken = RobotTime::new(f64::from(step) * slot);
            pose = pose.then(real);
            peer.filter_pose(taken, pose, pose, commanded);
        }
        let missed = peer.missed(taken, taken + 0.2);
        assert!((missed.forward / 0.2 - slip).abs() < 0.3 * slip.abs(), "{missed:?}");
        assert!((missed.turn / 0.2 - turned).abs() < 0.3 * turned, "{missed:?}");
        assert!(missed.lateral.abs() < 0.001);
        // A silence later nothing is known any more.
        peer.filter_pose(taken + 5.0, pose, pose, Displacement::default());
        assert_eq!(peer.missed(taken + 5.0, taken + 5.2), Displacement::default());
    }
}
