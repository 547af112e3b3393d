//! Evolutions: priors searched for in the background, in simulated environments.

mod champion;
mod event;
mod generation;
mod page;
mod progress;
mod request;
mod spec;

pub use crate::estimate::Estimate;
pub use crate::job::{PageQuery, State};
pub use champion::{Champion, Entry, EnvironmentResult, Ranking};
pub use event::{Event, Kind};
pub use generation::{Generation, GenerationEnvironment};
pub use page::{DEFAULT_GENERATIONS_SIZE, GenerationsPage, MAX_GENERATIONS_SIZE, Page};
pub use progress::{Progress, Stage};
pub use request::Request;
pub use spec::{
    ENVIRONMENTS, EXPANSION, GENERATIONS, MAX_BATCH, MAX_DEVIATION, MAX_EPISODES, MAX_TIME,
    Optimizer, POPULATION, PROBABILITY, Preset, REPORT_TRIALS, SELECTION_TRIALS, SUM_TOLERANCE,
    Spec, TRIALS,
};

use crate::id::{EvolutionId, PriorId};
use crate::job::{Job, JobDescription, JobKind};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Largest body of a request in bytes; a full one has 3 kB.
pub const MAX_BODY: usize = 64 * 1024;

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

/// A figure of an evolution (thesis figures 6 and 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = EvolutionFigure)]
pub enum Figure {
    /// Largest deviation, best and mean per generation (thesis figure 6).
    Deviation,
    /// Completion time, best and mean per generation (thesis figure 7).
    Time,
}

impl Figure {
    /// Every figure.
    pub const ALL: [Self; 2] = [Self::Deviation, Self::Time];

    /// The media type of every figure.
    pub const MEDIA_TYPE: &str = "image/svg+xml";

    /// The name in a path.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deviation => "deviation",
            Self::Time => "time",
        }
    }

    /// The figure of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|figure| figure.name() == name)
    }
}
