//! Who evaluates the episodes of jobs: the threads of this process ([`crate::pool`]), or workers in other processes.
//!
//! Invariant: an evaluation is a function of the settings of the job and of its episode ([`Work::evaluate`]), so any
//! evaluator gives the same evaluations for a batch, in whatever order and however often, bit for bit.

use crate::work::Work;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Evaluates the episodes of one kind of job. The pool is one implementation.
///
/// A worker in another process needs what a [`Batch`] has and no more: it is sent the settings, as the specs in which the
/// server keeps them, with the first batch of a job, and keeps them under the job's id; episodes and evaluations are
/// serialisable; job and index name a batch, so that one that was sent twice is evaluated once. An evaluator runs at the
/// priority with which it was made; a job that is cancelled, or whose server ends, is one whose [`Meter`] is stopped.
pub trait Evaluator<W: Work>: Send + Sync {
    /// The evaluations of `batch`, in the order of its episodes. Blocks until they are there; counts them in `meter` as
    /// they come, and ends early once that is stopped.
    ///
    /// # Errors
    /// Where it was stopped, or an evaluation failed.
    fn evaluate(&self, batch: &Batch<'_, W>, meter: &Meter) -> Result<Vec<W::Evaluation>, Halt>;
}

/// Some episodes of a job.
#[derive(Debug)]
pub struct Batch<'a, W: Work> {
    /// Id of the job: no other job of the evaluator has it.
    pub job: &'a str,
    /// The settings of the job, the same for all its batches.
    pub settings: &'a W::Settings,
    /// Episodes of the job before this batch: the same batch has the same index after a restart.
    pub index: u64,
    /// What is to be driven.
    pub episodes: &'a [W::Episode],
}

/// How far a batch has got, and whether it is to go on: shared between who evaluates and who watches.
#[derive(Debug, Default)]
pub struct Meter {
    episodes: AtomicU64,
    stopped: AtomicBool,
}

impl Meter {
    /// Episodes that the job has driven, those of the batch that is going on included.
    pub fn episodes(&self) -> u64 {
        self.episodes.load(Ordering::Relaxed)
    }

    /// Counts episodes of the batch that is going on.
    pub fn add(&self, episodes: u64) {
        self.episodes.fetch_add(episodes, Ordering::Relaxed);
    }

    /// Ends the batch as soon as the episodes that are being driven have ended.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Whether the batch is to end.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Begins a batch of a job that has driven so many episodes.
    pub(crate) fn begin(&self, episodes: u64) {
        self.episodes.store(episodes, Ordering::Relaxed);
    }
}

/// Why a batch did not come to its end.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum Halt {
    /// It was stopped; the job is as it was before the batch.
    #[error("it was stopped")]
    Stopped,
    /// An evaluation panicked.
    #[error("an evaluation failed: {0}")]
    Panicked(String),
    /// The evaluations were not those of the batch.
    #[error("{0}")]
    Refused(String),
}
