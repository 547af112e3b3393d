//! `ekf-packet`: an extended Kalman filter, h-step prediction and packets of many commands.
//!
//! Source: Cuenca et al., "A Remote Control Strategy for an Autonomous Vehicle with Slow Sensor Using Kalman Filtering and
//! Dual-Rate Control", Sensors 19(13) 2983, 2019 (doi 10.3390/s19132983); its sibling with Zheng and Tomizuka is Alcaina et
//! al., Journal of Sensors 7085915, 2019. We had their abstracts and introductions.
//!
//! Taken from there: the filter fuses what is sensed at a fast rate on the vehicle with the slow camera; its estimate is
//! predicted ahead to the moment the command acts; a packet carries the commands of many periods, and the vehicle plays
//! them by the time for as long as newer packets are late.
//!
//! Ours:
//! - The state is (x, y, heading): our robot's dynamics beyond it, lag and dead time, are known to every contender.
//! - Their fast sensors are on the vehicle. Ours reports what it plays, so the motion between two poses is that of the
//!   commands as played ([`Attribution::Played`]).
//! - The process noise is proportional to that motion, with the law of the thesis's errors (white in time), and a floor for
//!   what the reports do not explain. It is [`EkfTuning`].
//! - The law is the quadratic curve of the thesis: theirs is a path follower of the same kind (pure pursuit).

use super::without_identification;
use nalgebra::{Matrix3, Vector3};
use umwelt_core::controller::compensation::{
    Compensation, NominalDelay, PoseEstimator, QuadraticCurve,
};
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Displacement, Pose};
use umwelt_core::identification::Belief;
use umwelt_core::prediction::{ERROR_WINDOW, ErrorModel};
use umwelt_core::settings::{Attribution, Settings};
use umwelt_core::time::RobotTime;

/// Noise of the motion that the filter reckons with. Shares are standard deviations over 100 ms at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EkfTuning {
    /// Error per metre driven and per radian turned.
    pub share: f64,
    /// Heading error in rad per metre driven.
    pub drift: f64,
    /// Error of position in m and of heading in rad in 100 ms, whatever is commanded.
    pub floor: (f64, f64),
    /// What the robot is taken to have moved by.
    pub attribution: Attribution,
}

impl Default for EkfTuning {
    fn default() -> Self {
        Self { share: 0.05, drift: 0.1, floor: (0.0002, 0.001), attribution: Attribution::Played }
    }
}

impl EkfTuning {
    /// What it decides by, for the camera that `settings` describe.
    pub fn compensation(&self, settings: &Settings) -> Compensation<EkfPacket> {
        let estimator = EkfPacket::new(*self, settings);
        Compensation { estimator, delay: NominalDelay, follower: QuadraticCurve }
    }

    /// The settings of its controller.
    pub fn settings(&self, settings: &Settings) -> Settings {
        Settings { attribution: self.attribution, ..without_identification(settings) }
    }
}

/// The filter: poses are weighed against the motion that the commands make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EkfPacket {
    tuning: EkfTuning,
    /// Covariance of the camera.
    camera: Matrix3<f64>,
    /// Covariance of the pose estimated last.
    covariance: Matrix3<f64>,
    /// When that pose was taken, and where it was estimated to be.
    last: Option<(RobotTime, Pose)>,
}

impl EkfPacket {
    /// Packets of many commands: the thesis's longest horizon.
    pub const SLOTS: usize = 20;

    /// A filter for the camera that `settings` describe.
    pub fn new(tuning: EkfTuning, settings: &Settings) -> Self {
        let noise = settings.noise;
        let (position, heading) = (noise.position.powi(2), noise.heading.powi(2));
        let camera = Matrix3::from_diagonal(&Vector3::new(position, position, heading));
        Self { tuning, camera, covariance: camera, last: None }
    }

    /// Covariance of (x, y, heading) of the pose estimated last, in m^2, m rad and rad^2.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.covariance
    }

    /// Covariance of the error made in `span` s along `moved`, in the body frame: errors white in time, as in the thesis.
    fn process(&self, moved: Displacement, span: f64) -> Matrix3<f64> {
        let EkfTuning { share, drift, floor, .. } = self.tuning;
        // Var = sigma^2 0.1 s int v^2 dt, and int v^2 dt = length^2/span.
        let power = ERROR_WINDOW / span;
        let length_power = (moved.forward.powi(2) + moved.lateral.powi(2)) * power;
        let turn_power = moved.turn.powi(2) * power;
        let windows = span / ERROR_WINDOW;
        let position = share.powi(2) * length_power + floor.0.powi(2) * windows;
        let heading =
            share.powi(2) * turn_power + drift.powi(2) * length_power + floor.1.powi(2) * windows;
        // Errors along and across are alike, so that the frame does not matter.
        Matrix3::from_diagonal(&Vector3::new(position, position, heading))
    }
}

impl PoseEstimator for EkfPacket {
    fn reset(&mut self, observation: Observation) {
        self.covariance = self.camera;
        self.last = Some((observation.taken, observation.pose));
    }

    fn filter_pose(
        &mut self,
        taken: RobotTime,
        observed: Pose,
        predicted: Pose,
        moved: Displacement,
    ) -> Pose {
        let Some((before, from)) = self.last else {
            self.reset(Observation { pose: observed, taken });
            return observed;
        };
        // d(x, y)/d(heading) of a rigid motion is the motion turned by a quarter.
        let (dx, dy) = (predicted.x - from.x, predicted.y - from.y);
        let jacobian = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let process = self.process(moved, (taken - before).max(1e-3));
        let ahead = jacobian * self.covariance * jacobian.transpose() + process;
        // K = P (P + R)^-1; a perfect camera without process noise leaves nothing to weigh.
        let Some(inverse) = (ahead + self.camera).try_inverse() else {
            self.reset(Observation { pose: observed, taken });
            return observed;
        };
        let gain = ahead * inverse;
        let innovation = Vector3::new(
            observed.x - predicted.x,
            observed.y - predicted.y,
            observed.heading.minus(predicted.heading),
        );
        let change = gain * innovation;
        // Joseph's form stays symmetric and positive.
        let kept = Matrix3::identity() - gain;
        self.covariance = kept * ahead * kept.transpose() + gain * self.camera * gain.transpose();
        let heading = (predicted.heading + change.z).radians();
        let pose = Pose::new(predicted.x + change.x, predicted.y + change.y, heading);
        self.last = Some((taken, pose));
        pose
    }

    fn error_model(&self, _: &Belief, _: Pose) -> ErrorModel {
        ErrorModel::PERFECT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;
    use umwelt_core::controller::{ACCEPTED_AGAIN, Controller};
    use umwelt_core::exchange::Request;
    use umwelt_core::settings::PoseNoise;

    /// RMS errors of position in m and heading in rad, estimated and observed, on a straight run with slip.
    fn errors() -> [(f64, f64); 2] {
        let noise = PoseNoise::CAMERA;
        let mut filter =
            EkfPacket::new(EkfTuning::default(), &Settings { noise, ..Settings::default() });
        let mut rng = Pcg64::seed_from_u64(1);
        let mut draw = |sd: f64| Normal::new(0.0, sd).unwrap().sample(&mut rng);
        let (mut truth, mut believed) = (Pose::default(), None);
        let mut squares = [(0.0, 0.0); 2];
        let steps = 2000;
        for step in 0..steps {
            let moved = Displacement { forward: 0.13 * 0.03, ..Displacement::default() };
            let slipped = Displacement {
                forward: moved.forward * (1.0 + draw(0.04)),
                turn: draw(0.0004),
                ..moved
            };
            truth = truth.then(slipped);
            let (x, y) = (truth.x + draw(noise.position), truth.y + draw(noise.position));
            let observed = Pose::new(x, y, truth.heading.radians() + draw(noise.heading));
            let taken = RobotTime::new(f64::from(step) * 0.03);
            let predicted = believed.map_or(observed, |pose: Pose| pose.then(moved));
            let pose = filter.filter_pose(taken, observed, predicted, moved);
            believed = Some(pose);
            for (squares, pose) in squares.iter_mut().zip([pose, observed]) {
                squares.0 += pose.point().distance(truth.point()).powi(2);
                squares.1 += pose.heading.minus(truth.heading).powi(2);
            }
        }
        squares.map(|it| ((it.0 / f64::from(steps)).sqrt(), (it.1 / f64::from(steps)).sqrt()))
    }

    #[test]
    fn estimates_are_nearer_the_truth_than_what_the_camera_says() {
        let [believed, observed] = errors();
        assert!(believed.0 < 0.8 * observed.0, "{believed:?} {observed:?}");
        assert!(believed.1 < 0.8 * observed.1, "{believed:?} {observed:?}");
    }

    /// The Jacobian, computed the naive way.
    #[test]
    fn an_unsure_heading_becomes_an_unsure_position() {
        let moved = Displacement { forward: 0.2, lateral: 0.05, turn: 0.3 };
        let from = Pose::new(0.3, -0.1, 0.8);
        let turned = Pose::new(0.3, -0.1, 0.8 + 1e-6);
        let (one, other) = (from.then(moved), turned.then(moved));
        let (dx, dy) = (one.x - from.x, one.y - from.y);
        assert!(((other.x - one.x) / 1e-6 + dy).abs() < 1e-6);
        assert!(((other.y - one.y) / 1e-6 - dx).abs() < 1e-6);
        // And it is the one in use: after a long blind drive x and y covary as the chord is turned.
        let noise = PoseNoise { position: 1.0, heading: 1e-3 };
        let exact = EkfTuning { share: 0.0, drift: 0.0, floor: (0.0, 0.0), ..EkfTuning::default() };
        let mut filter = EkfPacket::new(exact, &Settings { noise, ..Settings::default() });
        filter.reset(Observation { pose: from, taken: RobotTime::ZERO });
        filter.covariance = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1e-6));
        filter.filter_pose(RobotTime::new(1.0), one, one, moved);
        let covariance = filter.covariance();
        assert!((covariance[(0, 1)] / covariance[(1, 1)] + dy / dx).abs() < 1e-6, "{covariance}");
    }

    /// Guards against: a robot that was carried away, and a filter that takes it for one that drove there.
    #[test]
    fn a_robot_that_was_carried_away_is_filtered_anew() {
        let settings = Settings { noise: PoseNoise::CAMERA, ..Settings::default() };
        let mut controller =
            Controller::with(settings, EkfTuning::default().compensation(&settings));
        let camera = controller.compensation().estimator.camera;
        for sequence in 1..=10 + u64::from(ACCEPTED_AGAIN) {
            let taken = RobotTime::new(sequence as f64 * 0.03);
            let x = if sequence <= 10 { 0.0 } else { 1.0 };
            let mut request = Request { sequence, sent: taken + 0.13, ..Request::EMPTY };
            request.observations.push(Observation { pose: Pose::new(x, 0.0, 0.0), taken });
            controller.step(&request);
            let is_first = sequence == 1 || x == 1.0 && controller.pose().unwrap().pose.x == 1.0;
            assert_eq!(controller.compensation().estimator.covariance() == camera, is_first);
        }
        assert_eq!(controller.compensation().estimator.covariance(), camera);
    }
}
