//! What the thesis's claims come to: in numbers, and each finding in plain words. The words are made in `umwelt-lab`.

use super::Reductions;
use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What the thesis claims of `bayesian` against `statistic`, and what it comes to in one environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Claim)]
pub struct Claim {
    /// The environment.
    pub environment: String,
    /// Slots per horizon of both.
    pub slots: u64,
    /// For whom it is claimed, as `bayesian/20`.
    pub contender: String,
    /// Against whom, as `statistic/20`.
    pub against: String,
    /// How much smaller the deviation is.
    pub deviation_reduction: Reductions,
    /// How much shorter the time is.
    pub time_reduction: Reductions,
    /// How much smaller the thesis says that the deviation is, as a part.
    #[serde(serialize_with = "number::finite")]
    pub promised_deviation: f64,
    /// How much shorter the thesis says that the time is, as a part.
    #[serde(serialize_with = "number::finite")]
    pub promised_time: f64,
    /// Share of the trials in which `contender` arrived within the time limit, 0 to 1.
    #[serde(serialize_with = "number::finite")]
    pub arrived: f64,
    /// Share of the trials in which `against` did.
    #[serde(serialize_with = "number::finite")]
    pub against_arrived: f64,
    /// What the means say, in plain words: how much less or more, with the interval, and which share of the thesis's
    /// number is reached; says so where the interval includes zero, and where robots did not arrive.
    pub verdict: String,
    /// The same, finding by finding: the words of all of them make the verdict.
    #[serde(default)]
    pub findings: Vec<Finding>,
}

/// One finding of a verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Finding)]
pub struct Finding {
    /// What it is about.
    pub about: FindingSubject,
    /// What was found.
    pub result: FindingResult,
    /// The finding in plain words, with its numbers.
    pub words: String,
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = FindingSubject)]
pub enum FindingSubject {
    /// The largest deviation from the path.
    Deviation,
    /// The time to the arrival.
    Time,
    /// Whether robots arrived at all.
    Arrival,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = FindingResult)]
pub enum FindingResult {
    /// The claim is reached, or more.
    Reached,
    /// It is better than the baseline, by less than is claimed.
    Partly,
    /// The interval includes zero: no difference is shown.
    NoDifference,
    /// It is worse than the baseline.
    Opposite,
    /// There is no part of a number that is zero.
    Undefined,
    /// Some robots did not arrive; their trials count with the time limit and as far as they got.
    NotAllArrived,
    /// One of the two never arrived: neither deviation nor time says anything.
    NoneArrived,
}
