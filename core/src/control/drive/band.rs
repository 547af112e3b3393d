//! The dead band of the motors: up to which commanded speed the wheels do not turn.
//!
//! A wheel that was commanded steadily and moved has a dead band below its speed, one that stood above. Both may be wrong: a
//! wheel may be blocked, and a robot may be pushed. So each changes the odds, and decides nothing.

use super::estimate::Quantity;
use super::grid::three_digits;
use crate::identification::estimate::LEVEL;
use serde::{Deserialize, Serialize};

/// Dead bands below this in rad/s are none to speak of: no smallest speed lies there.
const NONE_BELOW: f64 = 0.2;

/// Width of the other cells in rad/s.
const CELL: f64 = 0.1;

/// How many cells: to 4 rad/s, a quarter above the widest that was seen.
const CELLS: usize = 39;

/// Part of the robots that have none to speak of.
const HAS_NONE: f64 = 0.5;

/// Median in rad/s of those who have one, and standard deviation of its natural logarithm: motors with a dead band stand
/// below 0.5 to 1.5 rad/s (field facts), and this has 95 % within 0.3 to 2.3 rad/s.
const MEDIAN: f64 = 0.85;
const SPREAD: f64 = 0.5;

/// Probability that a wheel stands though its command is above its dead band: it is blocked, or not followed.
const BLOCKED: f64 = 0.02;

/// Probability that a wheel moves though its command is below: somebody pushes, or the poses say so.
const PUSHED: f64 = 0.01;

/// Part of the prior in what is believed after each judgement: bands change with battery and temperature, and judgements of
/// one motion err together.
const ANEW: f64 = 0.002;

/// Points of a cell at which a judgement is weighed.
const POINTS: usize = 8;

/// Probability with which wheels turn at [`Turning::surely`].
const SURELY: f64 = 0.98;

/// Whether a wheel turned at a steady command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// Whether it was seen to move.
    pub moved: bool,
    /// Slowest and fastest speed in rad/s commanded meanwhile, without their sign.
    pub slowest: f64,
    /// See `slowest`.
    pub fastest: f64,
}

/// At which speeds wheels turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
    /// As likely as not they turn at this speed in rad/s.
    pub likely: f64,
    /// At this one 49 times of 50.
    pub surely: f64,
}

/// What is believed of the dead band.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeadBand {
    /// Of each cell.
    weights: Vec<f64>,
    /// How often a wheel was seen to turn or to stand.
    judged: u64,
}

impl Default for DeadBand {
    /// Before any judgement: none to speak of, or about log-normal.
    fn default() -> Self {
        let mut prior = Self { weights: vec![0.0; CELLS], judged: 0 };
        let density = |band: f64| {
            let z = (band / MEDIAN).ln() / SPREAD;
            (-0.5 * z * z).exp() / band
        };
        for (index, weight) in prior.weights.iter_mut().enumerate().skip(1) {
            *weight = points(index).map(density).sum();
        }
        let sum: f64 = prior.weights.iter().sum();
        for weight in &mut prior.weights {
            *weight *= (1.0 - HAS_NONE) / sum;
        }
        prior.weights[0] = HAS_NONE;
        prior.normalise();
        prior
    }
}

impl DeadBand {
    /// Takes in whether a wheel turned.
    pub fn update(&mut self, judgement: Judgement) {
        let prior = Self::default();
        for (index, weight) in self.weights.iter_mut().enumerate() {
            let likely: f64 = points(index).map(|band| judgement.likelihood(band)).sum();
            *weight *= likely / POINTS as f64;
        }
        self.normalise();
        for (weight, prior) in self.weights.iter_mut().zip(prior.weights) {
            *weight += ANEW * (prior - *weight);
        }
        self.normalise();
        self.judged += 1;
    }

    /// Makes the weights sum to one, each to three digits.
    fn normalise(&mut self) {
        let sum: f64 = self.weights.iter().sum();
        for weight in &mut self.weights {
            *weight = three_digits(*weight / sum);
        }
    }

    /// How often a wheel was seen to turn or to stand.
    pub fn judged(&self) -> u64 {
        self.judged
    }

    /// The dead band in rad/s below which it is with probability `part`.
    pub fn quantile(&self, part: f64) -> f64 {
        let sum: f64 = self.weights.iter().sum();
        let mut left = part * sum;
        for (index, weight) in self.weights.iter().enumerate() {
            let (low, high) = cell(index);
            if left <= *weight {
                return low + (high - low) * left / weight;
            }
            left -= weight;
        }
        cell(CELLS - 1).1
    }

    /// At which speeds the wheels turn.
    pub fn turning(&self) -> Turning {
        Turning { likely: self.quantile(0.5), surely: self.quantile(SURELY) }
    }

    /// The dead band in rad/s. Where it may be none to speak of its interval begins at 0.
    pub fn quantity(&self) -> Quantity {
        let cells = self.weights.iter().enumerate();
        let it = Quantity::of(cells.map(|(index, weight)| {
            let (low, high) = cell(index);
            (low, high, *weight)
        }));
        let (low, _) = it.interval;
        if low < NONE_BELOW { Quantity { interval: (0.0, self.quantile(LEVEL)), ..it } } else { it }
    }
}

impl Judgement {
    /// How likely it is where the dead band is `band` rad/s. Between the slowest and the fastest command a wheel turns for
    /// a part of the time.
    fn likelihood(&self, band: f64) -> f64 {
        let range = self.fastest - self.slowest;
        let turns = if range > 0.0 {
            ((self.fastest - band) / range).clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(self.fastest > band))
        };
        let moves = turns * (1.0 - BLOCKED) + (1.0 - turns) * PUSHED;
        if self.moved { moves } else { 1.0 - moves }
    }
}

/// From where to where a cell goes, in rad/s.
fn cell(index: usize) -> (f64, f64) {
    let from = |index: usize| NONE_BELOW + CELL * (index as f64 - 1.0);
    (if index == 0 { 0.0 } else { from(index) }, from(index + 1))
}

/// Points of a cell, evenly spread.
fn points(index: usize) -> impl Iterator<Item = f64> {
    let (low, high) = cell(index);
    (0..POINTS).map(move |point| low + (high - low) * (point as f64 + 0.5) / POINTS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(judgements: &[(bool, f64)]) -> DeadBand {
        let mut band = DeadBand::default();
        for &(moved, speed) in judgements {
            band.update(Judgement { moved, slowest: speed, fastest: speed });
        }
        band
    }

    /// Guards against: a posterior that is not prior times likelihood, the mistakes of judgements in it.
    #[test]
    fn it_is_bayes_rule() {
        let prior = DeadBand::default();
        let (speed, below) = (1.2, 0.9);
        let likelihood = |band: f64| {
            let stood = if band > below { 1.0 - PUSHED } else { BLOCKED };
            stood * if band < speed { 1.0 - BLOCKED } else { PUSHED }
        };
        let mass: f64 = (0..CELLS)
            .map(|index| {
                let (low, high) = cell(index);
                prior.weights[index] * likelihood(f64::midpoint(low, high))
            })
            .sum();
        let within = (0..CELLS).filter(|&index| {
            let (low, high) = cell(index);
            low > below - 1e-9 && high < speed + 1e-9
        });
        let within: f64 = within.map(|index| prior.weights[index] * 0.99 * 0.98 / mass).sum();
        let posterior = judged(&[(false, below), (true, speed)]);
        let held = (0..1000).filter(|i| {
            let band = posterior.quantile((f64::from(*i) + 0.5) / 1000.0);
            (below..speed).contains(&band)
        });
        // Some of the prior comes back, twice.
        assert!((held.count() as f64 / 1000.0 - within).abs() < 0.006);
        assert!(within > 0.8 && posterior.judged() == 2);
    }

    /// Guards against: wheels that turn at the smallest speeds are said to have a dead band, or those that stand none.
    #[test]
    fn what_turns_slowly_has_none_to_speak_of() {
        let turns = judged(&[(true, 0.3)]).quantity();
        assert!(turns.interval.0 == 0.0 && turns.interval.1 < 0.25 && turns.mean < 0.15);
        let stands = judged(&[(false, 0.3), (false, 0.5), (true, 0.65)]).quantity();
        assert!(stands.interval.0 > 0.45 && stands.interval.1 < 0.7, "{stands:?}");
    }

    /// Guards against: a robot that was blocked once, or pushed, is believed to be so for ever.
    #[test]
    fn one_mistake_is_outvoted() {
        let blocked = judged(&[(true, 0.4), (false, 0.9), (true, 0.4), (true, 0.4)]);
        assert!(blocked.quantity().interval.1 < 0.5, "{:?}", blocked.quantity());
        let lasting: Vec<_> = (0..50).map(|_| (false, 2.0)).collect();
        let mut band = judged(&lasting);
        assert!(band.quantile(0.1) > 1.9);
        for _ in 0..6 {
            band.update(Judgement { moved: true, slowest: 0.4, fastest: 0.4 });
        }
        assert!(band.quantile(0.9) < 0.5, "{:?}", band.quantity());
    }

    /// Guards against: a wheel blocked at a speed at which every motor turns says something of dead bands.
    #[test]
    fn what_no_dead_band_explains_says_nothing() {
        let (before, after) = (DeadBand::default().quantity(), judged(&[(false, 4.3)]).quantity());
        assert!((before.mean - after.mean).abs() < 1e-3 && (before.sd - after.sd).abs() < 1e-3);
    }
}
