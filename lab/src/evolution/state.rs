//! How far an evolution has got, as it is stored.

use super::failure::Failure;
use super::genome::Genome;
use super::report::Report;
use super::search::Search;
use super::settings::EvolutionSettings;
use serde::{Deserialize, Serialize};

/// Version of the stored state; a state of another version is not taken up.
pub const STATE_VERSION: u32 = 1;

/// How far an evolution has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Fixed-normal sets the unit of fitness.
    Reference,
    /// The generation of this number is evaluated.
    Generations {
        /// From 0.
        generation: usize,
    },
    /// The candidates are compared.
    Selection,
    /// The champion is measured.
    Report,
    /// There is a report.
    Done,
}

/// How far an evolution has got: what is stored between two `tell`s, beside its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub(super) version: u32,
    pub(super) stage: Stage,
    pub(super) search: Search,
    /// What fixed-normal's fitness is in each environment; empty before it is known.
    pub(super) units: Vec<f64>,
    pub(super) first_generation: Option<Genome>,
    pub(super) candidates: Vec<Genome>,
    pub(super) champion: Option<Genome>,
    pub(super) report: Option<Report>,
    pub(super) episodes: u64,
    /// Episodes of the reference and the generations in which the robot arrived; none where an older program began it.
    #[serde(default)]
    pub(super) arrivals: Option<u64>,
    #[serde(default, rename = "hopeless")]
    pub(super) failure: Option<Failure>,
}

impl State {
    /// That of an evolution that has not begun.
    pub(super) fn new(settings: &EvolutionSettings) -> Self {
        Self {
            version: STATE_VERSION,
            stage: Stage::Reference,
            search: Search::new(settings),
            units: Vec::new(),
            first_generation: None,
            candidates: Vec::new(),
            champion: None,
            report: None,
            episodes: 0,
            arrivals: Some(0),
            failure: None,
        }
    }
}
