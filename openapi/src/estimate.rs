//! A number with how well it is known.

use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

// The schema has the name that it had when evolutions alone estimated something: names are the contract's.
/// A mean with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Estimate)]
pub struct Estimate {
    /// The mean.
    #[serde(serialize_with = "number::finite")]
    pub mean: f64,
    /// Lower end of the interval.
    #[serde(serialize_with = "number::finite")]
    pub low: f64,
    /// Upper end of the interval.
    #[serde(serialize_with = "number::finite")]
    pub high: f64,
}

impl Estimate {
    /// Whether the interval includes zero: then no difference is shown.
    pub fn includes_zero(&self) -> bool {
        self.low <= 0.0 && 0.0 <= self.high
    }
}
