//! The samples alone.

use crate::conjugate::SampleStatistics;
use serde::{Deserialize, Serialize};

/// Weighted mean and spread of the samples alone (Welford), and the correlation of neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Statistics {
    pub samples: SampleStatistics,
    last: f64,
    neighbours: f64,
    power: f64,
}

impl Statistics {
    /// Takes in a ratio of this weight, whose innovation was `standardised` by its scale.
    pub fn update(&mut self, x: f64, weight: f64, standardised: f64) {
        self.samples.add(x, weight);
        self.neighbours += standardised * self.last;
        self.power += standardised * standardised;
        self.last = standardised;
    }

    /// n (1 - rho)/(1 + rho) for a lag-1 correlation rho in [0, 0.95].
    pub fn effective(&self) -> f64 {
        let rho = if self.power > 0.0 { self.neighbours / self.power } else { 0.0 };
        let rho = rho.clamp(0.0, 0.95);
        self.samples.samples as f64 * (1.0 - rho) / (1.0 + rho)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlated_samples_are_worth_fewer() {
        let mut statistics = Statistics::default();
        for i in 0..1000 {
            let x = f64::from(i / 20 % 2) * 2.0 - 1.0;
            statistics.update(x, 1.0, x);
        }
        assert!(statistics.effective() < 100.0);
        let mut alternating = Statistics::default();
        for i in 0..1000 {
            let x = f64::from(i % 2) * 2.0 - 1.0;
            alternating.update(x, 1.0, x);
        }
        assert!((alternating.effective() - 1000.0).abs() < 1e-9);
    }
}
