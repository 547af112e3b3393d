//! How a data file is open: for one connection that writes beside one that reads, or, as long as its disk is full, for
//! one that reads alone. From that it comes back by itself at the first write for which there is room.

use super::files::Watched;
use super::open::{self, Opened};
use super::open_error::OpenError;
use super::schema::{self, Unusable};
use crate::store::StoreError;
use rusqlite::Connection;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The connection that reads; another one takes its place when the disk is full or has room again.
#[derive(Clone, Debug)]
pub(super) struct Reader(Arc<Mutex<Connection>>);

impl Reader {
    pub(super) fn lock(&self) -> MutexGuard<'_, Connection> {
        // A read leaves nothing behind in the connection.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The connection that writes, and the files to which it does.
#[derive(Debug)]
pub(super) struct Writing {
    pub(super) connection: Connection,
    pub(super) watched: Watched,
}

/// A data file in use.
#[derive(Debug)]
pub(super) struct Access {
    file: PathBuf,
    // Closed before the one that writes, which brings the log into the file where it is the last.
    reader: Reader,
    /// None as long as the disk was full when the file was opened.
    writing: Option<Writing>,
}

impl Access {
    /// Opens the file of a data directory with tables as of `migrations`.
    ///
    /// # Errors
    /// Where it cannot be read, or not be written for another reason than that there is no room.
    pub(super) fn open(opened: &Opened, migrations: &[&str]) -> Result<Self, OpenError> {
        let file = opened.file.clone();
        let found = match opened.writer(migrations) {
            Ok(connection) => {
                return Self::with(connection, file).map_err(|it| opened.unusable(it));
            }
            Err(found) => found,
        };
        let alone = open::has_no_room(&found).then(|| open::reading_alone(&file, migrations));
        match alone {
            Some(Ok(alone)) => {
                Ok(Self { file, reader: Reader(Arc::new(Mutex::new(alone))), writing: None })
            }
            _ => Err(opened.unusable(found)),
        }
    }

    /// With the connection that writes.
    pub(super) fn with(connection: Connection, file: PathBuf) -> Result<Self, Unusable> {
        let (reader, writing) = pair(connection, &file)?;
        Ok(Self { file, reader: Reader(Arc::new(Mutex::new(reader))), writing: Some(writing) })
    }

    /// The file.
    pub(super) fn file(&self) -> PathBuf {
        self.file.clone()
    }

    /// The connection that reads.
    pub(super) fn reader(&self) -> Reader {
        self.reader.clone()
    }

    /// The connection that writes, where the file is open for one.
    pub(super) fn writing(&mut self) -> Option<&mut Writing> {
        self.writing.as_mut()
    }

    /// The connection that writes; where there is none, it is tried whether there is room for one now.
    ///
    /// # Errors
    /// Where there is still none; reading goes on.
    pub(super) fn ready(&mut self) -> Result<&mut Writing, StoreError> {
        let Self { file, reader, writing } = self;
        match writing {
            Some(writing) => Ok(writing),
            None => Ok(writing.insert(open_again(file, reader)?)),
        }
    }
}

/// Opens `file` for writing while `reader` reads it alone; it reads beside the one who writes then.
fn open_again(file: &Path, reader: &Reader) -> Result<Writing, StoreError> {
    let mut reader = reader.lock();
    // One that reads alone keeps all others out: it is closed before they are tried.
    let nothing = Connection::open_in_memory();
    *reader = nothing.map_err(|error| open::call_failed(file, &error))?;
    match open::writer_again(file).and_then(|connection| pair(connection, file)) {
        Ok((beside, writing)) => {
            *reader = beside;
            Ok(writing)
        }
        Err(found) => {
            // Where not even that can be opened, reading fails until the next try.
            if let Ok(alone) = open::reading_alone(file, schema::MIGRATIONS) {
                *reader = alone;
            }
            Err(StoreError::Unavailable(open::unusable_file(file, found).to_string()))
        }
    }
}

/// The one that reads beside `connection`, and what that one writes to.
fn pair(connection: Connection, file: &Path) -> Result<(Connection, Writing), Unusable> {
    let reader = open::read_only(file)?;
    let watched = Watched::of(file).map_err(|error| Unusable::Gone(error.to_string()))?;
    Ok((reader, Writing { connection, watched }))
}
