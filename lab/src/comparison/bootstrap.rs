//! Intervals by the bootstrap: trials are drawn again, for all contenders the same ones, so that what is paired stays
//! paired (Efron & Tibshirani 1993, percentile intervals).

use super::quantities::{LEVEL, Quantities};
use crate::evolution::Estimate;
use crate::seeds::{self, Purpose};
use rand::RngExt;

/// How often trials are drawn again: the ends of an interval are known to about a twentieth of its width.
pub(super) const RESAMPLES: usize = 2000;

/// How often each trial was drawn, resample by resample.
pub(super) struct Resamples {
    trials: usize,
    counts: Vec<Vec<u16>>,
}

impl Resamples {
    /// Of `trials` trials in the environment of this number.
    pub(super) fn new(trials: usize, seed: u64, environment: usize) -> Self {
        let mut rng = seeds::rng(seed, Purpose::Resample, environment);
        let mut draw = || {
            let mut counts = vec![0_u16; trials];
            for _ in 0..trials {
                let drawn = &mut counts[rng.random_range(0..trials)];
                *drawn = drawn.saturating_add(1);
            }
            counts
        };
        Self { trials, counts: (0..RESAMPLES).map(|_| draw()).collect() }
    }

    /// `statistic` of the trials as they are, and of each resample; its argument is how often each trial counts.
    pub(super) fn of<T>(&self, statistic: impl Fn(&[u16]) -> T) -> Replicates<T> {
        let value = statistic(&vec![1; self.trials]);
        Replicates { value, drawn: self.counts.iter().map(|counts| statistic(counts)).collect() }
    }
}

/// A statistic, and what it is where the trials are drawn again.
pub(super) struct Replicates<T> {
    value: T,
    drawn: Vec<T>,
}

impl<T: Copy> Replicates<T> {
    /// The interval of what `of` makes of it.
    pub(super) fn estimate(&self, of: impl Fn(T) -> f64) -> Estimate {
        estimate(of(self.value), self.drawn.iter().map(|drawn| of(*drawn)).collect())
    }

    /// The interval of what `of` makes of it and of another one of the same resamples.
    pub(super) fn paired<U: Copy>(
        &self,
        other: &Replicates<U>,
        of: impl Fn(T, U) -> f64,
    ) -> Estimate {
        let drawn = self.drawn.iter().zip(&other.drawn).map(|(one, other)| of(*one, *other));
        estimate(of(self.value, other.value), drawn.collect())
    }
}

fn estimate(mean: f64, mut drawn: Vec<f64>) -> Estimate {
    drawn.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| drawn[((drawn.len() - 1) as f64 * share).round() as usize];
    let tail = (1.0 - LEVEL) / 2.0;
    Estimate { mean, low: at(tail), high: at(1.0 - tail) }
}

/// Values in their order, so that quantiles of resamples need no sorting.
pub(super) struct Sorted {
    /// (value, trial).
    values: Vec<(f64, usize)>,
}

impl Sorted {
    pub(super) fn new(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<_> = values.enumerate().map(|(trial, value)| (value, trial)).collect();
        values.sort_by(|one, other| one.0.total_cmp(&other.0));
        Self { values }
    }

    /// Mean, median and 90 % quantile (nearest rank), where each trial counts so often.
    pub(super) fn quantities(&self, counts: &[u16]) -> Quantities<f64> {
        let all = counts.len() as f64;
        let (half, most) = ((0.5 * all).ceil() as usize, (0.9 * all).ceil() as usize);
        let (mut sum, mut before) = (0.0, 0);
        let mut found = [self.values[0].0; 2];
        for &(value, trial) in &self.values {
            let count = usize::from(counts[trial]);
            sum += count as f64 * value;
            for (found, rank) in found.iter_mut().zip([half, most]) {
                if before < rank && count > 0 {
                    *found = value;
                }
            }
            before += count;
        }
        let [median, p90] = found;
        Quantities { mean: sum / all, median, p90 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn quantiles_are_those_of_the_values_as_often_as_they_count() {
        let sorted = Sorted::new([5.0, 1.0, 4.0, 2.0, 3.0].into_iter());
        let once = sorted.quantities(&[1; 5]);
        assert_eq!((once.mean, once.median, once.p90), (3.0, 3.0, 5.0));
        // 5 twice, 1 three times: 1 1 1 5 5.
        let drawn = sorted.quantities(&[2, 3, 0, 0, 0]);
        assert_eq!((drawn.mean, drawn.median, drawn.p90), (2.6, 1.0, 5.0));
        let last = sorted.quantities(&[0, 0, 0, 5, 0]);
        assert_eq!((last.mean, last.median, last.p90), (2.0, 2.0, 2.0));
    }

    /// Guards against: an interval that says 95 % and holds less. 400 samples of 60 normal numbers, mean and median;
    /// that many intervals hold the truth in 95 +- 2.2 % of the cases (two sd), the bootstrap of a mean of 60 in 94.
    #[test]
    fn an_interval_holds_the_truth_as_often_as_it_says() {
        let (trials, runs) = (60, 400);
        let resamples = Resamples::new(trials, 5, 0);
        let mut held = [0, 0];
        for run in 0..runs {
            let mut rng = seeds::rng(run, Purpose::Compare, 0);
            let values = (0..trials).map(|_| -> f64 { StandardNormal.sample(&mut rng) });
            let sorted = Sorted::new(values);
            let drawn = resamples.of(|counts| sorted.quantities(counts));
            for (held, estimate) in
                held.iter_mut().zip([drawn.estimate(|it| it.mean), drawn.estimate(|it| it.median)])
            {
                *held += u64::from(estimate.includes_zero());
            }
        }
        let shares = held.map(|held| held as f64 / runs as f64);
        assert!(shares.iter().all(|share| (0.91..=0.98).contains(share)), "{shares:?}");
    }

    /// What is paired stays paired: two that differ by a constant differ by it in every resample.
    #[test]
    fn a_difference_is_of_the_same_trials() {
        let resamples = Resamples::new(30, 1, 0);
        let values = |plus: f64| Sorted::new((0..30).map(move |i| f64::from(i * i % 17) + plus));
        let (one, other) = (values(0.5), values(0.0));
        let one = resamples.of(|counts| one.quantities(counts));
        let other = resamples.of(|counts| other.quantities(counts));
        let difference = one.paired(&other, |one, other| one.mean - other.mean);
        assert!((difference.low - 0.5).abs() < 1e-9 && (difference.high - 0.5).abs() < 1e-9);
        assert!(one.estimate(|it| it.mean).high > one.estimate(|it| it.mean).low + 1.0);
    }
}
