//! The three numbers that say how a quantity is distributed.

use serde::{Deserialize, Serialize};

/// Probability mass of every interval of a report.
pub const LEVEL: f64 = 0.95;

/// Mean, median and 90 % quantile of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantities<T> {
    /// The mean.
    pub mean: T,
    /// The median, nearest rank.
    pub median: T,
    /// The 90 % quantile, nearest rank.
    pub p90: T,
}

impl<T> Quantities<T> {
    /// The same of what `of` makes of each.
    pub fn map<U>(self, mut of: impl FnMut(T) -> U) -> Quantities<U> {
        Quantities { mean: of(self.mean), median: of(self.median), p90: of(self.p90) }
    }
}
