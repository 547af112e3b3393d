//! An estimate: its value, how well it is known, and how far it has got.

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// A quantity with its uncertainty, in the unit that its name ends with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DriveEstimate)]
pub struct Estimate {
    /// Its expected value; null where there is none.
    pub mean: Option<f64>,
    /// Its standard deviation; null where it is given.
    pub sd: Option<f64>,
    /// Holds it with probability `level`; null where it is given.
    pub interval: Option<Interval>,
}

/// How far an estimate has got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = EstimateStatus)]
pub enum Status {
    /// No sample can change it: it is a constant of a fixed model.
    Unestimated,
    /// The prior still dominates.
    Estimating,
    /// The samples say at least as much as the prior.
    Estimated,
    /// Samples are set aside: the watch holds the robot at rest because its motion is not what was commanded.
    Rejected,
    /// It is described, not identified.
    Given,
    /// Something of another version.
    #[default]
    #[serde(other)]
    Other,
}

impl Status {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unestimated => "unestimated",
            Self::Estimating => "estimating",
            Self::Estimated => "estimated",
            Self::Rejected => "rejected",
            Self::Given => "given",
            Self::Other => "other",
        }
    }
}

/// From `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Interval)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}
