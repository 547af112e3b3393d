//! What is assumed of a robot's errors.

use crate::conjugate::{Mixture, NormalInverseChiSquared};

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

    /// The moments of a mixture of posteriors; [`UNSURE`] where one of them has no variance.
    pub fn from_mixture(mixture: &Mixture) -> Self {
        let moments = mixture.moments();
        let posterior = moments.merged().unwrap_or_else(|| mixture.merged());
        let variance = moments.variance.unwrap_or(UNSURE).min(UNSURE);
        let mean_variance = moments.mean_variance.unwrap_or(variance / posterior.k());
        Self { mean: moments.mu, variance, mean_variance, posterior: Some(posterior) }
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

    /// With means within what floors do: 1 + mean in \[0.3, 1.5\], half a metre or radian per metre.
    pub fn clamped(self) -> Self {
        let within = |model: ChannelModel, low: f64, high: f64| ChannelModel {
            mean: model.mean.clamp(low, high),
            ..model
        };
        Self {
            forward: within(self.forward, -0.7, 0.5),
            lateral: within(self.lateral, -0.5, 0.5),
            turn: within(self.turn, -0.7, 0.5),
            drift: within(self.drift, -0.5, 0.5),
        }
    }

    /// The model for the commands of a drive of this `scale`, known to `sd`, where it is one for commands as described: the
    /// scale is what the means were, and slip is relative to what such a drive makes of its commands.
    pub fn relative_to(self, scale: &Scale, sd: &Scale) -> Self {
        let factor = (1.0 + scale.forward).recip();
        let left = |model: ChannelModel, factor: f64, sd: f64| ChannelModel {
            mean: 0.0,
            variance: model.variance * factor * factor,
            mean_variance: sd * sd * factor * factor,
            posterior: None,
        };
        Self {
            forward: left(self.forward, factor, sd.forward),
            lateral: self.lateral.times(factor),
            turn: left(self.turn, (1.0 + scale.turn).recip(), sd.turn),
            drift: left(self.drift, factor, sd.drift),
        }
    }
}

impl ChannelModel {
    /// The model of `factor` times the ratio.
    fn times(self, factor: f64) -> Self {
        let square = factor * factor;
        let posterior = self.posterior.and_then(|it| {
            NormalInverseChiSquared::new(it.mu() * factor, it.k(), it.r(), it.s() * square).ok()
        });
        Self {
            mean: self.mean * factor,
            variance: self.variance * square,
            mean_variance: self.mean_variance * square,
            posterior,
        }
    }
}

/// How a drive differs from its description: what it makes of commands as described.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// Forward motion per forward motion commanded, less one.
    pub forward: f64,
    /// Turn per turn commanded, less one.
    pub turn: f64,
    /// Turn in rad per metre commanded.
    pub drift: f64,
}
