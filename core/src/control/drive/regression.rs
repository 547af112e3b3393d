//! What is known of a coordinate's constants and of its slip.

use super::parts::Normal;
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Standard deviations of the ratio over 100 ms that the slip may have: those of floors from hard to ice.
pub const LEVELS: [f64; 7] = [0.005, 0.011, 0.023, 0.05, 0.11, 0.23, 0.5];

/// Constants of a coordinate (scale, drift): mean and covariance; and how likely each level of slip is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Kept", try_from = "Kept")]
pub struct Regression<const P: usize> {
    pub mean: SVector<f64, P>,
    pub covariance: SMatrix<f64, P, P>,
    pub levels: [f64; LEVELS.len()],
}

impl<const P: usize> Regression<P> {
    /// Constants with these means and variances; every level as likely.
    pub fn new(known: [Normal; P]) -> Self {
        Self {
            mean: known.map(|it| it.mean).into(),
            covariance: SMatrix::from_diagonal(&known.map(|it| it.variance).into()),
            levels: [1.0 / LEVELS.len() as f64; LEVELS.len()],
        }
    }

    /// One of the constants.
    pub fn of(&self, index: usize) -> Normal {
        Normal { mean: self.mean[index], variance: self.covariance[(index, index)] }
    }

    /// The level is another one with this `chance`.
    pub fn mix(&mut self, chance: f64) {
        for level in &mut self.levels {
            *level += chance * (1.0 / LEVELS.len() as f64 - *level);
        }
    }

    /// Each constant becomes `factor` times itself and `offset` more.
    pub fn rescale(&mut self, factor: [f64; P], offset: [f64; P]) {
        let factor = SVector::from(factor);
        self.mean = self.mean.component_mul(&factor) + SVector::from(offset);
        let factor = SMatrix::from_diagonal(&factor);
        self.covariance = factor * self.covariance * factor;
    }

    /// The mixture of what hypotheses say, each with its weight, by its moments. The weights sum to one.
    pub fn mixture(judged: impl Iterator<Item = (Self, f64)> + Clone) -> Self {
        let mut mixed = Self {
            mean: SVector::zeros(),
            covariance: SMatrix::zeros(),
            levels: [0.0; LEVELS.len()],
        };
        for (it, weight) in judged.clone() {
            mixed.mean += it.mean * weight;
            for (sum, level) in mixed.levels.iter_mut().zip(it.levels) {
                *sum += weight * level;
            }
        }
        for (it, weight) in judged {
            let apart = it.mean - mixed.mean;
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
}

impl<const P: usize> From<Regression<P>> for Kept {
    fn from(it: Regression<P>) -> Self {
        Self {
            mean: it.mean.as_slice().to_vec(),
            covariance: it.covariance.as_slice().to_vec(),
            levels: it.levels.to_vec(),
        }
    }
}

impl<const P: usize> TryFrom<Kept> for Regression<P> {
    type Error = &'static str;

    fn try_from(kept: Kept) -> Result<Self, Self::Error> {
        let levels = kept.levels.try_into().map_err(|_| "another number of levels of slip")?;
        if kept.mean.len() != P || kept.covariance.len() != P * P {
            return Err("another number of constants");
        }
        Ok(Self {
            mean: SVector::from_column_slice(&kept.mean),
            covariance: SMatrix::from_column_slice(&kept.covariance),
            levels,
        })
    }
}
