//! What is assumed of a robot's errors.

use crate::conjugate::NormalInverseChiSquared;

/// Time in s over which a ratio's variance is stated (error acquisition cycle, thesis table 1).
pub const ERROR_WINDOW: f64 = 0.1;

/// Ratio variance that stands for one that does not exist (r <= 2): any motion at all is too unsure.
pub const UNSURE: f64 = 1e6;

/// What is assumed of one channel's error ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelModel {
    /// Expected ratio.
    pub mean: f64,
    /// Variance of the ratio over 100 ms at constant speed, for a known mean.
    pub variance: f64,
    /// Variance of the mean itself, shared by the whole prediction.
    pub mean_variance: f64,
    /// The posterior that the moments come from; none for a model with known mean and variance.
    pub posterior: Option<NormalInverseChiSquared>,
}

impl ChannelModel {
    /// No error at all.
    pub const PERFECT: Self = Self::known(0.0, 0.0);

    /// A known mean and variance.
    pub const fn known(mean: f64, variance: f64) -> Self {
        Self { mean, variance, mean_variance: 0.0, posterior: None }
    }

    /// The moments of a posterior: E[sigma^2] = s/(r - 2) and E[sigma^2]/k; [`UNSURE`] where r <= 2.
    pub fn from_posterior(posterior: NormalInverseChiSquared) -> Self {
        let variance = posterior.expected_variance().unwrap_or(UNSURE).min(UNSURE);
        Self {
            mean: posterior.mu(),
            variance,
            mean_variance: variance / posterior.k(),
            posterior: Some(posterior),
        }
    }
}

/// What is assumed of a robot's motion: one model per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorModel {
    /// Forward error per metre.
    pub forward: ChannelModel,
    /// Lateral error per metre.
    pub lateral: ChannelModel,
    /// Heading error per radian.
    pub turn: ChannelModel,
    /// Heading error in rad per metre.
    pub drift: ChannelModel,
}

impl ErrorModel {
    /// A robot that moves as commanded.
    pub const PERFECT: Self = Self {
        forward: ChannelModel::PERFECT,
        lateral: ChannelModel::PERFECT,
        turn: ChannelModel::PERFECT,
        drift: ChannelModel::PERFECT,
    };
}
