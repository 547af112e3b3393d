//! Simulated environments by name: those that come with the program, and those that are kept.
//!
//! Invariants: what is shown is kept; an evolution takes the environments as they are when it is submitted, so that
//! they may change or go behind it.

use crate::library::catalogue::{self, Catalogue};
use crate::resource::etag;
use crate::store::document::environment as document;
use crate::store::{Kind, StoredEnvironment, Unreadable, Unreadables};
use std::sync::Arc;
use tokio::sync::{Mutex, OwnedMutexGuard};
use umwelt_api::training::{Environment, Spec};
use umwelt_api::{EnvironmentId, Known};
use umwelt_lab::evolution::{ENVIRONMENTS, TrainingEnvironment};
use umwelt_lab::wire;

/// Most environments that are kept: with the longest traces some 50 MB.
pub(crate) const MAX_ENVIRONMENTS: usize = 200;

/// An environment, whose name it holds, and what someone wrote about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    pub(crate) id: EnvironmentId,
    pub(crate) environment: TrainingEnvironment,
    pub(crate) note: Option<String>,
    pub(crate) built_in: bool,
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
        let spec = document::of_environment(&self.environment, self.note.clone());
        Ok(StoredEnvironment { name: self.id.to_string(), body: document::FORM.write(&spec)? })
    }

    fn of_stored(stored: &StoredEnvironment) -> Result<Self, Unreadable> {
        let name = &stored.name;
        let unreadable = |why: &_| Unreadable::new(Kind::Environment, name.as_str(), why);
        let read = document::FORM.read_with(&stored.body, |content| {
            let spec: Spec = serde_json::from_value(content).map_err(|error| error.to_string())?;
            let id: EnvironmentId = name.parse().map_err(|error| format!("{error}"))?;
            let environment = document::environment(name.clone(), &spec)?;
            Ok::<_, String>(Self { id, environment, note: spec.note, built_in: false })
        });
        read.map_err(|why| unreadable(&why))
    }
}

/// All simulated environments; cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Environments(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    all: Catalogue<Named>,
    changing: Arc<Mutex<()>>,
}

impl Environments {
    /// With those that are kept; what cannot be read is noted.
    pub(crate) fn open(stored: &[StoredEnvironment], unreadable: &Unreadables) -> Self {
        let note = |why| unreadable.add(why);
        let read = stored.iter().filter_map(|it| Named::of_stored(it).map_err(note).ok());
        Self(Arc::new(Inner { all: read.collect(), ..Inner::default() }))
    }

    /// All of them by their names.
    pub(crate) fn all(&self) -> &Catalogue<Named> {
        &self.0.all
    }

    /// No one else changes one until the guard is dropped.
    pub(crate) async fn changing(&self) -> OwnedMutexGuard<()> {
        Arc::clone(&self.0.changing).lock_owned().await
    }

    /// What a name stands for.
    pub(crate) fn known(&self, name: &str) -> Known<TrainingEnvironment> {
        let kept = self.0.all.kept();
        wire::training::built_in(name).or_else(|mut names| {
            let found = kept.get(name).map(|named| named.environment.clone());
            found.ok_or_else(|| {
                names.extend(kept.keys().map(ToString::to_string));
                names
            })
        })
    }
}

impl catalogue::Named for Named {
    type Id = EnvironmentId;
    const BUILT_IN: &'static [&'static str] = &ENVIRONMENTS;

    fn id(&self) -> &EnvironmentId {
        &self.id
    }

    fn built_in(id: &EnvironmentId) -> Option<Self> {
        let environment = TrainingEnvironment::preset(id.as_str())?;
        Some(Self { id: id.clone(), environment, note: None, built_in: true })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_and_what_cannot_be_read_is_noted() {
        let id: EnvironmentId = "wet-hall".parse().unwrap();
        let spec = Spec::read(br#"{"slip": "oily", "link": "bad", "note": "n"}"#).unwrap();
        let environment = wire::training::environment(&spec, &id);
        let named = Named { id, environment, note: spec.into_inner().note, built_in: false };
        let stored = named.stored().unwrap();
        assert_eq!(Named::of_stored(&stored), Ok(named.clone()));
        let later = StoredEnvironment {
            name: "later".to_owned(),
            body: stored.body.replace("\"version\":2", "\"version\":3"),
        };
        let broken = StoredEnvironment { name: "broken".to_owned(), body: "{".to_owned() };
        let unreadable = Unreadables::default();
        let environments = Environments::open(&[later, broken, stored], &unreadable);
        assert_eq!(environments.all().len(), 1);
        let names = unreadable.page(Kind::Environment, |_| true).into_iter().map(|it| it.name);
        assert_eq!(names.collect::<Vec<_>>(), ["broken", "later"]);
        assert_eq!(environments.all().find(&named.id), Some(named));
        assert!(environments.known("lava").unwrap_err().contains(&"wet-hall".to_owned()));
    }
}
