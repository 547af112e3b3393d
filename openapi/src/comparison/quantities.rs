//! The three numbers that say how a quantity is distributed, and how two differ in them.

use crate::estimate::Estimate;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Mean, median and 90 % quantile over the trials, each with its 95 % bootstrap interval; `mean` of each is its value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Quantities)]
pub struct Quantities {
    /// The mean.
    pub mean: Estimate,
    /// The median.
    pub median: Estimate,
    /// The 90 % quantile.
    pub p90: Estimate,
}

/// How much smaller mean, median and 90 % quantile are than another's, as a part of the other's: 1 - this/other, 0.2
/// for a fifth less, negative where they are larger. Null where the other's is zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Reductions)]
pub struct Reductions {
    /// Of the mean.
    pub mean: Option<Estimate>,
    /// Of the median.
    pub median: Option<Estimate>,
    /// Of the 90 % quantile.
    pub p90: Option<Estimate>,
}
