//! Episodes: what is asked, and what is measured in one.

use serde::{Deserialize, Serialize};
use umwelt_core::conjugate::SampleStatistics;
use umwelt_core::settings::{Method, Prior};

/// One episode to drive: with the settings of the evolution all that it takes to drive it anywhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// Number of the individual, of the candidate or of who is reported.
    pub(super) subject: usize,
    /// How the subject drives.
    pub(super) method: Method,
    pub(super) prior: Prior,
    /// Index of the environment in the settings.
    pub(super) environment: usize,
    /// Whether poses are measured without noise.
    pub(super) is_noiseless: bool,
    pub(super) seed: u64,
}

/// What is measured in one episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Whether the robot arrived.
    pub arrived: bool,
    /// Time in s from the end of the calibration to the arrival, or to the time limit.
    pub time: f64,
    /// Largest deviation in m of the true position.
    pub deviation: f64,
    /// The samples of each channel, in the order of [`Channel::ALL`](umwelt_core::identification::estimate::Channel::ALL).
    pub samples: [SampleStatistics; 4],
}

/// Evaluations do not belong to the episodes of the batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given} evaluations for {asked} episodes")]
pub struct TellError {
    /// How many there were.
    pub given: usize,
    /// How many there should be.
    pub asked: usize,
}
