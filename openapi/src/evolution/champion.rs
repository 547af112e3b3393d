//! What an evolution found, and what it is worth beside what was there before. The words are made in `umwelt-lab`.

use crate::estimate::Estimate;
use crate::number;
use crate::robot;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// A prior in one environment, on the seeds of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentResult)]
pub struct EnvironmentResult {
    /// The environment.
    pub environment: String,
    /// Fitness, 1 being that of a fixed model.
    pub fitness: Estimate,
    /// Mean time from the end of the calibration to the arrival; the limit where there was none.
    #[serde(serialize_with = "number::finite")]
    pub time_s: f64,
    /// Mean of the largest deviations.
    #[serde(serialize_with = "number::finite")]
    pub deviation_m: f64,
    /// Share of the trials in which the robot arrived, 0 to 1.
    #[serde(serialize_with = "number::finite")]
    pub arrived: f64,
}

/// One prior on the seeds of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EvolutionEntry)]
pub struct Entry {
    /// `champion`, `first-generation` (the best of it), `default` or `flat`; expect others.
    pub name: String,
    /// The prior.
    pub prior: robot::Prior,
    /// Its fitness: the weighted mean over the environments.
    pub fitness: Estimate,
    /// The champion's fitness minus this one's, paired by seed; null for the champion itself.
    pub difference: Option<Estimate>,
    /// Each environment alone.
    pub environments: Vec<EnvironmentResult>,
    /// What the difference says, in plain words; says so where the interval includes zero, and where the champion is
    /// worse in a single environment.
    pub verdict: String,
    /// What the difference says of the champion; null for the champion itself.
    #[serde(default)]
    pub champion_is: Option<Ranking>,
    /// Environments in which the champion is worse than this one, whatever the mean over all of them says: those in which
    /// the two intervals are apart.
    #[serde(default)]
    pub champion_worse_in: Vec<String>,
}

/// What a difference says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = Ranking)]
pub enum Ranking {
    /// It is better.
    Better,
    /// It is worse.
    Worse,
    /// The interval includes zero: no difference is shown.
    NoDifference,
}

/// What an evolution found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Champion)]
pub struct Champion {
    /// The champion's prior.
    pub prior: robot::Prior,
    /// Fresh trials in each environment behind every number here.
    pub trials: u64,
    /// The champion first, then what it has to beat.
    pub entries: Vec<Entry>,
    /// What one should know before one uses it, in plain words: environments in which no one arrives.
    #[serde(default)]
    pub notes: Vec<String>,
}
