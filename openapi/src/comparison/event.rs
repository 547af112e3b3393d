//! What happens to a comparison, as server-sent events.
//!
//! The `id:` of an event is the number of trials that every contender has driven: [`Event::id`]. It survives a restart
//! of the server. Only the newest state counts: a stream says the state as it is now, whatever `Last-Event-ID`, then
//! each change of it, and ends with the state in which the comparison ended.

use super::{Progress, State};
use crate::id::ComparisonId;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Something that happened to a comparison.
///
/// ```
/// use umwelt_api::comparison::{Event, Kind};
/// let later = r#"{"id": 8, "comparison": "comparison-1", "type": "of-tomorrow", "much": 1}"#;
/// assert_eq!(serde_json::from_str::<Event>(later)?.kind, Kind::Other);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonEvent)]
pub struct Event {
    /// Trials that every contender has driven: never decreasing, the same after a restart.
    pub id: u64,
    /// The comparison.
    pub comparison: ComparisonId,
    /// What happened.
    #[serde(flatten)]
    pub kind: Kind,
}

/// What happened to a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = ComparisonKind)]
pub enum Kind {
    /// The state, the stage, or how far it has got: at the beginning of a stream, and after each change.
    State {
        /// Where it stands.
        state: State,
        /// How far it has got.
        progress: Progress,
        /// Why it failed, or what keeps it from going on; null where nothing does.
        error: Option<String>,
    },
    /// Something of a later version.
    #[serde(other, skip_serializing)]
    Other,
}

impl Kind {
    /// The value of `type`, and of `event:` in the stream.
    pub fn name(&self) -> &'static str {
        match self {
            Self::State { .. } => "state",
            Self::Other => "other",
        }
    }
}

impl Event {
    /// The event that the comparison stands here now.
    pub fn state(
        comparison: ComparisonId,
        state: State,
        progress: Progress,
        error: Option<String>,
    ) -> Self {
        Self { id: progress.trials_done, comparison, kind: Kind::State { state, progress, error } }
    }
}
