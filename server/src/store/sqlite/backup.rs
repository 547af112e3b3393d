//! A copy of a data file, made while a server may be using it.

use super::files::DATA_FILE;
use super::open;
use super::open_error::OpenError;
use super::schema::{self, Unusable};
use super::{check, damage, files};
use crate::store::StoredKind;
use rusqlite::Connection;
use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// What a backup holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Backup {
    /// Size of the file in bytes.
    pub bytes: u64,
    /// Robots in it.
    pub robots: u64,
    /// Priors in it.
    pub priors: u64,
    /// Environments in it.
    pub environments: u64,
    /// Evolutions in it.
    pub evolutions: u64,
    /// Generations of all of them.
    pub generations: u64,
    /// Comparisons in it.
    pub comparisons: u64,
}

/// Why there is no backup.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    /// The data file cannot be used.
    #[error(transparent)]
    Source(#[from] OpenError),
    /// The target is there already.
    #[error("{} exists already; a backup replaces nothing: name another file", .0.display())]
    Exists(PathBuf),
    /// The target cannot be written.
    #[error("cannot write {}: {error}", .file.display())]
    Target {
        /// Which one.
        file: PathBuf,
        /// What is in the way.
        error: String,
    },
}

/// Writes everything that the store in `directory` keeps, as of one moment, to `target`, which must not exist. A server
/// may go on using the store meanwhile. The file that comes of it is whole, on the disk, and a data file itself.
///
/// # Errors
/// Where there is no store that can be read, or `target` cannot be written or exists; then nothing is left behind.
pub fn backup(directory: &Path, target: &Path) -> Result<Backup, BackupError> {
    let source = directory.join(DATA_FILE);
    if !source.try_exists().unwrap_or(true) {
        return Err(OpenError::Missing { file: source }.into());
    }
    files::refuse_lost(directory)?;
    let connection = readable(&source).map_err(|found| open::unusable_file(&source, found))?;
    if fs::symlink_metadata(target).is_ok() {
        return Err(BackupError::Exists(target.to_path_buf()));
    }
    let partial = Partial::beside(target)?;
    let made = partial.copy(&connection).and_then(|found| {
        partial.publish(target)?;
        Ok(found)
    });
    made.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => BackupError::Exists(target.to_path_buf()),
        _ => BackupError::Target { file: target.to_path_buf(), error: error.to_string() },
    })
}

/// A connection to a data file of a version that this program knows.
fn readable(file: &Path) -> Result<Connection, Unusable> {
    let connection = open::read_only(file)?;
    match schema::version(&connection, schema::MIGRATIONS.len())? {
        Some(_) => Ok(connection),
        None => Err(Unusable::Foreign),
    }
}

/// The copy under a name of its own until it is whole; it goes when this is dropped.
struct Partial(PathBuf);

impl Partial {
    fn beside(target: &Path) -> Result<Self, BackupError> {
        let mut name: OsString = target.as_os_str().to_owned();
        name.push(".partial");
        let file = PathBuf::from(name);
        // Left behind by one that was killed, or being made by another one.
        match File::options().write(true).create_new(true).open(&file) {
            Ok(_) => Ok(Self(file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                let error = "it was left behind by a backup that broke off, or one is running: \
                             remove it, or wait"
                    .to_owned();
                Err(BackupError::Target { file, error })
            }
            Err(error) => Err(BackupError::Target { file, error: error.to_string() }),
        }
    }

    /// Copies, checks and counts.
    fn copy(&self, source: &Connection) -> io::Result<Backup> {
        let Some(name) = self.0.to_str() else {
            return Err(io::Error::other("its name is no UTF-8"));
        };
        source.execute("VACUUM INTO ?1", [name]).map_err(io::Error::other)?;
        File::open(&self.0)?.sync_all()?;
        let copy = open::read_only(&self.0).map_err(io::Error::other)?;
        let unfit = |found| io::Error::other(format!("{found:?}"));
        open::check(&copy).map_err(unfit)?;
        if check::has_checksums(&copy).map_err(unfit)? {
            let damaged = damage::scan(&copy).map_err(io::Error::other)?;
            if !damaged.is_empty() {
                let file = source.path().map(Path::new).unwrap_or(&self.0);
                return Err(io::Error::other(damage::message(file, &damaged)));
            }
        }
        let count = |table: &str| {
            let count = format!("SELECT count(*) FROM {table}");
            copy.query_row(&count, [], |row| row.get::<_, i64>(0))
                .map(i64::unsigned_abs)
                .map_err(io::Error::other)
        };
        let version = schema::version(&copy, schema::MIGRATIONS.len());
        let version = version.map_err(|found| io::Error::other(format!("{found:?}")))?;
        // A backup leaves an older file as old as it is.
        let [evolutions, generations, comparisons] = if version == Some(1) {
            [count("evolutions")?, count("generations")?, 0]
        } else {
            let of =
                |table: &str, kind: StoredKind| count(&format!("{table} WHERE kind = '{kind}'"));
            [
                of("jobs", StoredKind::Evolution)?,
                of("parts", StoredKind::Evolution)?,
                of("jobs", StoredKind::Comparison)?,
            ]
        };
        Ok(Backup {
            bytes: fs::metadata(&self.0)?.len(),
            robots: count("robots")?,
            priors: count("priors")?,
            environments: count("environments")?,
            evolutions,
            generations,
            comparisons,
        })
    }

    /// Gives it the name of `target`, unless there is one now.
    fn publish(&self, target: &Path) -> io::Result<()> {
        match fs::hard_link(&self.0, target) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(error),
            // Not every file system has links.
            Err(_) => fs::rename(&self.0, target)?,
        }
        let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty());
        File::open(directory.unwrap_or(Path::new(".")))?.sync_all()
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // It may have become the target.
        let _ = fs::remove_file(&self.0);
    }
}

impl fmt::Display for Backup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bytes, robots, priors, environments, evolutions, generations, comparisons } =
            self;
        let kb = bytes.div_ceil(1000);
        write!(
            f,
            "{kb} kB: {robots} robots, {priors} priors, {environments} environments, {evolutions} evolutions with \
             {generations} generations, {comparisons} comparisons"
        )
    }
}
