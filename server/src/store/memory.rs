//! A store that lasts as long as the process.

use super::{
    Change, Contents, JobId, Part, Posterior, Record, Store, StoreError, StoredEnvironment,
    StoredJob, StoredKind, StoredPrior, StoredRobot,
};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use umwelt_api::RobotId;

/// Keeps everything as long as the process lives.
#[derive(Debug, Default)]
pub struct MemoryStore(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    robots: BTreeMap<RobotId, (Record, Option<Posterior>)>,
    priors: BTreeMap<String, StoredPrior>,
    environments: BTreeMap<String, StoredEnvironment>,
    jobs: BTreeMap<JobId, Job>,
    last_numbers: BTreeMap<StoredKind, u64>,
}

#[derive(Debug)]
struct Job {
    stored: StoredJob,
    parts: BTreeMap<usize, String>,
    checkpoint: Option<String>,
}

impl MemoryStore {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        // No call panics between two changes, so what is behind a poisoned lock is whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for MemoryStore {
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError> {
        let mut kept = self.kept();
        changes.into_iter().for_each(|change| kept.apply(change));
        Ok(())
    }

    fn load(&self) -> Result<Contents, StoreError> {
        let kept = self.kept();
        let robot = |(id, (record, posterior)): (&RobotId, &(Record, Option<Posterior>))| {
            let saved = posterior.as_ref().map(|posterior| posterior.saved.clone());
            StoredRobot { id: id.clone(), record: record.clone(), saved }
        };
        Ok(Contents {
            robots: kept.robots.iter().map(robot).collect(),
            priors: kept.priors.values().cloned().collect(),
            environments: kept.environments.values().cloned().collect(),
            // A kind has its place in the order of ids, and so has a number.
            jobs: kept.jobs.values().map(|job| job.stored.clone()).collect(),
            // They are held as they are.
            unreadable: Vec::new(),
            last_numbers: kept.last_numbers.clone(),
        })
    }

    fn parts(&self, job: JobId, from: usize, limit: usize) -> Result<Vec<Part>, StoreError> {
        let kept = self.kept();
        let parts = kept.jobs.get(&job).into_iter().flat_map(|job| job.parts.range(from..));
        let part = |(&index, body): (&usize, &String)| Part { index, body: body.clone() };
        Ok(parts.take(limit).map(part).collect())
    }

    fn checkpoint(&self, job: JobId) -> Result<Option<String>, StoreError> {
        Ok(self.kept().jobs.get(&job).and_then(|job| job.checkpoint.clone()))
    }
}

impl Kept {
    fn apply(&mut self, change: Change) {
        match change {
            Change::PutRobot(id, record) => {
                let old = self.robots.remove(&id).and_then(|(_, posterior)| posterior);
                let posterior = old.filter(|posterior| posterior.revision == record.revision);
                self.robots.insert(id, (*record, posterior));
            }
            Change::DeleteRobot(id) => drop(self.robots.remove(&id)),
            Change::PutPosterior(id, posterior) => {
                if let Some((record, kept)) = self.robots.get_mut(&id)
                    && record.revision == posterior.revision
                {
                    *kept = Some(*posterior);
                }
            }
            Change::PutPrior(prior) => drop(self.priors.insert(prior.name.clone(), prior)),
            Change::DeletePrior(name) => drop(self.priors.remove(&name)),
            Change::PutEnvironment(environment) => {
                self.environments.insert(environment.name.clone(), environment);
            }
            Change::DeleteEnvironment(name) => drop(self.environments.remove(&name)),
            Change::PutJob(stored) => {
                let JobId { kind, number } = stored.id;
                let last = self.last_numbers.entry(kind).or_default();
                *last = number.max(*last);
                match self.jobs.get_mut(&stored.id) {
                    Some(job) => job.stored = stored,
                    None => {
                        let (id, parts, checkpoint) = (stored.id, BTreeMap::new(), None);
                        self.jobs.insert(id, Job { stored, parts, checkpoint });
                    }
                }
            }
            Change::DeleteJob(id) => drop(self.jobs.remove(&id)),
            Change::PutPart { job, index, body } => {
                if let Some(job) = self.jobs.get_mut(&job) {
                    job.parts.insert(index, body);
                }
            }
            Change::PutCheckpoint { job, body } => {
                if let Some(job) = self.jobs.get_mut(&job) {
                    job.checkpoint = Some(body);
                }
            }
            Change::DeleteCheckpoint(job) => {
                if let Some(job) = self.jobs.get_mut(&job) {
                    job.checkpoint = None;
                }
            }
        }
    }
}
