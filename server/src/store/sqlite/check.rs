//! A data file looked through from end to end, without a server: which rows are damaged, and those taken out.

use super::damage::{self, Damage};
use super::files::DATA_FILE;
use super::open;
use super::open_error::OpenError;
use super::schema::{self, Unusable};
use super::{files, log};
use rusqlite::{Connection, TransactionBehavior};
use std::fmt;
use std::path::{Path, PathBuf};

/// What is found in a data file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checked {
    /// The file.
    pub file: PathBuf,
    /// The rows that are not as they were written, by table.
    pub damaged: Vec<Damage>,
    /// Whether they are taken out.
    pub removed: bool,
}

/// Reads all that the store in `directory` keeps, and says which rows are damaged. With `remove` they are taken out, a
/// job with everything of it, in one transaction; no server can use the store meanwhile then, while without it one may.
///
/// # Errors
/// Where there is no store, the file as a whole cannot be read, or, with `remove`, a server uses it.
pub fn check(directory: &Path, remove: bool) -> Result<Checked, OpenError> {
    let file = directory.join(DATA_FILE);
    if !file.try_exists().unwrap_or(true) {
        return Err(OpenError::Missing { file });
    }
    files::refuse_lost(directory)?;
    let held = match files::lock(directory) {
        Ok(held) => Some(held),
        Err(error) if remove => return Err(error),
        Err(_) => None,
    };
    // A log that is being written meanwhile says nothing.
    let mut damaged = if held.is_some() { look_at_log(&file, directory)? } else { Vec::new() };
    // SQLite leaves out what is in a damaged log from the damaged page on.
    damaged.extend(look(&file, remove).map_err(|found| open::unusable_file(&file, found))?);
    Ok(Checked { removed: remove && !damaged.is_empty(), file, damaged })
}

fn look_at_log(file: &Path, directory: &Path) -> Result<Vec<Damage>, OpenError> {
    let refused = |error| OpenError::Directory { directory: directory.to_path_buf(), error };
    let found = log::damage(&files::log_of(file)).map_err(refused)?;
    let damage = |why| Damage { table: "the log", key: format!("{DATA_FILE}-wal"), why };
    Ok(found.map(damage).into_iter().collect())
}

fn look(file: &Path, remove: bool) -> Result<Vec<Damage>, Unusable> {
    let mut connection = if remove { open::writable(file)? } else { open::read_only(file)? };
    open::check(&connection)?;
    if !has_checksums(&connection)? {
        return Ok(Vec::new());
    }
    let transaction = connection.transaction_with_behavior(if remove {
        TransactionBehavior::Immediate
    } else {
        TransactionBehavior::Deferred
    })?;
    let damaged = damage::scan(&transaction)?;
    if remove && !damaged.is_empty() {
        damage::remove(&transaction)?;
        transaction.commit()?;
    }
    Ok(damaged)
}

/// Whether the rows of a data file have checksums: those of older programs get theirs when a server opens them.
pub(super) fn has_checksums(connection: &Connection) -> Result<bool, Unusable> {
    let version = schema::version(connection, schema::MIGRATIONS.len())?;
    Ok(version.ok_or(Unusable::Foreign)? >= schema::CHECKSUMS)
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.display();
        for damage in &self.damaged {
            writeln!(f, "{damage}")?;
        }
        match (self.damaged.len(), self.removed) {
            (0, _) => write!(f, "{file}: every row is as it was written"),
            (count, true) => write!(f, "{file}: {count} damaged rows, which are removed"),
            (count, false) => write!(f, "{file}: {count} damaged rows"),
        }
    }
}
