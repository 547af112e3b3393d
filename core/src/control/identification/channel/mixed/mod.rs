//! The estimator of a stationary channel of whose spread little is known: a mixture of beliefs, from the surest floor to
//! the worst.
//!
//! One inverse chi-squared has one scale, and its degrees of freedom hold the spread to it: from four of them at 15 %, a
//! floor of 0.6 % still shows 3.2 % after 90 samples without any noise. Of several with scales from 0.3 % to 30 %, samples
//! name the one that is right within a few windows. The prior that was chosen for the robot is one of them, and has half of
//! the probability: what was known comes true at once, and what was wrong is given up as soon as samples say so.

use super::super::estimate::{Channel, ChannelEstimate, LEVEL};
use super::super::status::{Status, progress};
use super::super::window::Sample;
use super::noise::{Corrected, SharedNoise, mean_variance};
use super::stationary::Stationary;
use super::statistics::Statistics;
use crate::conjugate::{
    COMPONENTS, Mixture, NormalInverseChiSquared, SampleStatistics, StudentT, Weighted, mass_below,
};
use crate::prediction::ChannelModel;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// Standard deviations of the broad beliefs, in units of [`MOST`]: evenly from a hundredth up, a factor of 2.15 apart. Where a
/// sample is nearly all noise, it is their weights alone that learn the spread: a factor of 4.6 leaves it 40 % off.
const SPREADS: [f64; COMPONENTS - 1] = [
    0.01,
    0.021_544_346_900_318_84,
    0.046_415_888_336_127_79,
    0.1,
    0.215_443_469_003_188_4,
    0.464_158_883_361_277_9,
    1.0,
];

/// Standard deviation of the ratio over 100 ms of the broadest belief, forward and turning: that of ice under changing
/// commands. To the side, and per metre of heading, it is expected to be three times smaller, as the default prior says.
const MOST: f64 = 0.3;

/// Degrees of freedom of the broad beliefs: a spread is known to a factor of 1.6, neighbours overlap, E\[sigma^2\] exists.
const DEGREES: f64 = 3.0;

/// Standard deviation of the mean in the broad beliefs, in units of [`MOST`]: that of the default prior. However small the
/// spread, wheels may be off by as much.
const MEAN: f64 = 0.5;

/// Probability of the prior that was chosen; the broad beliefs share the rest.
const CHOSEN: f64 = 0.5;

/// Below this probability a belief is dropped: as all learn from the same samples, what it says of the variance is by then
/// not a hundred times what the others say.
const DROPPED: f64 = 1e-4;

/// One belief, its probability, and what is known under it of the noise that neighbouring windows share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Component {
    weight: f64,
    posterior: NormalInverseChiSquared,
    shared: Option<SharedNoise>,
}

/// What is believed of a channel whose ratio has one mean and one variance, of which little is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mixed {
    channel: Channel,
    prior: NormalInverseChiSquared,
    components: [Component; COMPONENTS],
    statistics: Statistics,
    ln_evidence: f64,
}

/// What each component is before any sample, the chosen prior first.
fn priors(channel: Channel, chosen: NormalInverseChiSquared) -> [Weighted; COMPONENTS] {
    let most = match channel {
        Channel::Forward | Channel::Turn => MOST,
        Channel::Lateral | Channel::Drift => MOST / 3.0,
    };
    let weight = (1.0 - CHOSEN) / SPREADS.len() as f64;
    let mut all = [Weighted { weight: CHOSEN, belief: chosen }; COMPONENTS];
    for (broad, spread) in all[1..].iter_mut().zip(SPREADS) {
        let (k, s) = ((spread / MEAN).powi(2).min(1.0), DEGREES * (spread * most).powi(2));
        // Constants in their domain; the chosen prior twice would be as good.
        let belief = NormalInverseChiSquared::new(0.0, k, DEGREES, s).unwrap_or(chosen);
        *broad = Weighted { weight, belief };
    }
    all
}

impl Mixed {
    /// The belief before any sample, where `prior` was chosen.
    pub fn new(channel: Channel, prior: NormalInverseChiSquared) -> Self {
        let components = priors(channel, prior).map(|Weighted { weight, belief }| Component {
            weight,
            posterior: belief,
            shared: None,
        });
        Self { channel, prior, components, statistics: Statistics::default(), ln_evidence: 0.0 }
    }

    /// What was believed as one belief, of whose spread much was said before: the mean is known as well as it was, in units
    /// of the spread, and of the spread nothing. Samples go on to be counted.
    pub fn taken_over(stationary: &Stationary) -> Self {
        let (channel, prior, posterior) = stationary.beliefs();
        let mut taken_over = Self::new(channel, prior);
        let mean_variance = mean_variance(posterior);
        for component in &mut taken_over.components {
            let (r, s) = (component.posterior.r(), component.posterior.s());
            let k = (s / r / mean_variance).clamp(component.posterior.k(), posterior.k());
            component.posterior = NormalInverseChiSquared::new(posterior.mu(), k, r, s)
                .unwrap_or(component.posterior);
        }
        taken_over.statistics = stationary.statistics();
        taken_over
    }

    /// Takes in the sample of a window from `start` to `end`: under each belief as [`Stationary::update`] does, and each
    /// by the density that the sample had under it.
    pub fn update(&mut self, sample: &Sample, start: RobotTime, end: RobotTime) {
        let expected = self.mixture().moments().mu;
        let (mut ratio, mut scale_squared) = (0.0, 0.0);
        let mut ln_densities = [f64::NEG_INFINITY; COMPONENTS];
        for (component, ln_density) in self.components.iter_mut().zip(&mut ln_densities) {
            let Component { weight, posterior, shared } = *component;
            if weight == 0.0 {
                continue;
            }
            let corrected = Corrected::new(sample, start, posterior, shared);
            let Corrected { innovation, response, noise, .. } = corrected;
            ratio += weight * (posterior.mu() + innovation);
            scale_squared += weight * corrected.scale_squared(sample, posterior);
            let squared = response * response;
            let (next, ln_of_mean) = posterior.update_noisy_with_evidence(
                posterior.mu() + innovation / response,
                sample.weight * squared,
                noise / squared,
            );
            *ln_density = ln_of_mean - response.abs().ln();
            component.posterior = next;
            component.shared = Some(corrected.shared(sample, end, posterior));
        }
        self.statistics.update(ratio, sample.weight, (ratio - expected) / scale_squared.sqrt());
        self.weigh(&ln_densities);
    }

    /// Weighs the components anew by the densities that a sample had under each.
    fn weigh(&mut self, ln_densities: &[f64; COMPONENTS]) {
        let highest = ln_densities.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: [f64; COMPONENTS] = std::array::from_fn(|index| {
            self.components[index].weight * (ln_densities[index] - highest).exp()
        });
        let total = weights.iter().sum::<f64>();
        if !(total.is_finite() && total > 0.0) {
            return;
        }
        self.ln_evidence += highest + total.ln();
        let kept = weights.map(|weight| if weight < DROPPED * total { 0.0 } else { weight });
        let total = kept.iter().sum::<f64>();
        for (component, weight) in self.components.iter_mut().zip(kept) {
            component.weight = weight / total;
        }
    }

    /// The beliefs and their probabilities.
    fn mixture(&self) -> Mixture {
        Mixture(self.components.map(|it| Weighted { weight: it.weight, belief: it.posterior }))
    }

    /// What predictions assume.
    pub fn model(&self) -> ChannelModel {
        ChannelModel::from_mixture(&self.mixture())
    }

    /// Whether a sample from `start` on, not yet taken in, lies within the interval that is to hold it with
    /// probability [`LEVEL`] where predictions assume `model`.
    pub fn expects(&self, model: &ChannelModel, sample: &Sample, start: RobotTime) -> bool {
        let clamped = model.mean - self.mixture().moments().mu;
        let parts = self.components.map(|Component { weight, posterior, shared }| {
            let corrected = Corrected::new(sample, start, posterior, shared);
            let scale_squared = corrected.scale_squared(sample, posterior);
            // Of a sum of a variance that is known and one that is not, the degrees of freedom are so many more.
            let unknown = 1.0 - corrected.noise / scale_squared;
            let degrees = posterior.r() / (unknown * unknown);
            let centre = clamped - corrected.innovation;
            StudentT { weight, centre, scale: scale_squared.sqrt(), degrees }
        });
        let (below, _) = mass_below(&parts, 0.0);
        (below - 0.5).abs() <= LEVEL / 2.0
    }

    /// The samples alone, each corrected for what is known of the pose noise that it shares with the one before.
    pub fn sample_statistics(&self) -> SampleStatistics {
        self.statistics.samples
    }

    /// The one belief that is most like the mixture.
    pub fn posterior(&self) -> NormalInverseChiSquared {
        self.mixture().merged()
    }

    /// Back to the prior.
    pub fn reset(&mut self) {
        *self = Self::new(self.channel, self.prior);
    }

    /// How far samples have brought it from its prior, from 0 to 1: as [`Stationary::progress`], of the belief that is
    /// most probable.
    pub fn progress(&self) -> f64 {
        let priors = priors(self.channel, self.prior);
        let both = priors.iter().zip(&self.components);
        let heaviest = both.max_by(|(_, one), (_, other)| one.weight.total_cmp(&other.weight));
        heaviest.map_or(0.0, |(prior, component)| {
            let (prior, posterior) = (prior.belief, component.posterior);
            let of_mean = progress(posterior.k() - prior.k(), prior.k());
            let of_variance = progress(posterior.r() - prior.r(), prior.r());
            of_mean.min(of_variance)
        })
    }

    /// As it is shown, where predictions assume `model`.
    pub fn estimate(&self, model: &ChannelModel, used: bool, status: Status) -> ChannelEstimate {
        let mixture = self.mixture();
        let [mean_interval, predictive_interval] = mixture.intervals(LEVEL);
        ChannelEstimate {
            channel: self.channel,
            used,
            mean: model.mean,
            sd: mixture.moments().variance.map(f64::sqrt),
            mean_interval: Some(mean_interval),
            predictive_interval: Some(predictive_interval),
            samples: self.statistics.samples.samples,
            effective_samples: self.statistics.effective(),
            ln_evidence: self.ln_evidence,
            status,
        }
    }
}

#[cfg(test)]
mod tests;
