//! A generation and its results.

use crate::number;
use crate::robot;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// A generation in one environment. Each individual counts with its mean over its trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GenerationEnvironment)]
pub struct GenerationEnvironment {
    /// The environment.
    pub environment: String,
    /// Smallest deviation of an individual.
    #[serde(serialize_with = "number::finite")]
    pub best_deviation_m: f64,
    /// Mean deviation.
    #[serde(serialize_with = "number::finite")]
    pub mean_deviation_m: f64,
    /// Shortest time of an individual.
    #[serde(serialize_with = "number::finite")]
    pub best_time_s: f64,
    /// Mean time; an individual that does not arrive counts with the limit.
    #[serde(serialize_with = "number::finite")]
    pub mean_time_s: f64,
    /// Share of the episodes in which the robot arrived, 0 to 1.
    #[serde(serialize_with = "number::finite")]
    pub arrived: f64,
}

/// What came of a generation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Generation)]
pub struct Generation {
    /// Its number, from 0.
    pub index: u64,
    /// Fitness of its best individual, 1 being that of a fixed model.
    #[serde(serialize_with = "number::finite")]
    pub best_fitness: f64,
    /// Mean fitness of its individuals.
    #[serde(serialize_with = "number::finite")]
    pub mean_fitness: f64,
    /// The prior of the best individual.
    pub prior: robot::Prior,
    /// Each environment.
    pub environments: Vec<GenerationEnvironment>,
}
