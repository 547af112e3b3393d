//! Hypotheses of dead time and lag: a grid over their sum and the part of it that is lag, each with its weight.

use super::axis::{Axis, interpolated};
use super::estimate::{Cell, Quantity, moments};
use serde::{Deserialize, Serialize};

/// Median of the prior of the sum of dead time and lag in s; 95 % lie within 0.044 to 0.38 s.
///
/// Field facts: robots of the 0.1 m class need 60 to 200 ms; ten recorded iRobot Creates show 200 to 280 ms, with the
/// offset of their logs in it.
pub const PRIOR_MEDIAN: f64 = 0.13;

/// Standard deviation of the natural logarithm of that sum before any sample.
pub const PRIOR_SPREAD: f64 = 0.55;

/// Longest sum of dead time and lag in s that is looked for.
pub const LONGEST: f64 = 0.6;

/// A weight below this is none: the hypothesis is given up.
const GIVEN_UP: f64 = 1e-8;

/// The sum in s, to 0.3 ms at the finest.
const SUMS: Axis = Axis::new(41, LONGEST, 3e-4);

/// The part of it that is lag.
const SHARES: Axis = Axis::new(13, 1.0, 0.01);

/// The sum in s is at least this to its prior.
const LEAST: f64 = 0.004;

/// Of so many robots the prior knows nothing: one that follows at once is unlikely, not impossible.
const ANY: f64 = 0.01;

/// Standard deviation of the sum in s where it is about known.
const ABOUT: f64 = 0.02;

/// The logarithm of a weight that is given up, where it is needed.
const LN_GIVEN_UP: f64 = -60.0;

/// One hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    index: usize,
    /// Dead time and lag in s.
    pub sum: f64,
    /// The part of it that is lag.
    pub share: f64,
    /// How likely it is.
    pub weight: f64,
}

/// The hypotheses and their weights, which sum to one; a weight of 0 is a hypothesis given up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    sums: Axis,
    shares: Axis,
    /// By sum, and by share within.
    weights: Vec<f64>,
}

impl Grid {
    /// Before any sample: the sum is about log-normal, every share as likely.
    pub fn prior() -> Self {
        Self::over(SUMS)
    }

    /// The same where the sum in s is about known.
    pub fn near(sum: f64) -> Self {
        let mut near = Self::over(SUMS.around(sum, ABOUT / 5.0));
        for index in 0..near.weights.len() {
            let off = (near.hypothesis(index).sum - sum) / ABOUT;
            near.weights[index] *= (-0.5 * off * off).exp();
        }
        near.normalise();
        near
    }

    fn over(sums: Axis) -> Self {
        let weights = vec![0.0; SUMS.len() * SHARES.len()];
        let mut prior = Self { sums, shares: SHARES, weights };
        for index in 0..prior.weights.len() {
            let sum = prior.hypothesis(index).sum.max(LEAST);
            let z = (sum / PRIOR_MEDIAN).ln() / PRIOR_SPREAD;
            prior.weights[index] = (-0.5 * z * z).exp() / sum;
        }
        prior.normalise();
        let any = ANY / prior.weights.len() as f64;
        prior.weights.iter_mut().for_each(|weight| *weight += any * (1.0 - *weight));
        prior.normalise();
        prior
    }

    /// Where both are known.
    pub fn known(dead_time: f64, lag: f64) -> Self {
        let sum = dead_time + lag;
        let share = if sum > 0.0 { lag / sum } else { 0.0 };
        Self { sums: Axis::known(sum), shares: Axis::known(share), weights: vec![1.0] }
    }

    fn hypothesis(&self, index: usize) -> Hypothesis {
        let shares = self.shares.len();
        Hypothesis {
            index,
            sum: self.sums.at(index / shares),
            share: self.shares.at(index % shares),
            weight: self.weights[index],
        }
    }

    /// Those that were not given up.
    pub fn alive(&self) -> impl Iterator<Item = Hypothesis> + '_ {
        (0..self.weights.len()).map(|index| self.hypothesis(index)).filter(|it| it.weight > 0.0)
    }

    /// Gives one of them another weight.
    pub fn set(&mut self, hypothesis: &Hypothesis, weight: f64) {
        self.weights[hypothesis.index] = weight;
    }

    /// The weight of one of them.
    pub fn weight(&self, hypothesis: &Hypothesis) -> f64 {
        self.weights[hypothesis.index]
    }

    /// Makes the weights sum to one, each to three digits: that is what they are good for, and short to keep.
    pub fn normalise(&mut self) {
        let sum: f64 = self.weights.iter().sum();
        for weight in &mut self.weights {
            let part = *weight / sum;
            *weight = if part < GIVEN_UP { 0.0 } else { three_digits(part) };
        }
    }

    /// The same weights over points that fit `known` better than its own; none where those fit.
    pub fn fitted(&self, known: &Self) -> Option<Self> {
        let sums = known.sums.fitted(&known.of_sums()).unwrap_or(known.sums);
        let shares = known.shares.fitted(&known.of_shares()).unwrap_or(known.shares);
        if (sums, shares) == (known.sums, known.shares) {
            return None;
        }
        let (before, mut fitted) = (self, Self { sums, shares, weights: Vec::new() });
        let place = |share: usize| before.shares.place(shares.at(share));
        for sum in 0..sums.len() {
            let along = before.sums.place(sums.at(sum));
            let of_share = |share: usize| {
                interpolated(|sum| before.ln_weight(sum, share), before.sums.len(), along)
            };
            let row: Vec<f64> = (0..before.shares.len()).map(of_share).collect();
            let row =
                (0..shares.len()).map(|share| interpolated(|i| row[i], row.len(), place(share)));
            fitted.weights.extend(row);
        }
        let best = fitted.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        fitted.weights.iter_mut().for_each(|weight| *weight = (*weight - best).exp());
        fitted.normalise();
        Some(fitted)
    }

    fn ln_weight(&self, sum: usize, share: usize) -> f64 {
        let weight = self.weights[sum * self.shares.len() + share];
        if weight > 0.0 { weight.ln() } else { LN_GIVEN_UP }
    }

    /// The weight of every sum, whatever the share.
    fn of_sums(&self) -> Vec<f64> {
        self.weights.chunks(self.shares.len()).map(|shares| shares.iter().sum()).collect()
    }

    /// The weight of every share, whatever the sum.
    fn of_shares(&self) -> Vec<f64> {
        let shares = self.shares.len();
        (0..shares).map(|share| self.weights.iter().skip(share).step_by(shares).sum()).collect()
    }

    /// The sum of dead time and lag in s.
    pub fn sum(&self) -> Quantity {
        let sums = self.of_sums();
        Quantity::of(self.cells(&sums))
    }

    /// Mean and standard deviation of the sum in s.
    pub fn sum_moments(&self) -> (f64, f64) {
        let sums = self.of_sums();
        moments(self.cells(&sums))
    }

    fn cells<'a>(&'a self, sums: &'a [f64]) -> impl Iterator<Item = Cell> + Clone + 'a {
        sums.iter().enumerate().map(|(index, weight)| {
            let (low, high) = self.sums.cell(index);
            (low, high, *weight)
        })
    }

    /// The lag in s.
    pub fn lag(&self) -> Quantity {
        self.part(|share| share)
    }

    /// The dead time in s.
    pub fn dead_time(&self) -> Quantity {
        self.part(|share| 1.0 - share)
    }

    fn part(&self, of_share: fn(f64) -> f64) -> Quantity {
        let shares = self.shares.len();
        let cells: Vec<(f64, f64, f64)> = self
            .alive()
            .map(|it| {
                let (low, high) = self.shares.cell(it.index % shares);
                let (one, other) = (it.sum * of_share(low), it.sum * of_share(high));
                (one.min(other), one.max(other), it.weight)
            })
            .collect();
        Quantity::of(cells.iter().copied())
    }

    /// The dead time and the lag in s that are expected.
    pub fn expected(&self) -> (f64, f64) {
        let weights: f64 = self.weights.iter().sum();
        let share = self.alive().map(|it| it.weight * it.share).sum::<f64>() / weights;
        let (sum, _) = self.sum_moments();
        (sum * (1.0 - share), sum * share)
    }
}

/// A positive number to three digits.
pub(super) fn three_digits(number: f64) -> f64 {
    let exponent = 2 - number.log10().floor() as i32;
    let whole = (number * 10.0_f64.powi(exponent)).round();
    // Dividing by a power of ten, not multiplying by its inverse, gives the number that is written shortest.
    if exponent >= 0 { whole / 10.0_f64.powi(exponent) } else { whole * 10.0_f64.powi(-exponent) }
}
