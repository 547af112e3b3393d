//! What the queue of a kind, its dispatcher and its jobs share.

use super::job::Job;
use super::record::Record;
use super::work::Work;
use crate::resource::failure::{self, Failure};
use crate::store::{Change, JobId, Keeper};
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};
use tokio::sync::{Mutex, Notify, watch};
use umwelt_lab::evaluator::Evaluator;
use umwelt_lab::pool::Pool;

/// What the dispatcher shares with those who submit, watch and cancel.
pub(super) struct Inner<W: Work> {
    pub(super) jobs: RwLock<BTreeMap<u64, Arc<Job<W>>>>,
    /// The highest number that was ever given; held while one is submitted.
    pub(super) last: Mutex<u64>,
    pub(super) keeper: Keeper,
    pub(super) services: W::Services,
    /// Plans batches and writes down what they leave.
    pub(super) pool: Arc<Pool>,
    /// Drives the episodes.
    pub(super) evaluator: Arc<dyn Evaluator<W>>,
    pub(super) wake: Notify,
    pub(super) closing: watch::Sender<bool>,
    /// Set once the dispatcher has ended.
    pub(super) ended: watch::Sender<bool>,
    pub(super) limits: Limits,
}

/// How many jobs of a kind there may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// How many may wait for their turn.
    pub(crate) queued: usize,
    /// How many that have ended are kept; the last one always is.
    pub(crate) kept: usize,
}

impl<W: Work> Inner<W> {
    pub(super) fn jobs(&self) -> RwLockReadGuard<'_, BTreeMap<u64, Arc<Job<W>>>> {
        self.jobs.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The job whose turn it is: the oldest that has not ended.
    pub(super) fn next(&self) -> Option<Arc<Job<W>>> {
        self.jobs().values().find(|job| !job.state().has_ended()).cloned()
    }

    pub(super) fn close(&self) {
        self.closing.send_replace(true);
        for job in self.jobs().values() {
            job.meter.stop();
        }
    }

    /// The changes that end a job, so that `record` is left of it, and what else goes with them; the oldest that have
    /// ended go where there are too many.
    pub(super) fn ending(
        &self,
        job: &Job<W>,
        record: &Record<W>,
        more: Vec<Change>,
    ) -> Result<Vec<Change>, Failure> {
        let stored = record.stored(job.id()).map_err(unwritable)?;
        let mut changes = vec![Change::PutJob(stored), Change::DeleteCheckpoint(job.id())];
        changes.extend(more);
        changes.extend(self.surplus(job).into_iter().map(Change::DeleteJob));
        Ok(changes)
    }

    /// Shows how a job has ended, and no more those that went for it.
    pub(super) fn show_ended(&self, job: &Job<W>, record: Record<W>) {
        let surplus = self.surplus(job);
        job.show(record);
        surplus.into_iter().for_each(|id| self.remove(id));
    }

    /// Those that have ended and go for `job`, the oldest first. One that has just ended stays, however old it is: a
    /// client waits for it.
    fn surplus(&self, job: &Job<W>) -> Vec<JobId> {
        let jobs = self.jobs();
        let others = jobs.values().filter(|other| other.id() != job.id());
        let ended: Vec<_> =
            others.filter(|other| other.state().has_ended()).map(|other| other.id()).collect();
        let excess = ended.len().saturating_sub(self.limits.kept.max(1) - 1);
        ended[..excess].to_vec()
    }

    pub(super) fn remove(&self, id: JobId) {
        let job = self.jobs.write().unwrap_or_else(PoisonError::into_inner).remove(&id.number);
        if let Some(job) = job {
            job.show_removed();
        }
    }
}

/// What is to be kept cannot be written down.
pub(super) fn unwritable(error: serde_json::Error) -> Failure {
    failure::internal(format!("it cannot be written down: {error}"))
}
