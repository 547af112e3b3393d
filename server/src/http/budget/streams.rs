//! Event streams: so many at a time, and none of them ends for another.

use super::ledger::{Ledger, Scope};
use super::{Limits, Peer};
use crate::resource::failure::{self, Failure};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Event streams that may be followed; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Streams(Arc<Mutex<Ledger<()>>>);

/// One that is followed, until this is dropped.
#[derive(Debug)]
pub(crate) struct Stream {
    streams: Streams,
    peer: Peer,
    id: u64,
}

impl Streams {
    pub(crate) fn new(limits: Limits) -> Self {
        Self(Arc::new(Mutex::new(Ledger::new(limits))))
    }

    /// One more stream for a peer.
    ///
    /// # Errors
    /// Where a limit is reached.
    pub(crate) fn follow(&self, peer: Peer) -> Result<Stream, Failure> {
        let mut ledger = self.ledger();
        let Limits { overall, per_peer } = ledger.limits();
        match ledger.exceeded(peer, 1) {
            Some(Scope::Overall) => Err(failure::limit_reached("event streams", overall)),
            Some(Scope::Peer) => {
                Err(failure::limit_reached("event streams of this address", per_peer))
            }
            None => {
                let id = ledger.join(peer, 1, ());
                drop(ledger);
                Ok(Stream { streams: self.clone(), peer, id })
            }
        }
    }

    fn ledger(&self) -> MutexGuard<'_, Ledger<()>> {
        // No call panics between two changes, so a poisoned ledger is whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        self.streams.ledger().leave(self.peer, self.id);
    }
}
