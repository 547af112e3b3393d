//! Why a data directory cannot be used, and what to do.

use std::io;
use std::path::{Path, PathBuf};

/// Why a data directory cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Directory or lock file cannot be made or opened.
    #[error(
        "cannot use the data directory {}: {error}; make it writable, name another one with --data, or keep nothing \
         with --in-memory", .directory.display()
    )]
    Directory {
        /// Which one.
        directory: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// Another server uses it.
    #[error(
        "the data directory {} is in use by another umwelt-server; stop that one, or name another directory with \
         --data", .directory.display()
    )]
    InUse {
        /// Which one.
        directory: PathBuf,
    },
    /// There is no data file.
    #[error("there is no data file {}; name the data directory of the server with --data", .file.display())]
    Missing {
        /// Which one.
        file: PathBuf,
    },
    /// There was a store, and it is not there any more.
    #[error(
        "{} {what}, but there was a store in it, as {} tells; put it back, or put a backup in its place; to begin anew \
         without what it held, remove every file there whose name begins with umwelt.", .file.display(), .tells.display()
    )]
    Lost {
        /// Which one.
        file: PathBuf,
        /// What there is of it.
        what: &'static str,
        /// What tells of it.
        tells: PathBuf,
    },
    /// The file is of another program.
    #[error("{} is no data file of umwelt-server; name another directory with --data", .file.display())]
    Foreign {
        /// Which one.
        file: PathBuf,
    },
    /// The file is of a newer program.
    #[error(
        "{} was written by a newer umwelt-server: its tables are of version {version}, this one knows up to {known}; \
         use the newer one, or a backup made before it", .file.display()
    )]
    Newer {
        /// Which one.
        file: PathBuf,
        /// Version of its tables.
        version: usize,
        /// The newest version that this program knows.
        known: usize,
    },
    /// The file is damaged.
    #[error(
        "{} is damaged: {what}; move it away with the files beside it whose names begin with its own, and put a backup \
         in its place or begin anew without one", .file.display()
    )]
    Damaged {
        /// Which one.
        file: PathBuf,
        /// What is found.
        what: String,
    },
    /// Its log is damaged.
    #[error(
        "{} is damaged: {what}; put a backup in its place and remove it, or go on without what was written from there on: \
         umwelt-server check --data {} --remove-damaged", .log.display(), .log.parent().unwrap_or(Path::new(".")).display()
    )]
    DamagedLog {
        /// Which one.
        log: PathBuf,
        /// What is found.
        what: String,
    },
    /// The file cannot be read or written now.
    #[error("cannot use {}: {what}; {remedy}", .file.display())]
    Unavailable {
        /// Which one.
        file: PathBuf,
        /// What SQLite says.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
}
