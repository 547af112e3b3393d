//! The noise that neighbouring windows share, and a sample corrected for what is known of it.

use super::super::window::Sample;
use crate::conjugate::NormalInverseChiSquared;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// Most of the variance of a pose's noise that the mean ratio may explain: the filter's steps are not exact, a variance
/// stays positive.
const MOST_EXPLAINED: f64 = 0.99;

/// What is known of the pose noise at the end of the last window: it enters the next one with the other sign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SharedNoise {
    /// When the shared pose was taken.
    taken: RobotTime,
    /// Expected noise of that pose along this channel.
    mean: f64,
    variance: f64,
    /// Its covariance with the mean ratio: where that is larger than believed, the pose was less far ahead.
    covariance: f64,
}

/// A sample as an observation of the mean ratio alone, by what is known of the pose that it begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corrected {
    /// Sample minus what is expected, in units of the ratio.
    pub innovation: f64,
    /// How much the innovation grows with the mean ratio; 1 where pose and mean have nothing to do with each other.
    pub response: f64,
    /// What the camera adds to the variance of the innovation, the mean being known.
    pub noise: f64,
    /// The same where nothing is known of the mean but by the samples.
    pub whole_noise: f64,
}

impl Corrected {
    /// What a sample from `start` on says of the mean ratio of which `posterior` is believed, where `shared` is known of
    /// the noise of an earlier pose.
    pub fn new(
        sample: &Sample,
        start: RobotTime,
        posterior: NormalInverseChiSquared,
        shared: Option<SharedNoise>,
    ) -> Self {
        let Sample { motion, pose_variance, other_variance, .. } = *sample;
        let unknown =
            SharedNoise { taken: start, mean: 0.0, variance: pose_variance, covariance: 0.0 };
        let shared = shared.filter(|shared| (shared.taken - start).abs() < 1e-6).unwrap_or(unknown);
        // Both together are at least as sure as a correlation of one would make them.
        let slope = shared.covariance / mean_variance(posterior);
        let explained = (slope * shared.covariance).min(MOST_EXPLAINED * shared.variance);
        let with = |variance: f64| (variance + pose_variance) / (motion * motion) + other_variance;
        Self {
            innovation: sample.ratio + shared.mean / motion - posterior.mu(),
            response: 1.0 - slope / motion,
            noise: with(shared.variance - explained),
            whole_noise: with(shared.variance),
        }
    }

    /// The scale^2 of the innovation where `posterior` is believed.
    pub fn scale_squared(&self, sample: &Sample, posterior: NormalInverseChiSquared) -> f64 {
        posterior.s() / posterior.r() / sample.weight
            + self.response * self.response * mean_variance(posterior)
            + self.noise
    }

    /// What is known of the noise of the pose at `end` once the sample is taken in: `posterior` is what was believed before.
    pub fn shared(
        &self,
        sample: &Sample,
        end: RobotTime,
        posterior: NormalInverseChiSquared,
    ) -> SharedNoise {
        let Sample { motion, pose_variance, .. } = *sample;
        let gain = pose_variance / motion / self.scale_squared(sample, posterior);
        SharedNoise {
            taken: end,
            mean: gain * self.innovation,
            variance: pose_variance - gain * pose_variance / motion,
            covariance: -gain * self.response * mean_variance(posterior),
        }
    }
}

/// Variance of the mean ratio, sigma^2 being as expected: (s/r)/k.
pub(super) fn mean_variance(posterior: NormalInverseChiSquared) -> f64 {
    posterior.s() / posterior.r() / posterior.k()
}
