//! The estimator of a stationary channel: prior, posterior, sample statistics, and the noise shared by neighbouring windows.

use super::super::estimate::{Channel, ChannelEstimate, LEVEL, NORMAL_HALF_WIDTH};
use super::super::status::{Status, progress};
use super::super::window::Sample;
use super::noise::{Corrected, SharedNoise, mean_variance};
use super::statistics::Statistics;
use crate::conjugate::{NormalInverseChiSquared, SampleStatistics, student_t_half_width};
use crate::prediction::ChannelModel;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// What is believed of a channel whose ratio has one mean and one variance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stationary {
    channel: Channel,
    prior: NormalInverseChiSquared,
    posterior: NormalInverseChiSquared,
    statistics: Statistics,
    shared: Option<SharedNoise>,
    ln_evidence: f64,
}

impl Stationary {
    /// The belief before any sample.
    pub fn new(channel: Channel, prior: NormalInverseChiSquared) -> Self {
        Self {
            channel,
            prior,
            posterior: prior,
            statistics: Statistics::default(),
            shared: None,
            ln_evidence: 0.0,
        }
    }

    /// Takes in the sample of a window from `start` to `end`.
    ///
    /// Consecutive windows share a pose, whose noise enters them with opposite signs (correlation -1/2). A Kalman filter
    /// carries what the last window says about that noise together with the mean ratio: with e the noise of the pose at
    /// the window's beginning, E\[e | mu\] = e^ + a (mu - mu^) for a = Cov(mu, e)/Var(mu), so a sample is an observation
    /// of h mu, h = 1 - a/l, under noise that has nothing to do with mu. Each sample so enters by its likelihood given
    /// the ones before, and over many windows the noise of the poses between them cancels.
    pub fn update(&mut self, sample: &Sample, start: RobotTime, end: RobotTime) {
        let posterior = self.posterior;
        let corrected = Corrected::new(sample, start, posterior, self.shared);
        let Corrected { innovation, response, noise, .. } = corrected;
        let scale_squared = corrected.scale_squared(sample, posterior);
        self.ln_evidence += ln_student(posterior, scale_squared, posterior.mu() + innovation);
        let ratio = posterior.mu() + innovation;
        self.statistics.update(ratio, sample.weight, innovation / scale_squared.sqrt());
        self.shared = Some(corrected.shared(sample, end, posterior));
        let squared = response * response;
        self.posterior = posterior.update_noisy(
            posterior.mu() + innovation / response,
            sample.weight * squared,
            noise / squared,
        );
    }

    /// Whether a sample from `start` on, not yet taken in, lies within the interval that is to hold it with
    /// probability [`LEVEL`] where predictions assume `model`.
    pub fn expects(&self, model: &ChannelModel, sample: &Sample, start: RobotTime) -> bool {
        let corrected = Corrected::new(sample, start, self.posterior, self.shared);
        let Corrected { innovation, response, noise, whole_noise } = corrected;
        let half = match model.posterior {
            Some(posterior) => {
                let of_mean = response * response * mean_variance(posterior);
                let of_ratio = posterior.s() / posterior.r() / sample.weight;
                let scale = (of_ratio + of_mean + noise).sqrt();
                student_t_half_width(posterior.r(), LEVEL) * scale
            }
            None => NORMAL_HALF_WIDTH * (model.variance / sample.weight + whole_noise).sqrt(),
        };
        (innovation + self.posterior.mu() - model.mean).abs() <= half
    }

    /// Its channel, its prior and its posterior.
    pub(super) fn beliefs(&self) -> (Channel, NormalInverseChiSquared, NormalInverseChiSquared) {
        (self.channel, self.prior, self.posterior)
    }

    /// The samples alone, with the correlation of neighbours.
    pub(super) fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// The samples alone, each corrected for what is known of the pose noise that it shares with the one before.
    pub fn sample_statistics(&self) -> SampleStatistics {
        self.statistics.samples
    }

    /// The posterior: prior and samples.
    pub fn posterior(&self) -> NormalInverseChiSquared {
        self.posterior
    }

    /// Back to the prior.
    pub fn reset(&mut self) {
        *self = Self::new(self.channel, self.prior);
    }

    /// How far samples have brought it from its prior, from 0 to 1: the less of what they say of the mean, k - k_0 against
    /// k_0, and of the variance, r - r_0 against r_0, since the prior counts itself in samples in the same way.
    pub fn progress(&self) -> f64 {
        let (prior, posterior) = (self.prior, self.posterior);
        let of_mean = progress(posterior.k() - prior.k(), prior.k());
        let of_variance = progress(posterior.r() - prior.r(), prior.r());
        of_mean.min(of_variance)
    }

    /// As it is shown, where predictions assume `model`.
    pub fn estimate(&self, model: &ChannelModel, used: bool, status: Status) -> ChannelEstimate {
        let posterior = model.posterior;
        let intervals = posterior.map(|posterior| posterior.intervals(LEVEL));
        ChannelEstimate {
            channel: self.channel,
            used,
            mean: model.mean,
            sd: match posterior {
                Some(posterior) => posterior.expected_variance().map(f64::sqrt),
                None => Some(model.variance.sqrt()),
            },
            mean_interval: intervals.map(|[mean, _]| mean),
            predictive_interval: Some(match intervals {
                Some([_, predictive]) => predictive,
                None => normal_interval(model.mean, model.variance.sqrt()),
            }),
            samples: self.statistics.samples.samples,
            effective_samples: self.statistics.effective(),
            ln_evidence: self.ln_evidence,
            status,
        }
    }
}

/// The central 90 % of a normal distribution.
fn normal_interval(mean: f64, sd: f64) -> (f64, f64) {
    (mean - NORMAL_HALF_WIDTH * sd, mean + NORMAL_HALF_WIDTH * sd)
}

/// ln density at `x` of a Student t with the posterior's centre and degrees of freedom and the given scale^2.
fn ln_student(posterior: NormalInverseChiSquared, scale_squared: f64, x: f64) -> f64 {
    let (mu, k, r) = (posterior.mu(), posterior.k(), posterior.r());
    // A posterior whose own predictive has that scale: scale^2 = (s/r)(1 + 1/k).
    NormalInverseChiSquared::new(mu, k, r, scale_squared * r / (1.0 + 1.0 / k))
        .map_or(0.0, |same| same.ln_predictive(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64Mcg;

    fn prior() -> NormalInverseChiSquared {
        NormalInverseChiSquared::new(0.0, 1.0, 4.0, 0.045).expect("valid")
    }

    /// Feeds `windows` consecutive windows of `motion` m with ratio sd `sd` and pose noise `noise`.
    fn learn(windows: u32, motion: f64, sd: f64, noise: f64, seed: u64) -> Stationary {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        let mut belief = Stationary::new(Channel::Forward, prior());
        let weight = 1.2_f64;
        let mut before = noise * normal();
        for i in 0..windows {
            let after = noise * normal();
            let ratio = -0.1 + sd / weight.sqrt() * normal() + (after - before) / motion;
            let sample =
                Sample { ratio, weight, motion, pose_variance: noise * noise, other_variance: 0.0 };
            let [start, end] = [i, i + 1].map(|i| RobotTime::new(f64::from(i) * 0.12));
            belief.update(&sample, start, end);
            before = after;
        }
        belief
    }

    #[test]
    fn without_noise_the_update_is_the_conjugate_one() {
        let mut belief = Stationary::new(Channel::Turn, prior());
        let mut plain = prior();
        for (i, ratio) in [0.1, -0.05, 0.2].into_iter().enumerate() {
            let sample =
                Sample { ratio, weight: 1.2, motion: 0.1, pose_variance: 0.0, other_variance: 0.0 };
            let start = RobotTime::new(i as f64);
            belief.update(&sample, start, start + 1.0);
            plain = plain.update_weighted(ratio, 1.2);
        }
        assert_eq!(belief.posterior(), plain);
    }

    /// Guards against pose noise read as slip. 0.5 mm over 3.9 mm of motion is 18 % per window; the floor's
    /// own error is 3 %.
    #[test]
    fn pose_noise_is_not_read_as_slip() {
        let belief = learn(2000, 0.0039, 0.03, 0.0005, 3);
        let sd = belief.posterior().expected_variance().expect("many samples").sqrt();
        assert!(sd < 0.08, "identified sd {sd}");
        let naive = belief.sample_statistics().variance().expect("many samples").sqrt();
        assert!(naive > 0.15, "the samples alone show {naive}");
        // Neighbouring windows share a pose: their noise cancels in the sum, the mean is known far better.
        assert!((belief.posterior().mu() + 0.1).abs() < 0.005, "{}", belief.posterior().mu());
    }

    #[test]
    fn a_bad_floor_is_seen_through_the_noise() {
        let belief = learn(2000, 0.0039, 0.4, 0.0005, 4);
        let sd = belief.posterior().expected_variance().expect("many samples").sqrt();
        assert!((sd / 0.4 - 1.0).abs() < 0.1, "identified sd {sd}");
    }
}
