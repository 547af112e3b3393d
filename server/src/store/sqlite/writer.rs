//! The one thread that writes. It takes all that waits into one transaction, so that many changes share one sync of the
//! disk, with a savepoint around each, so that one that cannot be made fails alone.

use super::access::{Access, Writing};
use super::apply::{ApplyError, apply};
use super::open::{BUSY, PROBE, call_failed};
use crate::store::{Change, StoreError};
#[cfg(test)]
use rusqlite::Connection;
use rusqlite::TransactionBehavior;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;
use thread_priority::{
    NormalThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Most requests of one group: a bound on what is lost together where the disk fails, far above what waits in practice.
const MAX_GROUP: usize = 256;

/// Nothing is written for this long: time to bring the write-ahead log into the file. Longer than the pauses of those who
/// write again and again, so that what they change again and again is brought in seldom.
pub(super) const IDLE: Duration = Duration::from_secs(6);

/// A quarter of the way from the lowest priority to the highest: niceness 9.
const LOW: u8 = 25;

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
    /// Starts the thread; after `idle` without a write the log goes into the file.
    pub(super) fn start(access: Access, idle: Duration) -> io::Result<Self> {
        let (jobs, asked) = channel();
        let desk = Desk { file: access.file(), access, has_log: false, idle };
        let thread = Builder::new().name("store".to_owned()).spawn(move || {
            step_back();
            desk.run(&asked);
        })?;
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

/// Puts the calling thread behind those that drive robots. Not behind all others, as those of jobs: where all cores are
/// busy it still gets a tenth of one, and whoever waits for a stop to be kept an answer.
fn step_back() {
    let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    let Ok(low) = ThreadPriorityValue::try_from(LOW) else { return };
    let low = ThreadPriority::Crossplatform(low);
    if let Err(error) = set_thread_priority_and_policy(thread_native_id(), low, policy) {
        tracing::debug!(%error, "the store's thread runs at normal priority");
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
    access: Access,
    file: PathBuf,
    /// Whether there is something in the write-ahead log alone that matters.
    has_log: bool,
    idle: Duration,
}

impl Desk {
    fn run(mut self, jobs: &Receiver<Job>) {
        loop {
            let first = match jobs.recv_timeout(self.idle) {
                Ok(first) => first,
                Err(RecvTimeoutError::Timeout) => {
                    self.fold_in_when_idle();
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => return,
            };
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
        let mut results = self.write_or_say(group);
        for (job, result) in group.iter().zip(&mut results) {
            if matches!(job.request, Request::Settle) {
                // Even where the log has lost its name: this is the last chance to keep what is in it.
                *result = self.fold_in();
            }
        }
        results
    }

    fn write_or_say(&mut self, group: &[Job]) -> Vec<Result<(), StoreError>> {
        match self.write(group) {
            Ok(results) => results,
            Err(Failed::Together(_)) if group.len() > 1 => {
                let alone = |job| self.write_or_say(std::slice::from_ref(job)).pop();
                group.iter().filter_map(alone).collect()
            }
            Err(Failed::Outright(error) | Failed::Together(error)) => {
                group.iter().map(|_| Err(error.clone())).collect()
            }
        }
    }

    /// One transaction with a savepoint for each of `group`.
    fn write(&mut self, group: &[Job]) -> Result<Vec<Result<(), StoreError>>, Failed> {
        if let Err(error) = self.access.ready().and_then(|writing| writing.watched.check()) {
            // A log that has lost its name is lost with the process.
            self.fold_in_when_idle();
            return Err(Failed::Outright(error));
        }
        let Self { access, file, has_log, .. } = self;
        let Writing { connection, watched } = access.ready().map_err(Failed::Outright)?;
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
        *has_log |= group.iter().any(|job| matches!(job.request, Request::Commit(_)));
        // One that was moved meanwhile has taken it along.
        watched.check().map_err(Failed::Outright)?;
        Ok(results)
    }

    /// Brings the write-ahead log into the file once nothing has been written for a while: then all that matters is in one
    /// file. Tries that are of no use change nothing in the log, and do not count.
    fn fold_in_when_idle(&mut self) {
        if self.has_log
            && let Err(error) = self.fold_in()
        {
            // A backup may be reading the log; the next time will do.
            tracing::debug!(%error, "the log is not brought into the file yet");
        }
    }

    /// Brings the write-ahead log into the file, without waiting for those who read it.
    fn fold_in(&mut self) -> Result<(), StoreError> {
        let Self { access, file, .. } = self;
        // Where the disk was full from the beginning, nothing was written.
        let Some(Writing { connection, .. }) = access.writing() else { return Ok(()) };
        let failed = |error| call_failed(file, &error);
        connection.busy_timeout(Duration::ZERO).map_err(failed)?;
        let fold_in = "PRAGMA wal_checkpoint(TRUNCATE)";
        let folded = connection.query_row(fold_in, [], |row| row.get::<_, bool>(0));
        connection.busy_timeout(BUSY).map_err(failed)?;
        match folded.map_err(failed)? {
            false => self.has_log = false,
            true => return Err(StoreError::Unavailable("somebody reads the log".to_owned())),
        }
        Ok(())
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

/// Writes `requests` as one group, as if all of them had waited.
#[cfg(test)]
pub(super) fn write_together(
    connection: Connection,
    file: &Path,
    requests: Vec<Request>,
) -> Vec<Result<(), StoreError>> {
    let access = Access::with(connection, file.to_path_buf()).unwrap();
    let mut desk = Desk { file: access.file(), access, has_log: false, idle: IDLE };
    let job = |request| Job { request, answer: sync_channel(1).0 };
    desk.write_group(&requests.into_iter().map(job).collect::<Vec<_>>())
}
