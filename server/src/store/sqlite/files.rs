//! The files of a data directory: who holds them, whether there was a store in them, and whether they are still those
//! that were opened.

use super::open_error::OpenError;
use crate::store::StoreError;
use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// The data file in the data directory.
pub const DATA_FILE: &str = "umwelt.sqlite";

/// The file that a running server holds locked. Once there is a store beside it, it says so, and stays.
pub const LOCK_FILE: &str = "umwelt.lock";

/// What the lock file says once there is a store: SQLite takes an empty file, or none, for a new store.
const MARK: &str = "The store is in umwelt.sqlite beside this file. A server that finds it missing or empty does not \
                    start; to begin anew without it, remove this file too.\n";

/// The smallest page that SQLite knows, in bytes: no store is smaller.
const SMALLEST: u64 = 512;

/// Takes a data directory: no one else does until what is returned is dropped.
pub(super) fn lock(directory: &Path) -> Result<File, OpenError> {
    let directory = directory.to_path_buf();
    let file = directory.join(LOCK_FILE);
    let lock = match File::options().create(true).truncate(false).write(true).open(file) {
        Ok(lock) => lock,
        Err(error) => return Err(OpenError::Directory { directory, error }),
    };
    match lock.try_lock() {
        Ok(()) => Ok(lock),
        Err(TryLockError::WouldBlock) => Err(OpenError::InUse { directory }),
        Err(TryLockError::Error(error)) => Err(OpenError::Directory { directory, error }),
    }
}

/// Notes in the lock file that there is a store beside it.
pub(super) fn mark(mut lock: &File) -> io::Result<()> {
    if lock.metadata()?.len() == 0 {
        lock.write_all(MARK.as_bytes())?;
        lock.sync_all()?;
    }
    Ok(())
}

/// Refuses a directory in which there was a store that is not there any more, or not all of it.
///
/// # Errors
/// Where the data file is missing or empty and something beside it speaks of a store, or it is too small for one.
pub(super) fn refuse_lost(directory: &Path) -> Result<(), OpenError> {
    let length = |file: &Path| std::fs::metadata(file).map(|metadata| metadata.len());
    let file = directory.join(DATA_FILE);
    let what = match length(&file) {
        Ok(0) => "is empty",
        // One that was being made when the power went is taken back by SQLite.
        Ok(1..SMALLEST) if !beside(&file, "-journal").exists() => "is cut off",
        Ok(_) => return Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => "is missing",
        Err(error) => {
            return Err(OpenError::Directory { directory: directory.to_path_buf(), error });
        }
    };
    let tells = [directory.join(LOCK_FILE), log_of(&file)];
    let tells = tells.into_iter().find(|other| length(other).is_ok_and(|length| length > 0));
    match tells.or_else(|| (what == "is cut off").then(|| file.clone())) {
        Some(tells) => Err(OpenError::Lost { file, what, tells }),
        None => Ok(()),
    }
}

/// The write-ahead log of a data file.
pub(super) fn log_of(file: &Path) -> PathBuf {
    beside(file, "-wal")
}

/// The file of this name with an ending.
fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name: OsString = file.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}

/// Files in use, and which they are: one that was moved or removed can be written to, and all of it would be lost.
#[derive(Debug)]
pub(super) struct Watched(Vec<(PathBuf, Identity, &'static str)>);

/// Device and number of a file.
#[derive(Debug, PartialEq, Eq)]
struct Identity(u64, u64);

fn identity(file: &Path) -> io::Result<Identity> {
    let metadata = std::fs::metadata(file)?;
    Ok(Identity(metadata.dev(), metadata.ino()))
}

impl Watched {
    /// The files of an open store whose data file is `file`.
    pub(super) fn of(file: &Path) -> io::Result<Self> {
        let again = "put it back, or restart the server, which loses nothing";
        let one = |file: PathBuf, remedy| -> io::Result<_> {
            let identity = identity(&file)?;
            Ok((file, identity, remedy))
        };
        Ok(Self(vec![
            one(file.to_path_buf(), "put it back")?,
            one(log_of(file), again)?,
            one(beside(file, "-shm"), again)?,
            one(file.with_file_name(LOCK_FILE), again)?,
        ]))
    }

    /// Whether all of them are where they were.
    ///
    /// # Errors
    /// Where one is not: what is written now could not be found again.
    pub(super) fn check(&self) -> Result<(), StoreError> {
        let is_there =
            |file: &Path, known: &Identity| identity(file).is_ok_and(|found| found == *known);
        match self.0.iter().find(|(file, known, _)| !is_there(file, known)) {
            None => Ok(()),
            Some((file, _, remedy)) => {
                let file = file.display();
                Err(StoreError::Unavailable(format!("{file} was moved or removed; {remedy}")))
            }
        }
    }
}
