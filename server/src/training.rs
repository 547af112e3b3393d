//! Simulated environments by name: those that come with the program, and those that are kept.
//!
//! Invariants: what is shown is kept; an evolution takes the environments as they are when it is submitted, so that
//! they may change or go behind it.

use crate::etag;
use crate::store::StoredEnvironment;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Bound;
use std::sync::{Arc, PoisonError, RwLock};
use tokio::sync::{Mutex, OwnedMutexGuard};
use umwelt_api::training::{self, Environment, Spec};
use umwelt_api::{EnvironmentId, Known};
use umwelt_core::evolution::{ENVIRONMENTS, TrainingEnvironment};

/// Most environments that are kept: with the longest traces some 50 MB.
pub(crate) const MAX_ENVIRONMENTS: usize = 200;

/// Version of the stored form.
const VERSION: u32 = 1;

/// An environment, whose name it holds, and what somebody wrote about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    pub(crate) id: EnvironmentId,
    pub(crate) environment: TrainingEnvironment,
    pub(crate) note: Option<String>,
    pub(crate) built_in: bool,
}

/// The stored form.
#[derive(Serialize, Deserialize)]
struct Body {
    version: u32,
    environment: TrainingEnvironment,
    note: Option<String>,
}

impl Named {
    fn spec(&self) -> Spec {
        Spec { note: self.note.clone(), ..Spec::from(&self.environment) }
    }

    /// Version of what was put.
    pub(crate) fn etag(&self) -> Arc<str> {
        etag::of(&self.spec())
    }

    /// As the wire has it.
    pub(crate) fn shown(&self) -> Environment {
        Environment::new(self.id.clone(), self.spec(), self.built_in, &*self.etag())
    }

    /// As it is kept.
    pub(crate) fn stored(&self) -> Result<StoredEnvironment, serde_json::Error> {
        let (environment, note) = (self.environment.clone(), self.note.clone());
        let body = serde_json::to_string(&Body { version: VERSION, environment, note })?;
        Ok(StoredEnvironment { name: self.id.to_string(), body })
    }

    fn of_stored(stored: &StoredEnvironment) -> Result<Self, String> {
        let body: Body = serde_json::from_str(&stored.body).map_err(|error| error.to_string())?;
        let Body { version, environment, note } = body;
        if version != VERSION {
            return Err(format!("it is of version {version}, this program knows {VERSION}"));
        }
        let id = stored.name.parse().map_err(|error| format!("{error}"))?;
        Ok(Self { id, environment, note, built_in: false })
    }
}

/// All simulated environments; cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Environments(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    kept: RwLock<BTreeMap<EnvironmentId, Named>>,
    changing: Arc<Mutex<()>>,
}

impl Environments {
    /// With those that are kept.
    pub(crate) fn open(stored: &[StoredEnvironment]) -> Self {
        let mut kept = BTreeMap::new();
        for stored in stored {
            match Named::of_stored(stored) {
                Ok(named) => drop(kept.insert(named.id.clone(), named)),
                Err(error) => {
                    tracing::error!(environment = stored.name, error, "it cannot be read");
                }
            }
        }
        Self(Arc::new(Inner { kept: RwLock::new(kept), ..Inner::default() }))
    }

    /// Nobody else changes one until the guard is dropped.
    pub(crate) async fn changing(&self) -> OwnedMutexGuard<()> {
        Arc::clone(&self.0.changing).lock_owned().await
    }

    /// What a name stands for.
    pub(crate) fn known(&self, name: &str) -> Known<TrainingEnvironment> {
        let kept = self.0.kept.read().unwrap_or_else(PoisonError::into_inner);
        training::built_in(name).or_else(|mut names| {
            let found = kept.get(name).map(|named| named.environment.clone());
            found.ok_or_else(|| {
                names.extend(kept.keys().map(ToString::to_string));
                names
            })
        })
    }

    /// The environment of this name.
    pub(crate) fn find(&self, id: &EnvironmentId) -> Option<Named> {
        let kept = self.0.kept.read().unwrap_or_else(PoisonError::into_inner);
        built_in(id).or_else(|| kept.get(id).cloned())
    }

    /// Those with names above `after`, in the order of their names, at most `limit`.
    pub(crate) fn above(&self, after: Option<&EnvironmentId>, limit: usize) -> Vec<Named> {
        let from = after.map_or(Bound::Unbounded, Bound::Excluded);
        let kept = self.0.kept.read().unwrap_or_else(PoisonError::into_inner);
        let kept = kept.range::<EnvironmentId, _>((from, Bound::Unbounded)).take(limit);
        let ids = ENVIRONMENTS.iter().filter_map(|name| name.parse().ok());
        let ids = ids.filter(|id| after.is_none_or(|after| id > after));
        let built_in = ids.filter_map(|id| built_in(&id));
        let mut all: Vec<_> = kept.map(|(_, named)| named.clone()).chain(built_in).collect();
        all.sort_by(|one, other| one.id.cmp(&other.id));
        all.truncate(limit);
        all
    }

    /// How many are kept.
    pub(crate) fn len(&self) -> usize {
        self.0.kept.read().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Shows an environment that is kept now.
    pub(crate) fn insert(&self, named: Named) {
        let mut kept = self.0.kept.write().unwrap_or_else(PoisonError::into_inner);
        kept.insert(named.id.clone(), named);
    }

    /// Shows one no more that is not kept any more.
    pub(crate) fn remove(&self, id: &EnvironmentId) {
        self.0.kept.write().unwrap_or_else(PoisonError::into_inner).remove(id);
    }
}

fn built_in(id: &EnvironmentId) -> Option<Named> {
    let environment = TrainingEnvironment::preset(id.as_str())?;
    Some(Named { id: id.clone(), environment, note: None, built_in: true })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_and_what_cannot_be_read_is_left_out() {
        let id: EnvironmentId = "wet-hall".parse().unwrap();
        let spec = Spec::read(br#"{"slip": "oily", "link": "bad", "note": "n"}"#).unwrap();
        let environment = spec.to_core(&id).unwrap();
        let named = Named { id, environment, note: spec.note, built_in: false };
        let stored = named.stored().unwrap();
        assert_eq!(Named::of_stored(&stored), Ok(named.clone()));
        let later = StoredEnvironment {
            name: "later".to_owned(),
            body: stored.body.replace("\"version\":1", "\"version\":2"),
        };
        let broken = StoredEnvironment { name: "broken".to_owned(), body: "{".to_owned() };
        let environments = Environments::open(&[later, broken, stored]);
        assert_eq!(environments.len(), 1);
        assert_eq!(environments.find(&named.id), Some(named));
        assert!(environments.known("lava").unwrap_err().contains(&"wet-hall".to_owned()));
    }
}
