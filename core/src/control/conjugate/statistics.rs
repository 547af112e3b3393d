//! Samples summed up: what a conjugate update needs of them.

use serde::{Deserialize, Serialize};

/// Number, weight, weighted mean and weighted sum of squares about it (Welford 1962; West 1979).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SampleStatistics {
    /// Number n of samples.
    pub samples: u64,
    /// Sum of their weights m.
    pub weight: f64,
    /// Their weighted mean.
    pub mean: f64,
    /// Sum of m (x - mean)^2.
    pub squares: f64,
}

impl SampleStatistics {
    /// Adds a sample `x` ~ N(mean, sigma^2/m) of weight `m` > 0.
    pub fn add(&mut self, x: f64, m: f64) {
        self.samples += 1;
        self.weight += m;
        let before = x - self.mean;
        self.mean += m / self.weight * before;
        self.squares += m * before * (x - self.mean);
    }

    /// The samples' own estimate of sigma^2, from two on: squares/(n - 1).
    pub fn variance(&self) -> Option<f64> {
        (self.samples >= 2).then(|| self.squares / (self.samples - 1) as f64)
    }
}
