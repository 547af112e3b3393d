//! What happens to an evolution, as server-sent events.
//!
//! The `id:` of an event is the number of generations that have ended: [`JobEvent::id`](crate::job::JobEvent::id). It
//! survives a restart of the server. A stream begins with the generations behind `Last-Event-ID` (all of them without
//! it: they are kept, so nothing is missed), then says the state as it is now and goes on with what happens. A state
//! never counts a generation that the stream has not sent before. The stream ends with the state in which the evolution
//! ended.

use super::{Generation, Progress, State};
use crate::job::JobNews;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What happened to an evolution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = EvolutionKind)]
pub enum Kind {
    /// A generation ended; the event's id is its index plus one.
    Generation {
        /// What came of it.
        generation: Box<Generation>,
    },
    /// The state, the stage, or how far it has got: once what is past has been told, and after each change.
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
            Self::Generation { .. } => "generation",
            Self::State { .. } => "state",
            Self::Other => "other",
        }
    }
}
