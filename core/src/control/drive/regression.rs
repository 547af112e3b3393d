//! What is known of a coordinate's constants and of its slip.

use super::parts::Normal;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use serde::{Deserialize, Serialize};

/// Standard deviations of the ratio over 100 ms that the slip may have: those of floors from hard to ice.
pub const LEVELS: [f64; 7] = [0.005, 0.011, 0.023, 0.05, 0.11, 0.23, 0.5];

/// Constants of a coordinate (scale, drift): mean and covariance; and how likely each level of slip is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Kept", try_from = "Kept")]
pub struct Regression<const P: usize> {
    pub mean: SVector<f64, P>,
    /// Their covariance for a known delay.
    pub covariance: SMatrix<f64, P, P>,
    pub levels: [f64; LEVELS.len()],
    /// The delay that the mean is for, and how much the mean changes with it: what is taken for scale depends on what is
    /// taken for time.
    delay: Delay,
    slope: SMatrix<f64, P, 2>,
    /// Covariance of the delay.
    spread: Matrix2<f64>,
}

/// A hypothesis: dead time and lag together in s, and the share of the lag.
pub type Delay = Vector2<f64>;

/// Variances of the delay below which nothing is said to change with it: a tenth of a millisecond, a share of 1 %.
const EXACT: Delay = Delay::new(1e-8, 1e-4);

impl<const P: usize> Regression<P> {
    /// Constants with these means and variances; every level as likely.
    pub fn new(known: [Normal; P]) -> Self {
        Self {
            mean: known.map(|it| it.mean).into(),
            covariance: SMatrix::from_diagonal(&known.map(|it| it.variance).into()),
            levels: [1.0 / LEVELS.len() as f64; LEVELS.len()],
            delay: Delay::zeros(),
            slope: SMatrix::zeros(),
            spread: Matrix2::zeros(),
        }
    }

    /// The same for one hypothesis.
    pub fn at(&self, delay: Delay) -> Self {
        Self { mean: self.mean + self.slope * (delay - self.delay), delay, ..*self }
    }

    /// What a stretch makes of it under one hypothesis.
    pub fn updated(
        &self,
        mean: SVector<f64, P>,
        covariance: SMatrix<f64, P, P>,
        levels: [f64; LEVELS.len()],
    ) -> Self {
        Self { mean, covariance, levels, ..*self }
    }

    /// One of the constants.
    pub fn of(&self, index: usize) -> Normal {
        let slope = self.slope.row(index);
        let by_delay = (slope * self.spread * slope.transpose())[(0, 0)];
        Normal { mean: self.mean[index], variance: self.covariance[(index, index)] + by_delay }
    }

    /// The level becomes the next one, either way, with this `chance`.
    pub fn mix(&mut self, chance: f64) {
        let before = self.levels;
        let last = before.len() - 1;
        for (at, level) in self.levels.iter_mut().enumerate() {
            let next = before[at.saturating_sub(1)] + before[(at + 1).min(last)];
            *level += chance * (next - 2.0 * before[at]);
        }
    }

    /// Each constant becomes `factor` times itself and `offset` more.
    pub fn rescale(&mut self, factor: [f64; P], offset: [f64; P]) {
        let factor = SVector::from(factor);
        self.mean = self.mean.component_mul(&factor) + SVector::from(offset);
        let factor = SMatrix::from_diagonal(&factor);
        self.covariance = factor * self.covariance * factor;
        self.slope = factor * self.slope;
    }

    /// The mixture of what hypotheses say, each with its weight, by its moments and by how the means change with the delay.
    /// The weights sum to one.
    pub fn mixture(judged: impl Iterator<Item = (Self, f64)> + Clone) -> Self {
        let mut mixed = Self::new([Normal { mean: 0.0, variance: 0.0 }; P]);
        mixed.levels = [0.0; LEVELS.len()];
        for (it, weight) in judged.clone() {
            mixed.mean += it.mean * weight;
            mixed.delay += it.delay * weight;
            for (sum, level) in mixed.levels.iter_mut().zip(it.levels) {
                *sum += weight * level;
            }
        }
        let mut shared = SMatrix::<f64, P, 2>::zeros();
        for (it, weight) in judged.clone() {
            let later = it.delay - mixed.delay;
            mixed.spread += later * later.transpose() * weight;
            shared += (it.mean - mixed.mean) * later.transpose() * weight;
        }
        let spread = mixed.spread + Matrix2::from_diagonal(&EXACT);
        mixed.slope = spread.try_inverse().map_or(SMatrix::zeros(), |inverse| shared * inverse);
        for (it, weight) in judged {
            let apart = it.mean - mixed.mean - mixed.slope * (it.delay - mixed.delay);
            mixed.covariance += (it.covariance + apart * apart.transpose()) * weight;
        }
        mixed
    }
}

/// The stored form.
#[derive(Serialize, Deserialize)]
struct Kept {
    mean: Vec<f64>,
    covariance: Vec<f64>,
    levels: Vec<f64>,
    delay: [f64; 2],
    slope: Vec<f64>,
    spread: [f64; 4],
}

impl<const P: usize> From<Regression<P>> for Kept {
    fn from(it: Regression<P>) -> Self {
        Self {
            mean: it.mean.as_slice().to_vec(),
            covariance: it.covariance.as_slice().to_vec(),
            levels: it.levels.to_vec(),
            delay: it.delay.into(),
            slope: it.slope.as_slice().to_vec(),
            spread: [it.spread.m11, it.spread.m21, it.spread.m12, it.spread.m22],
        }
    }
}

impl<const P: usize> TryFrom<Kept> for Regression<P> {
    type Error = &'static str;

    fn try_from(kept: Kept) -> Result<Self, Self::Error> {
        let levels = kept.levels.try_into().map_err(|_| "another number of levels of slip")?;
        let lengths = (kept.mean.len(), kept.covariance.len(), kept.slope.len());
        if lengths != (P, P * P, 2 * P) {
            return Err("another number of constants");
        }
        Ok(Self {
            mean: SVector::from_column_slice(&kept.mean),
            covariance: SMatrix::from_column_slice(&kept.covariance),
            levels,
            delay: kept.delay.into(),
            slope: SMatrix::from_column_slice(&kept.slope),
            spread: Matrix2::from_column_slice(&kept.spread),
        })
    }
}
