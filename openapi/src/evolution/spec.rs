//! What is asked of an evolution, all filled in, and the limits of it.

use crate::check::Range;
use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Environments, of different names.
pub const ENVIRONMENTS: RangeInclusive<usize> = 1..=32;
/// Individuals of a generation; one alone cannot be crossed.
pub const POPULATION: RangeInclusive<u64> = 2..=1000;
/// Generations; what is kept of each is bounded by it.
pub const GENERATIONS: RangeInclusive<u64> = 1..=1000;
/// Trials of an individual in an environment.
pub const TRIALS: RangeInclusive<u64> = 1..=100;
/// Fresh trials that choose the champion.
pub const SELECTION_TRIALS: RangeInclusive<u64> = 1..=500;
/// Fresh trials on which it is reported; one alone has no interval.
pub const REPORT_TRIALS: RangeInclusive<u64> = 2..=1000;
/// Most episodes of one evolution (population x generations x trials x environments): about a day of one core.
pub const MAX_EPISODES: u64 = 20_000_000;
/// Most episodes of one generation (population x trials x environments): the evaluation of each is held in memory.
pub const MAX_BATCH: u64 = 200_000;
/// Each of the three probabilities.
pub const PROBABILITY: Range = Range::new(0.0, 1.0, "");
/// How far from one the three probabilities may sum: what rounding of decimals leaves.
pub const SUM_TOLERANCE: f64 = 1e-9;
/// From children that lie on the line between their parents to such as lie anywhere.
pub const EXPANSION: Range = Range::new(0.0, 10.0, "");
/// From the noise of a good camera to a floor.
pub const MAX_DEVIATION: Range = Range::new(1e-3, 10.0, "m");
/// From faster than any robot here to ten minutes of each episode.
pub const MAX_TIME: Range = Range::new(1.0, 600.0, "s");

/// What is not said comes from here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = EvolutionPreset)]
pub enum Preset {
    /// Six environments, horizons of twenty slots: for use.
    #[default]
    Default,
    /// The thesis's two environments and tables, one command per reply.
    Thesis,
    /// The thesis's, small enough to watch: some seconds.
    Quick,
}

impl Preset {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Thesis => "thesis",
            Self::Quick => "quick",
        }
    }
}

/// How the prior is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = Optimizer)]
pub enum Optimizer {
    /// The thesis's genetic algorithm.
    Genetic,
    /// Covariance matrix adaptation.
    CmaEs,
    /// The prior under which samples of the same environments are likeliest.
    EmpiricalBayes,
}

impl Optimizer {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Genetic => "genetic",
            Self::CmaEs => "cma-es",
            Self::EmpiricalBayes => "empirical-bayes",
        }
    }
}

/// What an evolution was asked for, all filled in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EvolutionSpec)]
pub struct Spec {
    /// Where individuals are tried.
    pub environments: Vec<String>,
    /// How the prior is searched for.
    pub optimizer: Optimizer,
    /// Individuals of a generation.
    pub population: u64,
    /// Generations.
    pub generations: u64,
    /// Trials of each individual in each environment.
    pub trials: u64,
    /// Fresh trials in each environment of each of those from whom the champion is chosen.
    pub selection_trials: u64,
    /// Fresh trials in each environment on which the champion is reported.
    pub report_trials: u64,
    /// Of everything random.
    pub seed: u64,
    /// Probability that two parents are crossed.
    #[serde(serialize_with = "number::finite")]
    pub crossover_probability: f64,
    /// Probability that an individual is copied.
    #[serde(serialize_with = "number::finite")]
    pub reproduction_probability: f64,
    /// Probability that one is drawn anew.
    #[serde(serialize_with = "number::finite")]
    pub mutation_probability: f64,
    /// How far beyond their parents children may lie.
    #[serde(serialize_with = "number::finite")]
    pub expansion: f64,
    /// The fittest that go on as they are.
    pub elites: u64,
    /// Deviation beyond which an individual has no fitness in a normal environment.
    #[serde(serialize_with = "number::finite")]
    pub max_deviation_m: f64,
    /// Time beyond which an individual has no fitness in a bad environment.
    #[serde(serialize_with = "number::finite")]
    pub max_time_s: f64,
    /// Slots of 30 ms per horizon; 1 is the thesis.
    pub horizon_slots: u64,
    /// The name that the champion is to have as a prior; null where it is not kept as one.
    pub prior: Option<String>,
}
