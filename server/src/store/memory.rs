//! A store that lasts as long as the process.

use super::{
    Change, Contents, Generation, Posterior, Record, Store, StoreError, StoredEnvironment,
    StoredEvolution, StoredPrior, StoredRobot,
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
    evolutions: BTreeMap<String, Evolution>,
    last_evolution: u64,
}

#[derive(Debug)]
struct Evolution {
    stored: StoredEvolution,
    generations: BTreeMap<usize, String>,
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
        let evolutions = kept.evolutions.values().map(|evolution| evolution.stored.clone());
        let mut evolutions: Vec<_> = evolutions.collect();
        evolutions.sort_by_key(|evolution| evolution.number);
        Ok(Contents {
            robots: kept.robots.iter().map(robot).collect(),
            priors: kept.priors.values().cloned().collect(),
            environments: kept.environments.values().cloned().collect(),
            evolutions,
            last_evolution: kept.last_evolution,
        })
    }

    fn generations(
        &self,
        evolution: &str,
        from: usize,
        limit: usize,
    ) -> Result<Vec<Generation>, StoreError> {
        let kept = self.kept();
        let generations = kept.evolutions.get(evolution).map(|evolution| &evolution.generations);
        let generations = generations.into_iter().flat_map(|generations| generations.range(from..));
        let generation =
            |(&index, body): (&usize, &String)| Generation { index, body: body.clone() };
        Ok(generations.take(limit).map(generation).collect())
    }

    fn checkpoint(&self, evolution: &str) -> Result<Option<String>, StoreError> {
        let kept = self.kept();
        Ok(kept.evolutions.get(evolution).and_then(|evolution| evolution.checkpoint.clone()))
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
            Change::PutEvolution(stored) => {
                self.last_evolution = self.last_evolution.max(stored.number);
                let id = stored.id.clone();
                match self.evolutions.get_mut(&id) {
                    Some(evolution) => evolution.stored = stored,
                    None => {
                        let (generations, checkpoint) = (BTreeMap::new(), None);
                        self.evolutions.insert(id, Evolution { stored, generations, checkpoint });
                    }
                }
            }
            Change::DeleteEvolution(id) => drop(self.evolutions.remove(&id)),
            Change::PutGeneration { evolution, index, body } => {
                if let Some(evolution) = self.evolutions.get_mut(&evolution) {
                    evolution.generations.insert(index, body);
                }
            }
            Change::PutCheckpoint { evolution, body } => {
                if let Some(evolution) = self.evolutions.get_mut(&evolution) {
                    evolution.checkpoint = Some(body);
                }
            }
            Change::DeleteCheckpoint(id) => {
                if let Some(evolution) = self.evolutions.get_mut(&id) {
                    evolution.checkpoint = None;
                }
            }
        }
    }
}
