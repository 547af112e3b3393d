//! A Kalman filter along one coordinate of the motion: how well a hypothesis predicts what was seen, and what it learns of
//! scale and slip meanwhile.

use super::regression::{LEVELS, Regression};
use crate::prediction::ERROR_WINDOW;
use nalgebra::{SMatrix, SVector};

/// ln 2 pi.
const LN_TWO_PI: f64 = 1.837_877_066_409_345_5;

/// A level of slip less likely than this is left out; that next to a likely one is not.
const UNLIKELY: f64 = 0.01;

/// What a hypothesis comes to along one coordinate, over all levels of slip.
#[derive(Clone, Copy, Debug)]
pub struct Judgement<const P: usize> {
    pub ln_evidence: f64,
    /// Sum of squares of how far what was seen lies off, in standard deviations, under the likeliest level.
    pub square: f64,
    pub known: Regression<P>,
}

/// Where the robot is along the coordinate, and its constants, under one level of slip.
#[derive(Clone, Copy, Debug)]
struct Filter<const P: usize> {
    /// Variance of the ratio over 100 ms, times 100 ms.
    intensity: f64,
    /// Variance of one pose's noise.
    noise: f64,
    /// Where it is, as seen from the last pose, and how well that is known.
    at: f64,
    variance: f64,
    /// Covariance of that with the constants.
    shared: SVector<f64, P>,
    mean: SVector<f64, P>,
    covariance: SMatrix<f64, P, P>,
    ln_evidence: f64,
    square: f64,
}

/// The filters of all levels that are likely at all.
pub struct Filters<const P: usize> {
    filters: [Option<Filter<P>>; LEVELS.len()],
    known: Regression<P>,
}

impl<const P: usize> Filter<P> {
    fn step(&mut self, base: f64, by: SVector<f64, P>, power: f64, seen: f64) {
        let with = self.covariance * by;
        let moved = base + by.dot(&self.mean);
        let variance =
            self.variance + self.intensity * power + 2.0 * by.dot(&self.shared) + by.dot(&with);
        let shared = self.shared + with;
        let total = variance + self.noise;
        let innovation = seen - (self.at + moved);
        let gain = variance / total;
        self.ln_evidence -= 0.5 * (innovation * innovation / total + total.ln() + LN_TWO_PI);
        self.square += innovation * innovation / total;
        // Counted from the new pose.
        self.at += moved + gain * innovation - seen;
        self.variance = variance * (1.0 - gain);
        self.mean += shared * (innovation / total);
        self.covariance -= shared * shared.transpose() / total;
        self.shared = shared * (1.0 - gain);
    }
}

impl<const P: usize> Filters<P> {
    /// A filter per level, from a first pose with `noise` as standard deviation.
    pub fn new(known: &Regression<P>, noise: f64) -> Self {
        let filters = std::array::from_fn(|level| {
            (known.levels[level] > UNLIKELY).then(|| Filter {
                intensity: LEVELS[level] * LEVELS[level] * ERROR_WINDOW,
                noise: noise * noise,
                at: 0.0,
                variance: noise * noise,
                shared: SVector::zeros(),
                mean: known.mean,
                covariance: known.covariance,
                ln_evidence: 0.0,
                square: 0.0,
            })
        });
        Self { filters, known: *known }
    }

    /// Goes on by a motion that moves `by[0]`, and `by` for each unit of the constants, with errors white in time of this
    /// `power`; the next pose was `seen` to lie so far from the last one.
    pub fn step(&mut self, by: [f64; P], power: f64, seen: f64) {
        self.step_from(by[0], by, power, seen);
    }

    /// The same by a motion that moves `base` whatever the constants.
    pub fn step_from(&mut self, base: f64, by: [f64; P], power: f64, seen: f64) {
        for filter in self.filters.iter_mut().flatten() {
            filter.step(base, by.into(), power, seen);
        }
    }

    /// What all levels come to together.
    pub fn judgement(&self) -> Judgement<P> {
        let ln_weights: [f64; LEVELS.len()] = std::array::from_fn(|level| {
            let it = self.filters[level].as_ref();
            it.map_or(f64::NEG_INFINITY, |it| it.ln_evidence + self.known.levels[level].ln())
        });
        let best = ln_weights.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = ln_weights.iter().map(|ln_weight| (ln_weight - best).exp()).sum();
        let found = ln_weights.iter().enumerate().filter_map(|(level, ln_weight)| {
            let it = self.filters[level].as_ref()?;
            let mut levels = [0.0; LEVELS.len()];
            levels[level] = 1.0;
            let known = self.known.updated(it.mean, it.covariance, levels);
            Some((known, (ln_weight - best).exp() / sum))
        });
        let likeliest = self
            .filters
            .iter()
            .zip(ln_weights)
            .filter_map(|(it, weight)| Some((it.as_ref()?, weight)));
        let likeliest = likeliest.max_by(|one, other| one.1.total_cmp(&other.1));
        Judgement {
            ln_evidence: best + sum.ln(),
            square: likeliest.map_or(f64::INFINITY, |(it, _)| it.square),
            known: Regression::mixture(found),
        }
    }
}
