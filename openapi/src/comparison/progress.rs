//! How far a comparison has got.

use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What a comparison is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = ComparisonStage)]
pub enum Stage {
    /// It waits for its turn.
    Queued,
    /// It is measured how each environment shows in the samples.
    Reference,
    /// Contenders drive.
    Trials,
    /// There is a report.
    Done,
}

impl Stage {
    /// Every stage, in their order.
    pub const ALL: [Self; 4] = [Self::Queued, Self::Reference, Self::Trials, Self::Done];

    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Reference => "reference",
            Self::Trials => "trials",
            Self::Done => "done",
        }
    }
}

/// How far a comparison has got.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonProgress)]
pub struct Progress {
    /// What it is doing; where it has failed or was cancelled, what it was doing then.
    pub stage: Stage,
    /// Trials that every contender has driven in every environment.
    pub trials_done: u64,
    /// Trials in all.
    pub trials: u64,
    /// Simulated episodes driven.
    pub episodes: u64,
    /// Episodes in all.
    pub total_episodes: u64,
    /// Time for which it has run; the time between a stop of the server and its start does not count.
    #[serde(serialize_with = "number::finite")]
    pub elapsed_s: f64,
    /// Time that it will still need at the pace so far; null where that is not known.
    pub remaining_s: Option<f64>,
}
