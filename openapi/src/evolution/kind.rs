//! Evolutions among the jobs.

use super::{Champion, Generation, Kind, Progress, Request, Spec};
use crate::id::{EvolutionId, PriorId};
use crate::job::{Job, JobDescription, JobEvent, JobKind, JobPage};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Evolutions among the jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EvolutionKind;

/// An evolution as it is now.
pub type Evolution = Job<EvolutionKind>;

/// What an evolution ends with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Outcome {
    /// The name under which its champion was kept as a prior; null until then.
    pub prior: Option<PriorId>,
    /// What it found; null until it has succeeded.
    pub champion: Option<Champion>,
}

impl JobKind for EvolutionKind {
    const NAME: &'static str = "evolution";
    const LIST: &'static str = "evolutions";
    const DESCRIPTION: JobDescription = JobDescription {
        job: "Evolution",
        page: "EvolutionPage",
        event: "EvolutionEvent",
        one: "an evolution",
        listed: "The evolutions.",
        event_id: "Generations that have ended: never decreasing, the same after a restart.",
    };
    /// Each may have a report of some tens of kilobytes.
    const PAGE_SIZE: u64 = 50;
    type Id = EvolutionId;
    type Request = Request;
    type Spec = Spec;
    type Progress = Progress;
    type Outcome = Outcome;
    type News = Kind;

    fn id(number: u64) -> EvolutionId {
        EvolutionId::numbered(number)
    }

    fn event_id(progress: &Progress) -> u64 {
        progress.generation
    }

    fn episodes(progress: &Progress) -> (u64, u64) {
        (progress.episodes, progress.total_episodes)
    }
}

/// Some of the evolutions, the newest first.
pub type Page = JobPage<EvolutionKind>;

/// Something that happened to an evolution.
///
/// ```
/// use umwelt_api::evolution::{Event, Kind};
/// let later = r#"{"id": 8, "evolution": "evolution-1", "type": "of-tomorrow", "much": 1}"#;
/// assert_eq!(serde_json::from_str::<Event>(later)?.kind, Kind::Other);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Event = JobEvent<EvolutionKind>;

impl Event {
    /// The event that `generation` ended.
    pub fn generation(evolution: EvolutionId, generation: Generation) -> Self {
        let id = generation.index + 1;
        Self { id, job: evolution, kind: Kind::Generation { generation: Box::new(generation) } }
    }
}
