//! The files of a data directory: who holds them.

use super::open::OpenError;
use std::fs::{File, TryLockError};
use std::path::Path;

/// The file that a running server holds locked. Its content says nothing, and it may stay.
pub const LOCK_FILE: &str = "umwelt.lock";

/// Takes a data directory: nobody else does until what is returned is dropped.
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
