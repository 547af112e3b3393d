//! The one thread that writes. It takes all that waits into one transaction, so that many changes share one sync of the
//! disk, with a savepoint around each, so that one that cannot be made fails alone.

use super::apply::{ApplyError, apply};
use super::open::{PROBE, call_failed};
use crate::store::{Change, StoreError};
use rusqlite::{Connection, TransactionBehavior};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Most requests of one group: a bound on what is lost together where the disk fails, far above what waits in practice.
const MAX_GROUP: usize = 256;

/// What the writer can be asked for.
#[derive(Debug)]
pub(super) enum Request {
    /// Changes, all or none of them.
    Commit(Vec<Change>),
    /// Write something that changes nothing.
    Probe,
    /// Bring the write-ahead log into the file.
    Settle,
}

/// A request with the way back.
#[derive(Debug)]
struct Job {
    request: Request,
    answer: SyncSender<Result<(), StoreError>>,
}

/// The thread that writes; it ends when this is dropped, after all that was asked for.
#[derive(Debug)]
pub(super) struct Writer {
    /// None once it is to end.
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
}

impl Writer {
    /// Starts the thread on a connection to `file`.
    pub(super) fn start(connection: Connection, file: PathBuf) -> io::Result<Self> {
        let (jobs, asked) = channel();
        let identity = identity(&file)?;
        let desk = Desk { connection, file, identity };
        let thread = Builder::new().name("store".to_owned()).spawn(move || desk.run(&asked))?;
        Ok(Self { jobs: Some(jobs), thread: Some(thread) })
    }

    /// Asks for something and waits until it is done.
    pub(super) fn ask(&self, request: Request) -> Result<(), StoreError> {
        let ended =
            || StoreError::Unavailable("its thread has ended; restart the server".to_owned());
        let (answer, answered) = sync_channel(1);
        let jobs = self.jobs.as_ref().ok_or_else(ended)?;
        jobs.send(Job { request, answer }).map_err(|_| ended())?;
        answered.recv().map_err(|_| ended())?
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // What made it end was said then.
            let _ = thread.join();
        }
    }
}

/// Why a group was not written.
enum Failed {
    /// Nothing can be written now.
    Outright(StoreError),
    /// Something in it; another group might be.
    Together(StoreError),
}

/// What the thread works with.
struct Desk {
    connection: Connection,
    file: PathBuf,
    identity: Identity,
}

impl Desk {
    fn run(mut self, jobs: &Receiver<Job>) {
        while let Ok(first) = jobs.recv() {
            let group = std::iter::once(first).chain(jobs.try_iter().take(MAX_GROUP - 1));
            let group: Vec<Job> = group.collect();
            let results = self.write_group(&group);
            for (job, result) in group.into_iter().zip(results) {
                // Whoever asked may have given up.
                let _ = job.answer.send(result);
            }
        }
    }

    /// Writes what was asked for. Where all of it together fails, each on its own: a change that is too large for what
    /// is left of the disk takes no other with it.
    fn write_group(&mut self, group: &[Job]) -> Vec<Result<(), StoreError>> {
        match self.write(group) {
            Ok(results) => results,
            Err(Failed::Together(_)) if group.len() > 1 => {
                let alone = |job| self.write_group(std::slice::from_ref(job)).pop();
                group.iter().filter_map(alone).collect()
            }
            Err(Failed::Outright(error) | Failed::Together(error)) => {
                group.iter().map(|_| Err(error.clone())).collect()
            }
        }
    }

    /// One transaction with a savepoint for each of `group`.
    fn write(&mut self, group: &[Job]) -> Result<Vec<Result<(), StoreError>>, Failed> {
        let Self { connection, file, identity } = self;
        identity.check(file).map_err(Failed::Outright)?;
        let failed = |error: rusqlite::Error| Failed::Together(call_failed(file, &error));
        let immediate = TransactionBehavior::Immediate;
        let begun = connection.transaction_with_behavior(immediate);
        let mut transaction = begun.map_err(|error| Failed::Outright(call_failed(file, &error)))?;
        let mut results = Vec::with_capacity(group.len());
        for job in group {
            let savepoint = transaction.savepoint().map_err(failed)?;
            let done = match &job.request {
                Request::Commit(changes) => {
                    changes.iter().try_for_each(|change| apply(&savepoint, change))
                }
                Request::Probe => savepoint.execute(PROBE, []).map(drop).map_err(Into::into),
                Request::Settle => Ok(()),
            };
            match done {
                Ok(()) => {
                    savepoint.commit().map_err(failed)?;
                    results.push(Ok(()));
                }
                Err(error) => {
                    let error = error.in_file(file);
                    drop(savepoint);
                    // Some errors end the whole transaction, with all that was made in it.
                    if transaction.is_autocommit() {
                        return Err(Failed::Together(error));
                    }
                    results.push(Err(error));
                }
            }
        }
        transaction.commit().map_err(failed)?;
        for (job, result) in group.iter().zip(&mut results) {
            if matches!(job.request, Request::Settle) {
                let settled =
                    connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()));
                *result = settled.map_err(|error| call_failed(file, &error));
            }
        }
        Ok(results)
    }
}

impl ApplyError {
    fn in_file(self, file: &Path) -> StoreError {
        match self {
            Self::Sqlite(error) => call_failed(file, &error),
            Self::Unfit(what) => StoreError::Rejected(what),
        }
    }
}

/// Which file is open: one that was moved or removed can be written to, and all of it would be lost.
#[derive(Debug, PartialEq, Eq)]
struct Identity(u64, u64);

fn identity(file: &Path) -> io::Result<Identity> {
    use std::os::unix::fs::MetadataExt;
    let metadata = std::fs::metadata(file)?;
    Ok(Identity(metadata.dev(), metadata.ino()))
}

impl Identity {
    fn check(&self, file: &Path) -> Result<(), StoreError> {
        let is_there = identity(file).is_ok_and(|found| found == *self);
        is_there.then_some(()).ok_or_else(|| {
            let file = file.display();
            StoreError::Unavailable(format!("{file} was moved or removed; put it back"))
        })
    }
}

/// Writes `requests` as one group, as if all of them had waited.
#[cfg(test)]
pub(super) fn write_together(
    connection: Connection,
    file: &Path,
    requests: Vec<Request>,
) -> Vec<Result<(), StoreError>> {
    let identity = identity(file).unwrap();
    let mut desk = Desk { connection, file: file.to_path_buf(), identity };
    let job = |request| Job { request, answer: sync_channel(1).0 };
    desk.write_group(&requests.into_iter().map(job).collect::<Vec<_>>())
}
