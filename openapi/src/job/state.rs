//! Where a job stands.

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

// The schema has the name that it had when evolutions alone were done in the background: names are the contract's.
/// Where an evolution stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = JobState)]
pub enum State {
    /// It waits for its turn.
    Queued,
    /// It goes on.
    Running,
    /// It has its result.
    Succeeded,
    /// It could not go on; `error` says why.
    Failed,
    /// It was cancelled.
    Cancelled,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 5] =
        [Self::Queued, Self::Running, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Whether it will never change again.
    pub fn has_ended(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}
