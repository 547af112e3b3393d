//! One channel's belief, by the estimator that makes it.
//!
//! There are two, of an error ratio that has one mean and one variance for as long as the robot drives: [`Stationary`] with
//! one prior of both, the thesis's, and [`Mixed`] with a mixture of priors, from the surest floor to the worst.
//! The place for the next one, a channel whose floor changes at unknown times (change points), is a variant of
//! [`ChannelBelief`]: a file beside `stationary.rs`, and an arm in each method here, which the compiler asks for. Nothing
//! outside of this folder names an estimator.

mod mixed;
mod noise;
mod stationary;
mod statistics;

use self::mixed::Mixed;
use self::stationary::Stationary;
use super::estimate::{Channel, ChannelEstimate};
use super::status::Status;
use super::window::Sample;
use crate::conjugate::{NormalInverseChiSquared, SampleStatistics};
use crate::prediction::ChannelModel;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// What is believed of one channel. Its stored form is that of its estimator: a second one has to have other fields.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "half a kilobyte, copied where the watch looks back")]
pub enum ChannelBelief {
    /// One mean and one variance of the ratio, which do not change.
    Stationary(Stationary),
    /// The same, where little is known of the variance.
    Mixed(Mixed),
}

impl ChannelBelief {
    /// The belief before any sample.
    pub fn new(channel: Channel, prior: NormalInverseChiSquared) -> Self {
        Self::Stationary(Stationary::new(channel, prior))
    }

    /// The belief before any sample where `prior` is one among others: little is known of the variance.
    pub fn of_unknown_spread(channel: Channel, prior: NormalInverseChiSquared) -> Self {
        Self::Mixed(Mixed::new(channel, prior))
    }

    /// As of now little is known of the variance, the mean as well as before.
    pub fn with_unknown_spread(self) -> Self {
        match self {
            Self::Stationary(stationary) => Self::Mixed(Mixed::taken_over(&stationary)),
            Self::Mixed(_) => self,
        }
    }

    /// Takes in the sample of a window from `start` to `end`.
    pub fn update(&mut self, sample: &Sample, start: RobotTime, end: RobotTime) {
        match self {
            Self::Stationary(stationary) => stationary.update(sample, start, end),
            Self::Mixed(mixed) => mixed.update(sample, start, end),
        }
    }

    /// Whether a sample from `start` on, not yet taken in, lies within the interval that is to hold it with
    /// probability [`LEVEL`](super::estimate::LEVEL) where predictions assume `model`.
    pub fn expects(&self, model: &ChannelModel, sample: &Sample, start: RobotTime) -> bool {
        match self {
            Self::Stationary(stationary) => stationary.expects(model, sample, start),
            Self::Mixed(mixed) => mixed.expects(model, sample, start),
        }
    }

    /// Samples taken so far.
    pub fn samples(&self) -> u64 {
        self.sample_statistics().samples
    }

    /// The samples alone, each corrected for what is known of the pose noise that it shares with the one before.
    pub fn sample_statistics(&self) -> SampleStatistics {
        match self {
            Self::Stationary(stationary) => stationary.sample_statistics(),
            Self::Mixed(mixed) => mixed.sample_statistics(),
        }
    }

    /// The posterior: prior and samples. Of a mixture the one belief that is most like it.
    pub fn posterior(&self) -> NormalInverseChiSquared {
        match self {
            Self::Stationary(stationary) => stationary.posterior(),
            Self::Mixed(mixed) => mixed.posterior(),
        }
    }

    /// What predictions assume.
    pub fn model(&self) -> ChannelModel {
        match self {
            Self::Stationary(stationary) => ChannelModel::from_posterior(stationary.posterior()),
            Self::Mixed(mixed) => mixed.model(),
        }
    }

    /// Mean and variance of the samples alone, from two samples on.
    pub fn statistic(&self) -> Option<ChannelModel> {
        let samples = self.sample_statistics();
        Some(ChannelModel::known(samples.mean, samples.variance()?))
    }

    /// Back to the prior.
    pub fn reset(&mut self) {
        match self {
            Self::Stationary(stationary) => stationary.reset(),
            Self::Mixed(mixed) => mixed.reset(),
        }
    }

    /// How far samples have brought it from its prior, from 0 to 1; see [`progress`](super::progress).
    pub fn progress(&self) -> f64 {
        match self {
            Self::Stationary(stationary) => stationary.progress(),
            Self::Mixed(mixed) => mixed.progress(),
        }
    }

    /// As it is shown, where predictions assume `model`.
    pub fn estimate(&self, model: &ChannelModel, used: bool, status: Status) -> ChannelEstimate {
        match self {
            Self::Stationary(stationary) => stationary.estimate(model, used, status),
            Self::Mixed(mixed) => mixed.estimate(model, used, status),
        }
    }
}
