//! Episodes: what is asked, and what came of it.

use umwelt_core::conjugate::SampleStatistics;

/// One episode to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job {
    /// Number of the individual, of the candidate or of who is reported.
    pub(super) subject: usize,
    pub(super) environment: usize,
    pub(super) seed: u64,
}

/// What came of one episode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

/// Evaluations do not belong to the jobs that were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given} evaluations for {asked} jobs")]
pub struct TellError {
    /// How many there were.
    pub given: usize,
    /// How many there should be.
    pub asked: usize,
}
