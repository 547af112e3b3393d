//! How far an evolution has got.

use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What an evolution is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = EvolutionStage)]
pub enum Stage {
    /// It waits for its turn.
    Queued,
    /// A fixed model drives each environment: it sets the unit of fitness.
    Reference,
    /// Generation after generation.
    Generations,
    /// The fittest of the last generation are compared on fresh seeds.
    Selection,
    /// The champion is measured on third seeds.
    Report,
    /// There is a report.
    Done,
}

impl Stage {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Reference => "reference",
            Self::Generations => "generations",
            Self::Selection => "selection",
            Self::Report => "report",
            Self::Done => "done",
        }
    }
}

/// How far an evolution has got.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EvolutionProgress)]
pub struct Progress {
    /// What it is doing; where it has failed or was cancelled, what it was doing then.
    pub stage: Stage,
    /// Generations that have ended.
    pub generation: u64,
    /// Generations in all.
    pub generations: u64,
    /// Fitness of the best individual of the last generation, 1 being that of a fixed model; null before the first.
    pub best_fitness: Option<f64>,
    /// Mean fitness of the last generation; null before the first.
    pub mean_fitness: Option<f64>,
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
