//! Things with names: those that come with the server, which no one changes, and those that are kept.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::ops::Bound;
use std::str::FromStr;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Something with a name.
pub(crate) trait Named: Clone {
    /// The name.
    type Id: Ord + Clone + Debug + FromStr;
    /// The names of those that come with the server.
    const BUILT_IN: &'static [&'static str];

    /// Its name.
    fn id(&self) -> &Self::Id;

    /// The one of this name that comes with the server.
    fn built_in(id: &Self::Id) -> Option<Self>;
}

/// All of one kind. What is kept shows here once the store has it.
#[derive(Debug)]
pub(crate) struct Catalogue<N: Named>(RwLock<BTreeMap<N::Id, N>>);

impl<N: Named> Default for Catalogue<N> {
    fn default() -> Self {
        Self(RwLock::default())
    }
}

impl<N: Named> FromIterator<N> for Catalogue<N> {
    fn from_iter<I: IntoIterator<Item = N>>(kept: I) -> Self {
        let kept = kept.into_iter().map(|named| (named.id().clone(), named));
        Self(RwLock::new(kept.collect()))
    }
}

impl<N: Named> Catalogue<N> {
    /// Those that are kept.
    pub(crate) fn kept(&self) -> RwLockReadGuard<'_, BTreeMap<N::Id, N>> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn changed(&self) -> RwLockWriteGuard<'_, BTreeMap<N::Id, N>> {
        self.0.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// The one of this name.
    pub(crate) fn find(&self, id: &N::Id) -> Option<N> {
        N::built_in(id).or_else(|| self.kept().get(id).cloned())
    }

    /// Those with names above `after`, in the order of their names, at most `limit`.
    pub(crate) fn above(&self, after: Option<&N::Id>, limit: usize) -> Vec<N> {
        let from = after.map_or(Bound::Unbounded, Bound::Excluded);
        let ids = N::BUILT_IN.iter().filter_map(|name| name.parse().ok());
        let ids = ids.filter(|id| after.is_none_or(|after| id > after));
        let built_in = ids.filter_map(|id| N::built_in(&id));
        let kept = self.kept();
        let kept = kept.range::<N::Id, _>((from, Bound::Unbounded)).take(limit);
        let mut all: Vec<_> = kept.map(|(_, named)| named.clone()).chain(built_in).collect();
        all.sort_by(|one, other| one.id().cmp(other.id()));
        all.truncate(limit);
        all
    }

    /// How many are kept.
    pub(crate) fn len(&self) -> usize {
        self.kept().len()
    }

    /// Shows one that is kept now.
    pub(crate) fn insert(&self, named: N) {
        self.changed().insert(named.id().clone(), named);
    }

    /// Shows one no more that is not kept any more.
    pub(crate) fn remove(&self, id: &N::Id) {
        self.changed().remove(id);
    }
}
