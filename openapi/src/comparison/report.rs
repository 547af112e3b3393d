//! The report of a comparison: every contender's distributions in numbers.

use super::{Claim, Quantities, Reductions};
use crate::estimate::Estimate;
use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// When a contender believed to be in the environment that it was in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Recognition)]
pub struct Recognition {
    /// Share of the trials at whose end it did, 0 to 1.
    #[serde(serialize_with = "number::finite")]
    pub share: f64,
    /// Samples of all channels together after which it did for good in half of the trials; null where it never did in
    /// more than half of them.
    pub median_samples: Option<u64>,
    /// The same in 90 % of the trials.
    pub p90_samples: Option<u64>,
}

/// A contender beside `statistic` with as many slots, paired by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Difference)]
pub struct Difference {
    /// The other one, as `statistic/20`.
    pub against: String,
    /// This one's time minus the other's.
    pub time_s: Quantities,
    /// This one's deviation minus the other's.
    pub deviation_m: Quantities,
    /// How much shorter this one's time is.
    pub time_reduction: Reductions,
    /// How much smaller this one's deviation is.
    pub deviation_reduction: Reductions,
}

/// A contender in an environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonEntry)]
pub struct Entry {
    /// Method and slots, as `bayesian/20`.
    pub contender: String,
    /// Share of the trials in which it arrived within the time limit, 0 to 1.
    pub arrived: Estimate,
    /// Time from the end of the calibration to the arrival; the time limit where there was none.
    pub time_s: Quantities,
    /// Largest deviation of the true position from the way.
    pub deviation_m: Quantities,
    /// When it believed to be where it was; null where there was nothing to tell apart or it does not identify.
    pub recognition: Option<Recognition>,
    /// Share of the samples within the 90 % interval that it had predicted for each; null where it does not identify.
    pub coverage: Option<Estimate>,
    /// Beside `statistic`; null for that one itself and where it did not drive.
    pub difference: Option<Difference>,
}

/// An environment, with everybody in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentReport)]
pub struct EnvironmentReport {
    /// The environment.
    pub environment: String,
    /// The contenders.
    pub entries: Vec<Entry>,
}

/// What came of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonReport)]
pub struct Report {
    /// Trials of each contender in each environment.
    pub trials: u64,
    /// Environment by environment.
    pub environments: Vec<EnvironmentReport>,
    /// What the thesis's claims come to, wherever `bayesian` and `statistic` both drove with as many slots.
    pub claims: Vec<Claim>,
}
