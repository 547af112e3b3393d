//! One coordinate of a grid: where its points lie, and how the grid is fitted to what is known.

use serde::{Deserialize, Serialize};

/// A coordinate is made finer where it is known to fewer of its steps than this, and where the finer one still reaches
/// [`REACH`] standard deviations to both sides: it would be made coarser again.
const FINER: f64 = 1.2;

/// Standard deviations at which a weight is well below [`AT_END`].
const REACH: f64 = 4.0;

/// How much finer, or coarser again.
const ZOOM: f64 = 2.0;

/// Weight at an end from which on the grid ought to reach farther.
const AT_END: f64 = 1e-3;

/// Points at even steps within a range that begins at 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    from: f64,
    step: f64,
    points: usize,
    /// The range ends here.
    most: f64,
    /// Finest step.
    finest: f64,
}

impl Axis {
    /// The same number of points around `value`, `step` apart.
    pub fn around(self, value: f64, step: f64) -> Self {
        let last = self.points - 1;
        let longest = (self.most - step * last as f64).max(0.0);
        let from = (value - step * (last / 2) as f64).clamp(0.0, longest);
        Self { from: (from / step).round() * step, step, ..self }
    }

    /// So many points from 0 to `most`, at first.
    pub const fn new(points: usize, most: f64, finest: f64) -> Self {
        Self { from: 0.0, step: most / (points - 1) as f64, points, most, finest }
    }

    /// One point, which is known.
    pub const fn known(value: f64) -> Self {
        Self { from: value, step: 0.0, points: 1, most: value, finest: 0.0 }
    }

    fn finer(&self) -> f64 {
        FINER.min((self.points / 2) as f64 / ZOOM / REACH)
    }

    /// How many points it has.
    pub fn len(&self) -> usize {
        self.points
    }

    /// The point of this index.
    pub fn at(&self, index: usize) -> f64 {
        self.from + index as f64 * self.step
    }

    /// What of the range the point of this index stands for.
    pub fn cell(&self, index: usize) -> (f64, f64) {
        let (at, half) = (self.at(index), self.step / 2.0);
        ((at - half).max(0.0), (at + half).min(self.most))
    }

    /// Where `value` lies among the points.
    pub fn place(&self, value: f64) -> f64 {
        (value - self.from) / self.step
    }

    /// Finer where much is known, farther where an end is likely: by the weights of its points. None where it stays.
    pub fn fitted(&self, weights: &[f64]) -> Option<Self> {
        if self.points == 1 {
            return None;
        }
        let sum: f64 = weights.iter().sum();
        let part = |weight: &f64| weight / sum;
        let mean: f64 =
            weights.iter().enumerate().map(|(i, weight)| part(weight) * self.at(i)).sum();
        let variance: f64 = weights
            .iter()
            .enumerate()
            .map(|(i, weight)| part(weight) * (self.at(i) - mean).powi(2))
            .sum();
        let is_at_end = |index: usize| weights.get(index).is_some_and(|weight| *weight > AT_END);
        let last = self.points - 1;
        let is_short = (is_at_end(0) && self.from > 0.0)
            || (is_at_end(last) && self.at(last) < self.most - self.step / 2.0);
        let widest = self.most / last as f64;
        let step = if is_short {
            (self.step * ZOOM).min(widest)
        } else if variance.sqrt() < self.step * self.finer() && self.step > self.finest {
            self.step / ZOOM
        } else {
            return None;
        };
        Some(self.around(mean, step))
    }
}

/// The logarithm of a weight between the points of an axis: by a parabola. Beyond the ends it goes on, and no weight is
/// more than that of the end.
pub fn interpolated(ln_weight: impl Fn(usize) -> f64, points: usize, place: f64) -> f64 {
    let nearest = place.round().clamp(1.0, (points - 2) as f64);
    let index = nearest as usize;
    let (before, here, after) = (ln_weight(index - 1), ln_weight(index), ln_weight(index + 1));
    let (slope, bend) = ((after - before) / 2.0, (after + before) / 2.0 - here);
    let off = place - nearest;
    let along = here + slope * off + bend.min(0.0) * off * off;
    if place < 0.0 {
        along.min(before)
    } else if place > (points - 1) as f64 {
        along.min(after)
    } else {
        along
    }
}
