//! Evolutions: priors searched for in the background, in simulated environments.

mod champion;
mod event;
mod generation;
mod kind;
mod page;
mod progress;
mod request;
mod spec;

pub use crate::estimate::Estimate;
pub use crate::job::State;
pub use champion::{Champion, Entry, EnvironmentResult, Ranking};
pub use event::Kind;
pub use generation::{Generation, GenerationEnvironment};
pub use kind::{Event, Evolution, EvolutionKind, Outcome, Page};
pub use page::{DEFAULT_GENERATIONS_SIZE, GenerationsPage, MAX_GENERATIONS_SIZE};
pub use progress::{Progress, Stage};
pub use request::Request;
pub use spec::{
    ENVIRONMENTS, EXPANSION, GENERATIONS, MAX_BATCH, MAX_DEVIATION, MAX_EPISODES, MAX_TIME,
    Optimizer, POPULATION, PROBABILITY, Preset, REPORT_TRIALS, SELECTION_TRIALS, SUM_TOLERANCE,
    Spec, TRIALS,
};

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Largest body of a request in bytes; a full one has 3 kB.
pub const MAX_BODY: usize = 64 * 1024;

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
