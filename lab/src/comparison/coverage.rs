//! What is watched while a method drives: whether its intervals hold what comes, and which environment it believes to be
//! in. And the one who knows: the oracle.

use serde::{Deserialize, Serialize};
use umwelt_core::conjugate::SampleStatistics;
use umwelt_core::controller::compensation::Compensation;
use umwelt_core::episode::{Region, Scenario};
use umwelt_core::geometry::Pose;
use umwelt_core::identification::estimate::Channel;
use umwelt_core::identification::{Belief, Samples};
use umwelt_core::plant::{Slip, SlipChannel};
use umwelt_core::prediction::{ChannelModel, ErrorModel};

/// Samples of a channel that are taken in before intervals are asked of it: before, nothing has been identified.
pub const SAMPLES_BEFORE: u64 = 10;

/// How many samples lay within the 90 % interval that was predicted for each before it came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coverage {
    /// Samples within.
    pub within: u32,
    /// Samples in all.
    pub samples: u32,
}

impl Coverage {
    /// Both together.
    pub fn and(self, other: Self) -> Self {
        Self { within: self.within + other.within, samples: self.samples + other.samples }
    }

    /// Share of the samples within; none without samples.
    pub fn share(self) -> Option<f64> {
        (self.samples > 0).then(|| f64::from(self.within) / f64::from(self.samples))
    }
}

/// The controller of the thesis, and beside it a count of how well it knows what comes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Witness {
    coverage: Coverage,
}

impl Witness {
    pub(super) fn coverage(&self) -> Coverage {
        self.coverage
    }
}

impl Compensation for Witness {
    fn witness(&mut self, belief: &Belief, samples: &Samples, start: f64) {
        let model = belief.model();
        let models = [model.forward, model.lateral, model.turn];
        for ((channel, model), sample) in Channel::ALL.iter().zip(models).zip(samples) {
            let known = belief.channel(*channel);
            if let Some(sample) = sample
                && known.samples() >= SAMPLES_BEFORE
            {
                self.coverage.samples += 1;
                self.coverage.within += u32::from(known.expects(&model, sample, start));
            }
        }
    }
}

/// How an environment shows in the samples of a robot: mean and variance of forward and turn, the channels in which the
/// environments of a scenario differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// (mean, variance) of the forward ratio over 100 ms.
    pub forward: (f64, f64),
    /// The same of the turn ratio.
    pub turn: (f64, f64),
}

/// Smallest variance that counts: samples that are all the same say no more than these.
const LEAST_VARIANCE: f64 = 1e-8;

impl Errors {
    /// Of the samples of many episodes, in the order of [`Channel::ALL`].
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

/// Divergence of a normal believed from the one that is there, in nats.
fn divergence((mean, variance): (f64, f64), believed: &ChannelModel) -> f64 {
    let (variance, wide) = (variance.max(LEAST_VARIANCE), believed.variance.max(LEAST_VARIANCE));
    let ratio = variance / wide;
    ((mean - believed.mean).powi(2) / wide + ratio - 1.0 - ratio.ln()) / 2.0
}

/// Knows the floor: its true errors, drift included, where the robot stands. It knows no more of the future than others:
/// neither the slip of the next moment nor the delay of the next packet.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Oracle {
    floor: ErrorModel,
    region: Option<(Region, ErrorModel)>,
}

impl Oracle {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let region = scenario.region.clone().map(|region| {
            let floor = true_errors(&region.slip);
            (region, floor)
        });
        Self { floor: true_errors(&scenario.plant.slip), region }
    }
}

fn true_errors(slip: &Slip) -> ErrorModel {
    let known = |channel: SlipChannel| ChannelModel::known(channel.mean(), channel.sd().powi(2));
    ErrorModel {
        forward: known(slip.forward),
        lateral: known(slip.lateral),
        turn: known(slip.turn),
        drift: known(slip.drift),
    }
}

impl Compensation for Oracle {
    fn model(&self, _: &Belief, pose: Pose) -> ErrorModel {
        match &self.region {
            Some((region, there)) if region.holds(pose) => *there,
            _ => self.floor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::ComparisonSettings;
    use umwelt_core::settings::{Method, Prior};

    /// The bug to fear: an oracle that knows the wrong floor, and so a bound that is none.
    #[test]
    fn the_oracle_knows_the_floor_that_it_stands_on() {
        let settings = ComparisonSettings::scenario("floor-change").unwrap();
        let it = &settings.environments[0];
        let scenario = settings.episode(it, settings.controller);
        let oracle = Oracle::new(&scenario);
        let belief = Belief::new(Method::Statistic, &Prior::default(), false);
        let forward = |x: f64| oracle.model(&belief, Pose::new(x, 0.0, 0.0)).forward;
        for (x, slip) in [(0.0, Slip::HARD), (1.2, Slip::SLIPPERY), (2.0, Slip::HARD)] {
            let known = (slip.forward.mean(), slip.forward.sd().powi(2));
            assert_eq!((forward(x).mean, forward(x).variance), known, "at {x}");
        }
    }
}
