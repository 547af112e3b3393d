//! Named priors: those that come with the program, and those that are kept.
//!
//! Invariants: what is shown is kept; a name that robots use means the same prior for as long as they use it, so giving
//! a robot a prior ([`Priors::giving`]) and changing priors ([`Priors::changing`]) exclude each other.

use crate::library::catalogue::{self, Catalogue};
use crate::resource::etag;
use crate::store::{Kind, StoredPrior, Unreadables};
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::{OwnedRwLockReadGuard, OwnedRwLockWriteGuard};
use umwelt_api::prior::{self, Source, Spec};
use umwelt_api::{Known, PriorId, RobotId};
use umwelt_core::identification::{BUILT_IN_PRIORS, about_built_in};
use umwelt_core::settings::Prior;

/// Most priors that are kept, about 2 kB each.
pub(crate) const MAX_PRIORS: usize = 10_000;

/// A prior with its name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    pub(crate) id: PriorId,
    pub(crate) prior: Prior,
    pub(crate) note: Option<String>,
    pub(crate) source: Source,
}

impl Named {
    /// What one would put to have it.
    fn spec(&self) -> Spec {
        let values = umwelt_api::robot::Prior::from(self.prior);
        Spec { note: self.note.clone(), ..values.into() }
    }

    /// Version of values and note.
    pub(crate) fn etag(&self) -> Arc<str> {
        etag::of(&self.spec())
    }

    /// As the wire has it, with the robots that use it.
    pub(crate) fn shown(&self, users: &Users) -> prior::Prior {
        let robots = users.of(&self.id).iter().cloned();
        prior::Prior::new(self.id.clone(), self.spec(), self.source.clone(), &*self.etag())
            .used_by(robots)
    }

    fn of_stored(stored: StoredPrior) -> Option<Self> {
        let StoredPrior { name, prior, note, source } = stored;
        Some(Self { id: name.parse().ok()?, prior, note, source })
    }

    /// As it is kept; none where it comes with the program.
    pub(crate) fn stored(&self) -> Option<StoredPrior> {
        if matches!(self.source, Source::BuiltIn | Source::Inline) {
            return None;
        }
        let Self { id, prior, note, source } = self.clone();
        Some(StoredPrior { name: id.to_string(), prior, note, source })
    }
}

/// Which robots use which prior, at one moment.
#[derive(Debug, Default)]
pub(crate) struct Users(BTreeMap<String, Vec<RobotId>>);

impl Users {
    /// Those that use this one.
    pub(crate) fn of(&self, prior: &PriorId) -> &[RobotId] {
        self.0.get(prior.as_str()).map(Vec::as_slice).unwrap_or_default()
    }
}

impl FromIterator<(String, RobotId)> for Users {
    /// Robots with the names of their priors, in the order in which they come.
    fn from_iter<I: IntoIterator<Item = (String, RobotId)>>(robots: I) -> Self {
        let mut users = Self::default();
        for (prior, robot) in robots {
            users.0.entry(prior).or_default().push(robot);
        }
        users
    }
}

/// All priors; cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Priors(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    all: Catalogue<Named>,
    unreadable: Unreadables,
    names: Arc<tokio::sync::RwLock<()>>,
}

impl Priors {
    /// With those that are kept.
    pub(crate) fn open(stored: Vec<StoredPrior>, unreadable: Unreadables) -> Self {
        let all = stored.into_iter().filter_map(Named::of_stored).collect();
        Self(Arc::new(Inner { all, unreadable, ..Inner::default() }))
    }

    /// Whether there is a prior of this name, if only one that cannot be read.
    pub(crate) fn has(&self, name: &PriorId) -> bool {
        self.0.all.find(name).is_some() || self.0.unreadable.has(Kind::Prior, name.as_str())
    }

    /// All of them by their names.
    pub(crate) fn all(&self) -> &Catalogue<Named> {
        &self.0.all
    }

    /// Names mean what they mean until the guard is dropped. Many may hold one.
    pub(crate) async fn giving(&self) -> OwnedRwLockReadGuard<()> {
        Arc::clone(&self.0.names).read_owned().await
    }

    /// No one else changes what names mean, or goes by it, until the guard is dropped.
    pub(crate) async fn changing(&self) -> OwnedRwLockWriteGuard<()> {
        Arc::clone(&self.0.names).write_owned().await
    }

    /// What a name stands for.
    pub(crate) fn known(&self, name: &str) -> Known<Prior> {
        let kept = self.0.all.kept();
        if let Some(prior) = Prior::built_in(name).or_else(|| kept.get(name).map(|it| it.prior)) {
            return Ok(prior);
        }
        let built_in = BUILT_IN_PRIORS.into_iter().map(str::to_owned);
        Err(built_in.chain(kept.keys().map(ToString::to_string)).collect())
    }

    /// Where the prior of a robot comes from.
    pub(crate) fn source(&self, name: Option<&str>) -> Source {
        let Some(name) = name else { return Source::Inline };
        let found = name.parse().ok().and_then(|id| self.0.all.find(&id));
        found.map_or(Source::Put, |named| named.source)
    }
}

impl catalogue::Named for Named {
    type Id = PriorId;
    const BUILT_IN: &'static [&'static str] = &BUILT_IN_PRIORS;

    fn id(&self) -> &PriorId {
        &self.id
    }

    fn built_in(id: &PriorId) -> Option<Self> {
        let prior = Prior::built_in(id.as_str())?;
        let note = about_built_in(id.as_str()).map(str::to_owned);
        Some(Self { id: id.clone(), prior, note, source: Source::BuiltIn })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(id: &str) -> Named {
        Named { id: id.parse().unwrap(), prior: Prior::flat(), note: None, source: Source::Put }
    }

    #[test]
    fn names_are_listed_in_order_those_of_the_program_among_them() {
        let priors = Priors::default();
        for id in ["zoo", "dune", "a"] {
            priors.all().insert(named(id));
        }
        let ids = |after: Option<&str>, limit| -> Vec<String> {
            let after = after.map(|after| after.parse().unwrap());
            priors.all().above(after.as_ref(), limit).iter().map(|it| it.id.to_string()).collect()
        };
        assert_eq!(
            ids(None, 9),
            ["a", "default", "dune", "empirical", "flat", "thesis", "thesis-20", "zoo"]
        );
        assert_eq!(ids(None, 2), ["a", "default"]);
        assert_eq!(ids(Some("default"), 2), ["dune", "empirical"]);
        assert_eq!(ids(Some("zoo"), 2), [""; 0]);
    }

    #[test]
    fn a_name_that_no_one_knows_is_answered_with_those_that_there_are() {
        let priors = Priors::default();
        priors.all().insert(named("dune"));
        assert_eq!(priors.known("dune"), Ok(Prior::flat()));
        assert_eq!(
            priors.known("oasis").unwrap_err(),
            ["default", "flat", "thesis", "thesis-20", "empirical", "dune"]
        );
    }

    #[test]
    fn what_is_kept_comes_back() {
        let source = Source::Evolution {
            evolution: "evolution-7".parse().unwrap(),
            seed: 3,
            optimizer: umwelt_api::evolution::Optimizer::CmaEs,
            fitness: Some(1.25),
        };
        for named in [named("dune"), Named { source, note: Some("n".into()), ..named("oasis") }] {
            assert_eq!(Named::of_stored(named.stored().unwrap()), Some(named));
        }
        assert_eq!(
            <Named as catalogue::Named>::built_in(&"flat".parse().unwrap()).unwrap().stored(),
            None
        );
    }
}
