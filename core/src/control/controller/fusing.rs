//! Where the robot is by all poses, for the method that fuses them: what its commands predict goes in from here.

use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::observing::MAX_GAP;
use super::{Controller, Track};
use crate::exchange::{Observation, PoseNoise};
use crate::fusion::{self, Fusion, Kind, Moved, NoiseBelief, Reach, Verdict};
use crate::geometry::{Displacement, Pose, WheelSpeeds};
use crate::kinematics;
use crate::prediction::{ERROR_WINDOW, Moments, Motion, Pieces};
use crate::settings::Settings;
use crate::time::RobotTime;
use nalgebra::Matrix3;

/// Longest time in s for which a pose may be on its way beside a newer one: later it says nothing of now.
const LATEST: f64 = 0.5;

/// Part of its speed by which a robot that moves steadily may be slower or faster at the next pose.
const STEADY: f64 = 0.05;

/// How a robot has moved by its commands.
struct Commanded {
    moved: Moved,
    motion: Motion,
    /// Whether at about the same speed all the time.
    is_steady: bool,
}

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// What is believed of the noise of poses; none where they are taken as they are observed.
    pub fn noise_belief(&self) -> Option<&NoiseBelief> {
        self.noise.as_deref()
    }

    /// Where the robot is by all poses; none where they are taken as they are observed.
    pub(super) fn fused(&self) -> Option<Pose> {
        Some(self.fusion.as_ref()?.pose().mean)
    }

    /// The noise of poses as it is identified; none where it is described, or does not matter.
    fn identified_noise(&self) -> Option<PoseNoise> {
        let belief = self.noise.as_ref().filter(|_| self.settings.identifies_noise)?;
        Some(belief.noise())
    }

    /// The noise of poses: as described, or as it is identified where it is not.
    pub(super) fn pose_noise(&self) -> PoseNoise {
        self.identified_noise().unwrap_or(self.settings.noise)
    }

    /// The covariance of an observed pose.
    fn noise_covariance(&self) -> Matrix3<f64> {
        let PoseNoise { position, heading } =
            self.identified_noise().unwrap_or_else(|| self.watch.noise(self.settings.noise));
        let position = position.max(PoseNoise::LEAST.position).powi(2);
        let heading = heading.max(PoseNoise::LEAST.heading).powi(2);
        Matrix3::from_diagonal(&[position, position, heading].into())
    }

    /// Poses begin anew with this one.
    pub(super) fn begin_fusion(&mut self, observation: &Observation) {
        if let Some(belief) = &mut self.noise {
            belief.begin();
            self.fusion = Some(Fusion::new(observation.pose, &self.noise_covariance()));
        }
    }

    /// Fuses a pose with where the robot was at the last one and what was commanded since. None where poses are taken as they
    /// are observed.
    pub(super) fn fuse(&mut self, track: &Track, observation: &Observation) -> Option<Verdict> {
        self.noise.as_ref()?;
        let noise = self.noise_covariance();
        let mut fusion = self.fusion.take().unwrap_or_else(|| Fusion::new(track.last.pose, &noise));
        let (from, taken) = (track.last.taken, observation.taken);
        let moved = self.moved(from, taken, track.wheels);
        let span = taken - from;
        let drive = &self.settings.drive;
        let reach = Reach { far: drive.max_linear * span, round: drive.max_angular * span };
        let verdict = fusion.observe(&moved.moved, reach, span, observation.pose, &noise);
        if verdict == Verdict::Accepted {
            self.learn_noise(track, observation, &moved);
        }
        self.fusion = Some(fusion);
        Some(verdict)
    }

    /// Takes in a pose that was taken before the newest one, at its time.
    pub(super) fn observe_late(&mut self, track: &Track, observation: &Observation) {
        let (taken, newest) = (observation.taken, track.last.taken);
        let Some(mut fusion) = self.fusion.take() else { return };
        if newest - taken <= LATEST && taken < newest && taken != track.seen.taken {
            let Settings { drive, attribution, .. } = &self.acting;
            let wheels = self.commands.at(*attribution, drive, taken - drive.dead_time);
            let moved = self.moved(taken, newest, wheels);
            fusion.observe_late(&moved.moved, observation.pose, &self.noise_covariance());
        }
        self.fusion = Some(fusion);
        if let (Some(pose), Some(track)) = (self.fused(), &mut self.track) {
            track.last.pose = pose;
        }
    }

    /// How the robot has moved by its commands, `wheels` being what they did at first.
    fn moved(&self, from: RobotTime, until: RobotTime, wheels: WheelSpeeds) -> Commanded {
        let drive = &self.acting.drive;
        let model = self.error_model(Pose::default());
        let mut moments = Moments::new(drive.kind, Pose::default(), PoseNoise::NONE);
        let mut motion = Motion::NONE;
        let now = self.motions(from, until, wheels, Pieces::gathered(), |piece| {
            moments.advance(&model, piece);
            motion = motion.then(piece);
        });
        let mean = moments.mean();
        let by = Displacement { forward: mean.x, lateral: mean.y, turn: mean.heading.radians() };
        // Motion begins and ends earlier or later than it is known to.
        let late = self.follows.as_ref().map_or(0.0, |follows| follows.late_sd());
        let [before, after] = [wheels, now].map(|speeds| kinematics::forward(drive, speeds));
        let off = [after.linear - before.linear, 0.0, after.angular - before.angular];
        let off = off.map(|change| (late * change).powi(2));
        let covariance = moments.covariance() + Matrix3::from_diagonal(&off.into());
        let is_steady = (after.linear - before.linear).abs() <= STEADY * after.linear.abs()
            && (after.angular - before.angular).abs() <= STEADY * after.angular.abs();
        Commanded { moved: Moved { by, covariance }, motion, is_steady }
    }

    /// Learns how noisy poses are from an accepted one.
    fn learn_noise(&mut self, track: &Track, observation: &Observation, moved: &Commanded) {
        let Some(belief) = &mut self.noise else { return };
        if observation.taken - track.seen.taken > MAX_GAP {
            belief.begin();
            return;
        }
        let by = track.unseen.then(moved.moved.by);
        let expected = track.seen.pose.then(by);
        let Displacement { forward, lateral, turn } = observation.pose.relative_to(expected);
        let off = [forward, lateral, turn];
        let half = self.settings.drive.track_width / 2.0;
        let Motion { length_power, turn_power, .. } = moved.motion;
        let round = half * half * turn_power;
        let kind = if length_power + round == 0.0 {
            Kind::Rest
        } else if !moved.is_steady {
            Kind::Unsteady
        } else if length_power > round {
            Kind::Drive
        } else {
            Kind::Turn
        };
        let power = ERROR_WINDOW * (length_power + round);
        belief.push(&fusion::Step { off, turn: by.turn, kind, power });
    }
}
