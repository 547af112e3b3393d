//! What is kept and cannot be read: a newer program wrote it. It keeps its place, is shown as unreadable and is touched by
//! no one but those who put another in its place or remove it.

use super::document;
use super::job_id::StoredKind;
use crate::resource::failure::Failure;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};
use umwelt_api::problem::{Detail, Status, reason};

/// What things with names or ids there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Robot,
    Prior,
    Environment,
    Job(StoredKind),
}

impl Kind {
    /// In the singular, as paths have it in the plural.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Prior => "prior",
            Self::Environment => "environment",
            Self::Job(kind) => kind.name(),
        }
    }
}

/// Something that is kept and cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    pub(crate) kind: Kind,
    /// Its name or id.
    pub(crate) name: String,
    /// The version of the program that wrote it; none where that does not say.
    pub(crate) written_by: Option<String>,
    /// Why it cannot be read.
    pub(crate) why: String,
    /// That of a robot's record; 0 for others.
    pub(crate) revision: u64,
}

impl Unreadable {
    pub(crate) fn new(kind: Kind, name: impl Into<String>, why: &document::Unreadable) -> Self {
        let written_by = why.written_by().map(str::to_owned);
        Self { kind, name: name.into(), written_by, why: why.to_string(), revision: 0 }
    }

    /// What it is and who wrote it, for people.
    fn said(&self) -> String {
        let Self { kind, name, written_by, why, .. } = self;
        let by =
            written_by.as_ref().map_or_else(String::new, |it| format!(", written by version {it}"));
        format!("{} {name} cannot be read{by}: {why}", kind.name())
    }

    /// What to do about it.
    fn remedy(&self) -> String {
        let Self { kind, name, .. } = self;
        let kind = kind.name();
        format!(
            "start a server of the version that wrote it, or give it up: DELETE /v1/{kind}s/{name}"
        )
    }

    /// What someone is told who asks for it.
    fn failure(&self) -> Failure {
        let (kind, name) = (self.kind.name(), self.name.as_str());
        let detail = Detail::new(reason::UNREADABLE, kind, name, self.remedy());
        Failure::new(Status::FailedPrecondition, self.said()).with(detail)
    }

    /// As the wire has it.
    fn shown(&self) -> umwelt_api::page::Unreadable {
        umwelt_api::page::Unreadable {
            name: self.name.clone(),
            written_by: self.written_by.clone(),
            why: self.why.clone(),
            remedy: self.remedy(),
        }
    }
}

/// All that cannot be read; cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unreadables(Arc<RwLock<BTreeMap<(Kind, String), Unreadable>>>);

impl Unreadables {
    fn all(&self) -> RwLockReadGuard<'_, BTreeMap<(Kind, String), Unreadable>> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes one more, and says so in the log.
    pub(crate) fn add(&self, unreadable: Unreadable) {
        let Unreadable { kind, name, why, written_by, .. } = &unreadable;
        let remedy = unreadable.remedy();
        tracing::error!(
            kind = kind.name(),
            name,
            why,
            written_by,
            remedy,
            "a stored thing cannot be read and stays as it is"
        );
        let key = (*kind, name.clone());
        self.0.write().unwrap_or_else(PoisonError::into_inner).insert(key, unreadable);
    }

    /// Whether there is one of this name.
    pub(crate) fn has(&self, kind: Kind, name: &str) -> bool {
        self.all().contains_key(&(kind, name.to_owned()))
    }

    /// What someone is told who asks for this one, where it is one of these.
    pub(crate) fn failure(&self, kind: Kind, name: &str) -> Option<Failure> {
        self.all().get(&(kind, name.to_owned())).map(Unreadable::failure)
    }

    /// The revisions of records of robots.
    pub(crate) fn revisions(&self) -> Vec<u64> {
        self.all().values().map(|unreadable| unreadable.revision).collect()
    }

    /// Another is in its place now, or it is removed.
    pub(crate) fn remove(&self, kind: Kind, name: &str) {
        let key = (kind, name.to_owned());
        self.0.write().unwrap_or_else(PoisonError::into_inner).remove(&key);
    }

    /// Those of a kind whose names `is_listed`, as the wire has them.
    pub(crate) fn page(
        &self,
        kind: Kind,
        is_listed: impl Fn(&str) -> bool,
    ) -> Vec<umwelt_api::page::Unreadable> {
        let all = self.all();
        let of_kind = all.values().filter(|it| it.kind == kind && is_listed(&it.name));
        of_kind.map(Unreadable::shown).collect()
    }
}
