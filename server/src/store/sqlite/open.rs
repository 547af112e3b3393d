//! The data directory: made, locked, and its file opened so that what is acknowledged is on the disk.

use super::files::DATA_FILE;
use super::open_error::OpenError;
use super::schema::{self, Unusable};
use super::{checksum, files, log};
use crate::store::StoreError;
use rusqlite::{Connection, ErrorCode, OpenFlags, ffi};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long to wait where another program holds the data file, as an `sqlite3` shell may: longer than any of its
/// statements should take, shorter than a client waits.
pub(super) const BUSY: Duration = Duration::from_secs(2);

/// Size in bytes to which the write-ahead log shrinks again after a burst.
const LOG_SIZE: i64 = 16 << 20;

/// A data directory in use.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) file: PathBuf,
    /// Locked as long as it is open.
    lock: File,
}

/// Takes the data directory, which is made where there is none.
pub(super) fn take(directory: &Path) -> Result<Opened, OpenError> {
    let refused = |error| OpenError::Directory { directory: directory.to_path_buf(), error };
    fs::create_dir_all(directory).map_err(refused)?;
    let lock = files::lock(directory)?;
    files::refuse_lost(directory)?;
    let file = directory.join(DATA_FILE);
    let log = files::log_of(&file);
    match log::damage(&log) {
        Ok(None) => Ok(Opened { file, lock }),
        Ok(Some(what)) => Err(OpenError::DamagedLog { log, what }),
        Err(error) => Err(refused(error)),
    }
}

impl Opened {
    /// A connection for the one who writes, to tables as of `migrations`.
    pub(super) fn writer(&self, migrations: &[&str]) -> Result<Connection, Unusable> {
        let mut connection = writable(&self.file)?;
        // First of all whose it is: a file of another program is not touched.
        if schema::version(&connection, migrations.len())?.is_some() {
            check(&connection)?;
        }
        make_durable(&connection)?;
        schema::migrate(&mut connection, migrations)?;
        schema::check_shape(&connection, migrations)?;
        // A file that cannot be written opens all the same: find out now.
        connection.execute(PROBE, [])?;
        Ok(connection)
    }

    /// Notes that there is a store, for whoever finds the directory without one; the entries of new files are on the disk
    /// with this.
    pub(super) fn note(&self) -> io::Result<()> {
        files::mark(&self.lock)?;
        File::open(self.file.parent().unwrap_or(Path::new(".")))?.sync_all()
    }

    /// What it means that the data file cannot be used.
    pub(super) fn unusable(&self, unusable: Unusable) -> OpenError {
        unusable_file(&self.file, unusable)
    }
}

/// What is acknowledged is on the disk.
fn make_durable(connection: &Connection) -> rusqlite::Result<()> {
    connection.pragma_update_and_check(None, "journal_mode", "wal", |_| Ok(()))?;
    connection.pragma_update_and_check(None, "journal_size_limit", LOG_SIZE, |_| Ok(()))?;
    connection.pragma_update(None, "synchronous", "full")?;
    // On a Mac only this reaches the disk.
    connection.pragma_update(None, "fullfsync", true)?;
    connection.pragma_update(None, "checkpoint_fullfsync", true)
}

/// The same as [`Opened::writer`] for a file that was looked at before.
pub(super) fn writer_again(file: &Path) -> Result<Connection, Unusable> {
    let connection = writable(file)?;
    make_durable(&connection)?;
    connection.execute(PROBE, [])?;
    Ok(connection)
}

/// A connection that reads `file` and keeps all others out: it needs no room on the disk, not even for what connections
/// tell each other (the file that ends in -shm).
pub(super) fn reading_alone(file: &Path, migrations: &[&str]) -> Result<Connection, Unusable> {
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = connect(file, flags)?;
    connection.pragma_update_and_check(None, "locking_mode", "exclusive", |_| Ok(()))?;
    connection.pragma_update(None, "query_only", true)?;
    check(&connection)?;
    schema::check_shape(&connection, migrations)?;
    Ok(connection)
}

/// Whether a file can be read and not written for want of room: the disk is full, or a file may not grow.
pub(super) fn has_no_room(unusable: &Unusable) -> bool {
    let Unusable::Failed(error) = unusable else { return false };
    let no_room = [
        ffi::SQLITE_FULL,
        ffi::SQLITE_IOERR_WRITE,
        ffi::SQLITE_IOERR_FSYNC,
        ffi::SQLITE_IOERR_TRUNCATE,
        ffi::SQLITE_IOERR_SHMOPEN,
        ffi::SQLITE_IOERR_SHMSIZE,
        ffi::SQLITE_IOERR_SHMMAP,
    ];
    error.sqlite_error().is_some_and(|error| no_room.contains(&error.extended_code))
}

/// Writes and changes nothing that matters.
pub(super) const PROBE: &str = "INSERT INTO numbers (name, value, checksum) \
     VALUES ('probe', 0, row_checksum('numbers', 'probe', 0)) \
     ON CONFLICT (name) DO UPDATE SET value = value + 1, \
     checksum = row_checksum('numbers', name, value + 1)";

/// A connection to `file` that only reads.
pub(super) fn read_only(file: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    connect(file, flags)
}

/// A connection to `file` that may write, and makes it where there is none.
pub(super) fn writable(file: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE
        | OpenFlags::SQLITE_OPEN_CREATE
        | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = connect(file, flags)?;
    connection.pragma_update(None, "foreign_keys", true)?;
    Ok(connection)
}

fn connect(file: &Path, flags: OpenFlags) -> rusqlite::Result<Connection> {
    let connection = Connection::open_with_flags(file, flags)?;
    connection.busy_timeout(BUSY)?;
    // What SQLite notes down for one statement alone is nothing for a disk.
    connection.pragma_update(None, "temp_store", "memory")?;
    checksum::install(&connection)?;
    Ok(connection)
}

/// Whether every page can be read and has its place, and every row is found by its key. (A quick check does not look at
/// the latter, and costs about as much: there are few rows, and some are large.)
pub(super) fn check(connection: &Connection) -> Result<(), Unusable> {
    let found: String = connection.query_row("PRAGMA integrity_check(1)", [], |row| row.get(0))?;
    if found == "ok" { Ok(()) } else { Err(Unusable::Damaged(found)) }
}

/// What it means that `file` cannot be used.
pub(super) fn unusable_file(file: &Path, unusable: Unusable) -> OpenError {
    let file = file.to_path_buf();
    match unusable {
        Unusable::Foreign => OpenError::Foreign { file },
        Unusable::Newer { version } => {
            OpenError::Newer { file, version, known: schema::MIGRATIONS.len() }
        }
        Unusable::Gone(what) => {
            OpenError::Unavailable { file, what, remedy: "leave the files beside it alone" }
        }
        Unusable::Damaged(what) => OpenError::Damaged { file, what },
        Unusable::Failed(error) => match kind(&error) {
            Kind::Damaged => OpenError::Damaged { file, what: error.to_string() },
            Kind::Unavailable(remedy) | Kind::Rejected(remedy) => {
                OpenError::Unavailable { file, what: error.to_string(), remedy }
            }
        },
    }
}

/// What an error of SQLite means, and what to do about it.
enum Kind {
    Unavailable(&'static str),
    Damaged,
    Rejected(&'static str),
}

fn kind(error: &rusqlite::Error) -> Kind {
    match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => Kind::Damaged,
        Some(ErrorCode::DiskFull) => Kind::Unavailable("free some space on its disk"),
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            Kind::Unavailable("another program holds it, such as an sqlite3 shell: end that")
        }
        Some(ErrorCode::ReadOnly | ErrorCode::PermissionDenied | ErrorCode::CannotOpen) => {
            Kind::Unavailable("make the file and its directory writable for the server's user")
        }
        Some(ErrorCode::TooBig | ErrorCode::ConstraintViolation | ErrorCode::TypeMismatch)
        | None => Kind::Rejected("please report this"),
        Some(_) => Kind::Unavailable(
            "see whether its disk is full and free some space, or look at the system's log",
        ),
    }
}

/// An error of a call while the store is in use.
pub(super) fn call_failed(file: &Path, error: &rusqlite::Error) -> StoreError {
    let said = format!("{}: {error}", file.display());
    match kind(error) {
        Kind::Unavailable(remedy) => StoreError::Unavailable(format!("{said}; {remedy}")),
        Kind::Damaged => StoreError::Damaged(said),
        Kind::Rejected(_) => StoreError::Rejected(said),
    }
}
