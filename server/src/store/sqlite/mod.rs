//! The durable store: one SQLite file in the data directory.
//!
//! One thread writes, in groups (`writer`); reads go through a connection of their own and never wait for it. What is
//! acknowledged is on the disk: write-ahead log, synced at every commit.

mod access;
mod apply;
mod backup;
mod check;
mod checksum;
mod damage;
mod files;
mod log;
mod open;
mod open_error;
mod read;
mod schema;
mod tables;
mod writer;

pub use backup::{Backup, BackupError, backup};
pub use check::{Checked, check};
pub use damage::Damage;
pub use files::{DATA_FILE, LOCK_FILE};
pub use open_error::OpenError;

use super::{Change, Contents, JobId, Part, Store, StoreError};
use access::{Access, Reader, Writing};
use open::Opened;
use std::path::Path;
use std::time::Duration;
use writer::{IDLE, Request, Writer};

/// Keeps everything in a file of a data directory, which no other server can use meanwhile.
#[derive(Debug)]
pub struct SqliteStore {
    // Let go before the writer, which then closes it.
    reader: Reader,
    writer: Writer,
    opened: Opened,
}

impl SqliteStore {
    /// Opens the store in `directory`, which is made where there is none. An older store is brought up to date.
    ///
    /// # Errors
    /// Where it cannot be used; the message says what to do.
    pub fn open(directory: &Path) -> Result<Self, OpenError> {
        Self::open_with(directory, None, IDLE)
    }

    /// The same with at most so many pages, a disk that is full after them, and another time after which it is idle.
    fn open_with(
        directory: &Path,
        max_pages: Option<u32>,
        idle: Duration,
    ) -> Result<Self, OpenError> {
        let opened = open::take(directory)?;
        let mut access = Access::open(&opened, schema::MIGRATIONS)?;
        let refused = |error| OpenError::Directory { directory: directory.into(), error };
        if let Some(Writing { connection, .. }) = access.writing() {
            opened.note().map_err(refused)?;
            if let Some(max_pages) = max_pages {
                let limit = connection.pragma_update(None, "max_page_count", max_pages);
                limit.map_err(|error| opened.unusable(error.into()))?;
            }
        }
        let reader = access.reader();
        let writer = Writer::start(access, idle).map_err(refused)?;
        Ok(Self { reader, writer, opened })
    }

    /// An error of a read as the server sees it.
    fn failed(&self, error: read::ReadError) -> StoreError {
        error.in_file(&self.opened.file)
    }
}

impl Store for SqliteStore {
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError> {
        self.writer.ask(Request::Commit(changes))
    }

    fn load(&self) -> Result<Contents, StoreError> {
        read::contents(&mut self.reader.lock()).map_err(|error| self.failed(error))
    }

    fn parts(&self, job: JobId, from: usize, limit: usize) -> Result<Vec<Part>, StoreError> {
        read::parts(&self.reader.lock(), job, from, limit).map_err(|error| self.failed(error))
    }

    fn checkpoint(&self, job: JobId) -> Result<Option<String>, StoreError> {
        read::checkpoint(&self.reader.lock(), job).map_err(|error| self.failed(error))
    }

    fn probe(&self) -> Result<(), StoreError> {
        self.writer.ask(Request::Probe)
    }

    fn settle(&self) -> Result<(), StoreError> {
        self.writer.ask(Request::Settle)
    }
}

#[cfg(test)]
mod tests;
