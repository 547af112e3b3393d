//! Episodes: what is asked, and what is kept of one.

use super::coverage::Coverage;
use super::signature::EnvironmentSignature;
use serde::{Deserialize, Serialize};
use umwelt_core::conjugate::SampleStatistics;

/// One episode to drive: with the settings of the comparison all that it takes to drive it anywhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    pub(super) driver: Driver,
    /// Index of the environment in the settings.
    pub(super) environment: usize,
    pub(super) seed: u64,
    /// How each environment shows in the samples; empty where the driver is not to recognise them.
    pub(super) known: Vec<EnvironmentSignature>,
}

/// Who drives an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Driver {
    /// The baseline with so many slots, whose samples show what an environment is like.
    Reference { slots: usize },
    /// The contender of this index in the settings.
    Contender { index: usize },
}

/// What is kept of one episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Whether the robot arrived within the time limit.
    pub arrived: bool,
    /// Time in s from the end of the calibration to the arrival; the time limit where it did not arrive.
    pub time: f64,
    /// Largest deviation in m of the true position.
    pub deviation: f64,
    /// Samples after which the environment that the robot was in is the one it believed in for good; none where that
    /// never came, or is not asked.
    pub recognised: Option<u64>,
    /// How well its intervals held what came; none where it does not identify.
    pub coverage: Option<Coverage>,
}

/// What is measured in one episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// What is kept.
    pub trial: Trial,
    /// The samples of each channel.
    pub(super) samples: [SampleStatistics; 4],
}

/// Every trial of a contender in an environment, in the order of the seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// The environment.
    pub environment: String,
    /// The contender's label.
    pub contender: String,
    /// Its trials.
    pub trials: Vec<Trial>,
}
