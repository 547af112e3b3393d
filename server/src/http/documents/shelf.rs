//! The documents that are kept: those that were asked for last, up to so many bytes.

use super::document::{Document, Name};
use std::collections::HashMap;
use std::sync::Arc;
use tokio::sync::OnceCell;

/// Where a document is put once it is made.
pub(super) type Place = Arc<OnceCell<Document>>;

/// Places for documents.
#[derive(Debug)]
pub(super) struct Shelf {
    limit: usize,
    /// Bytes of those that are kept.
    kept: usize,
    /// Counts requests, to tell which came last.
    now: u64,
    places: HashMap<Name, Kept>,
}

#[derive(Debug)]
struct Kept {
    place: Place,
    /// None while it is being made.
    bytes: Option<usize>,
    used: u64,
}

impl Shelf {
    pub(super) fn new(limit: usize) -> Self {
        Self { limit, kept: 0, now: 0, places: HashMap::new() }
    }

    /// The place of a document, empty or not.
    pub(super) fn place(&mut self, name: Name) -> Place {
        self.now += 1;
        let empty = || Kept { place: Place::default(), bytes: None, used: 0 };
        let kept = self.places.entry(name).or_insert_with(empty);
        kept.used = self.now;
        Arc::clone(&kept.place)
    }

    /// The document has been made, with so many bytes. Those make room that no one has asked for the longest.
    pub(super) fn keep(&mut self, name: Name, bytes: usize) {
        let Some(kept) = self.places.get_mut(&name).filter(|kept| kept.bytes.is_none()) else {
            return;
        };
        kept.bytes = Some(bytes);
        self.kept += bytes;
        while self.kept > self.limit {
            let made = self.places.iter().filter(|(_, kept)| kept.bytes.is_some());
            let Some(oldest) = made.min_by_key(|(_, kept)| kept.used).map(|(name, _)| *name) else {
                return;
            };
            self.remove(oldest);
        }
    }

    /// The document could not be made; whoever waits for it tries anew.
    pub(super) fn clear(&mut self, name: Name) {
        if self.places.get(&name).is_some_and(|kept| kept.bytes.is_none()) {
            self.remove(name);
        }
    }

    fn remove(&mut self, name: Name) {
        if let Some(kept) = self.places.remove(&name) {
            self.kept -= kept.bytes.unwrap_or(0);
        }
    }
}
