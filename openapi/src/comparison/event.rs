//! What happens to a comparison, as server-sent events.
//!
//! The `id:` of an event is the number of trials that every contender has driven:
//! [`JobEvent::id`](crate::job::JobEvent::id). It survives a restart of the server. Only the newest state counts: a stream
//! says the state as it is now, whatever `Last-Event-ID`, then each change of it, and ends with the state in which the
//! comparison ended.

use super::{Progress, State};
use crate::job::JobNews;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

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

impl JobNews<Progress> for Kind {
    fn of_state(state: State, progress: Progress, error: Option<String>) -> Self {
        Self::State { state, progress, error }
    }

    fn state(&self) -> Option<(State, &Progress)> {
        match self {
            Self::State { state, progress, .. } => Some((*state, progress)),
            _ => None,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::State { .. } => "state",
            Self::Other => "other",
        }
    }
}
