//! How an environment shows in samples, and which of several a robot's belief is nearest to.

use serde::{Deserialize, Serialize};
use umwelt_core::conjugate::SampleStatistics;
use umwelt_core::identification::estimate::Channel;
use umwelt_core::prediction::{ChannelModel, ErrorModel};

/// How an environment shows in the samples of a robot: mean and variance of forward and turn, the channels in which the
/// environments of a scenario differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentSignature {
    /// (mean, variance) of the forward ratio over 100 ms.
    pub forward: (f64, f64),
    /// The same of the turn ratio.
    pub turn: (f64, f64),
}

/// Smallest variance that counts: samples that are all the same say no more than these.
const LEAST_VARIANCE: f64 = 1e-8;

impl EnvironmentSignature {
    /// That of the samples of many episodes, in the order of [`Channel::ALL`].
    pub(super) fn of(samples: &[[SampleStatistics; 4]]) -> Self {
        let pooled = |channel: Channel| {
            let of_channel = || samples.iter().map(move |it| it[channel as usize]);
            let weight: f64 = of_channel().map(|it| it.weight).sum();
            let count: u64 = of_channel().map(|it| it.samples).sum();
            let mean = of_channel().map(|it| it.weight * it.mean).sum::<f64>() / weight.max(1e-9);
            let squares: f64 =
                of_channel().map(|it| it.squares + it.weight * (it.mean - mean).powi(2)).sum();
            (mean, squares / (count as f64 - 1.0).max(1.0))
        };
        Self { forward: pooled(Channel::Forward), turn: pooled(Channel::Turn) }
    }

    /// The one of `known` whose errors surprise a robot that reckons with `model` least: of the smallest Kullback-Leibler
    /// divergence, channels added.
    pub(super) fn nearest(known: &[Self], model: &ErrorModel) -> usize {
        let surprise =
            |it: &Self| divergence(it.forward, &model.forward) + divergence(it.turn, &model.turn);
        let surprises = known.iter().map(surprise).enumerate();
        surprises.min_by(|one, other| one.1.total_cmp(&other.1)).map_or(0, |(index, _)| index)
    }
}

/// Divergence of the normal of a belief from the one that is there, in nats.
fn divergence((mean, variance): (f64, f64), believed: &ChannelModel) -> f64 {
    let (variance, wide) = (variance.max(LEAST_VARIANCE), believed.variance.max(LEAST_VARIANCE));
    let ratio = variance / wide;
    ((mean - believed.mean).powi(2) / wide + ratio - 1.0 - ratio.ln()) / 2.0
}
