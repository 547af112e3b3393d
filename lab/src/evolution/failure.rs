//! When an evolution cannot give a prior: its environments cannot be driven, or not within its limits.
//!
//! Where no individual has any fitness there is nothing to select by: a champion would be drawn at random.

use super::environment::TrainingEnvironment;
use serde::{Deserialize, Serialize};

/// Generations without any arrival after which an evolution gives up. Each is drawn as blindly as the one before,
/// so that a fourth would find nothing that three and the reference have not found.
pub const GENERATIONS_WITHOUT_ARRIVAL: usize = 3;

/// Why an evolution gives no prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "kebab-case")]
pub enum Failure {
    /// No robot has arrived in any episode so far.
    #[error(
        "nobody arrives in {environments}: in none of {episodes} episodes, by the fixed model and by every individual so \
         far, did a robot reach the last waypoint in time, so there is nothing to select by; use environments that can be \
         driven: a shorter round trip, fewer late packets and outages, less slip"
    )]
    NobodyArrives {
        /// Names of the environments, with commas.
        environments: String,
        /// Episodes driven.
        episodes: u64,
    },
    /// The champion has no fitness in any trial of the report.
    #[error(
        "the champion is of no use in {environments}: it arrived in {} % of {trials} fresh trials and kept the limits of \
         time and deviation in none; allow more time or a larger deviation, more individuals or generations, or easier \
         environments",
        (100.0 * arrived).round()
    )]
    ChampionFails {
        /// Names of the environments, with commas.
        environments: String,
        /// Trials over all environments.
        trials: usize,
        /// Share of them in which the robot arrived.
        arrived: f64,
    },
}

/// The names of `environments` in one line.
pub(super) fn names(environments: &[TrainingEnvironment]) -> String {
    environments.iter().map(|it| it.name.as_str()).collect::<Vec<_>>().join(", ")
}
