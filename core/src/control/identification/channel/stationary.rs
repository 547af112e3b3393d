//! The estimator of a stationary channel: prior, posterior, sample statistics, and the noise shared by neighbouring windows.

use super::super::estimate::{Channel, ChannelEstimate, LEVEL, NORMAL_HALF_WIDTH};
use super::super::status::{Status, progress};
use super::super::window::Sample;
use crate::conjugate::{NormalInverseChiSquared, SampleStatistics, student_t_half_width};
use crate::prediction::ChannelModel;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// What is known of the pose noise at the end of the last window: it enters the next one with the other sign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct SharedNoise {
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
struct Corrected {
    /// Sample minus what is expected, in units of the ratio.
    innovation: f64,
    /// How much the innovation grows with the mean ratio; 1 where pose and mean have nothing to do with each other.
    response: f64,
    /// What the camera adds to the variance of the innovation, the mean being known.
    noise: f64,
    /// The same where nothing is known of the mean but by the samples.
    whole_noise: f64,
}

/// Weighted mean and spread of the samples alone (Welford), and the correlation of neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Statistics {
    samples: SampleStatistics,
    last: f64,
    neighbours: f64,
    power: f64,
}

impl Statistics {
    fn update(&mut self, x: f64, weight: f64, standardised: f64) {
        self.samples.add(x, weight);
        self.neighbours += standardised * self.last;
        self.power += standardised * standardised;
        self.last = standardised;
    }

    /// n (1 - rho)/(1 + rho) for a lag-1 correlation rho in [0, 0.95].
    fn effective(&self) -> f64 {
        let rho = if self.power > 0.0 { self.neighbours / self.power } else { 0.0 };
        let rho = rho.clamp(0.0, 0.95);
        self.samples.samples as f64 * (1.0 - rho) / (1.0 + rho)
    }
}

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
        let Sample { motion, pose_variance, weight, .. } = *sample;
        let Corrected { innovation, response, noise, .. } = self.corrected(sample, start);

        let posterior = self.posterior;
        let mean_variance = mean_variance(posterior);
        let scale_squared =
            posterior.s() / posterior.r() / weight + response * response * mean_variance + noise;
        self.ln_evidence += ln_student(posterior, scale_squared, posterior.mu() + innovation);
        let ratio = posterior.mu() + innovation;
        self.statistics.update(ratio, weight, innovation / scale_squared.sqrt());

        let gain = pose_variance / motion / scale_squared;
        self.shared = Some(SharedNoise {
            taken: end,
            mean: gain * innovation,
            variance: pose_variance - gain * pose_variance / motion,
            covariance: -gain * response * mean_variance,
        });
        let squared = response * response;
        self.posterior = posterior.update_noisy(
            posterior.mu() + innovation / response,
            weight * squared,
            noise / squared,
        );
    }

    /// What a sample from `start` on says of the mean ratio.
    fn corrected(&self, sample: &Sample, start: RobotTime) -> Corrected {
        let Sample { motion, pose_variance, other_variance, .. } = *sample;
        let unknown =
            SharedNoise { taken: start, mean: 0.0, variance: pose_variance, covariance: 0.0 };
        let shared =
            self.shared.filter(|shared| (shared.taken - start).abs() < 1e-6).unwrap_or(unknown);
        // Both together are at least as sure as a correlation of one would make them.
        let slope = shared.covariance / mean_variance(self.posterior);
        let explained = (slope * shared.covariance).min(MOST_EXPLAINED * shared.variance);
        let with = |variance: f64| (variance + pose_variance) / (motion * motion) + other_variance;
        Corrected {
            innovation: sample.ratio + shared.mean / motion - self.posterior.mu(),
            response: 1.0 - slope / motion,
            noise: with(shared.variance - explained),
            whole_noise: with(shared.variance),
        }
    }

    /// Whether a sample from `start` on, not yet taken in, lies within the interval that is to hold it with
    /// probability [`LEVEL`] where predictions assume `model`.
    pub fn expects(&self, model: &ChannelModel, sample: &Sample, start: RobotTime) -> bool {
        let corrected = self.corrected(sample, start);
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

/// Most of the variance of a pose's noise that the mean ratio may explain: the filter's steps are not exact, a variance
/// stays positive.
const MOST_EXPLAINED: f64 = 0.99;

/// The central 90 % of a normal distribution.
fn normal_interval(mean: f64, sd: f64) -> (f64, f64) {
    (mean - NORMAL_HALF_WIDTH * sd, mean + NORMAL_HALF_WIDTH * sd)
}

/// Variance of the mean ratio, sigma^2 being as expected: (s/r)/k.
fn mean_variance(posterior: NormalInverseChiSquared) -> f64 {
    posterior.s() / posterior.r() / posterior.k()
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

    #[test]
    fn correlated_samples_are_worth_fewer() {
        let mut statistics = Statistics::default();
        for i in 0..1000 {
            let x = f64::from(i / 20 % 2) * 2.0 - 1.0;
            statistics.update(x, 1.0, x);
        }
        assert!(statistics.effective() < 100.0);
        let mut alternating = Statistics::default();
        for i in 0..1000 {
            let x = f64::from(i % 2) * 2.0 - 1.0;
            alternating.update(x, 1.0, x);
        }
        assert!((alternating.effective() - 1000.0).abs() < 1e-9);
    }
}
