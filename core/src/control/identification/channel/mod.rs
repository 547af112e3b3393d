//! One channel's belief, by the estimator that makes it.
//!
//! There is one estimator, [`Stationary`]: the error ratio has one mean and one variance for as long as the robot drives.
//! The place for the next one, a channel whose floor changes at unknown times (change points), is a variant of
//! [`ChannelBelief`]: a file beside `stationary.rs`, and an arm in each method here, which the compiler asks for. Nothing
//! outside of this folder names an estimator.

mod stationary;

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
pub enum ChannelBelief {
    /// One mean and one variance of the ratio, which do not change.
    Stationary(Stationary),
}

impl ChannelBelief {
    /// The belief before any sample.
    pub fn new(channel: Channel, prior: NormalInverseChiSquared) -> Self {
        Self::Stationary(Stationary::new(channel, prior))
    }

    /// Takes in the sample of a window from `start` to `end`.
    pub fn update(&mut self, sample: &Sample, start: RobotTime, end: RobotTime) {
        match self {
            Self::Stationary(stationary) => stationary.update(sample, start, end),
        }
    }

    /// Whether a sample from `start` on, not yet taken in, lies within the interval that is to hold it with
    /// probability [`LEVEL`](super::estimate::LEVEL) where predictions assume `model`.
    pub fn expects(&self, model: &ChannelModel, sample: &Sample, start: RobotTime) -> bool {
        match self {
            Self::Stationary(stationary) => stationary.expects(model, sample, start),
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
        }
    }

    /// The posterior: prior and samples.
    pub fn posterior(&self) -> NormalInverseChiSquared {
        match self {
            Self::Stationary(stationary) => stationary.posterior(),
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
        }
    }

    /// How far samples have brought it from its prior, from 0 to 1; see [`progress`](super::progress).
    pub fn progress(&self) -> f64 {
        match self {
            Self::Stationary(stationary) => stationary.progress(),
        }
    }

    /// As it is shown, where predictions assume `model`.
    pub fn estimate(&self, model: &ChannelModel, used: bool, status: Status) -> ChannelEstimate {
        match self {
            Self::Stationary(stationary) => stationary.estimate(model, used, status),
        }
    }
}
