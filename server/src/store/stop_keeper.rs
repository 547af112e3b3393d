//! The way to the journal of stops for the async part of the server: one thread that writes, many words at a time.

use super::stop_journal::{Entry, StopJournal};
use std::collections::BTreeMap;
use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use tokio::runtime::{Handle, RuntimeFlavor};
use tokio::sync::oneshot;
use umwelt_api::RobotId;

/// Most requests that share one sync of the disk.
const MAX_GROUP: usize = 1024;

/// The journal, for all that write into it; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct StopKeeper {
    journal: Arc<Mutex<StopJournal>>,
    /// The way to the thread that writes; none where the caller's runtime has one thread, and nothing to step aside to.
    writer: Option<Sender<Append>>,
}

#[derive(Debug)]
struct Append {
    entries: Vec<Entry>,
    done: oneshot::Sender<io::Result<()>>,
}

impl StopKeeper {
    /// Starts the thread that writes, which ends with the last of the keepers.
    pub(crate) fn start(journal: StopJournal) -> io::Result<Self> {
        let journal = Arc::new(Mutex::new(journal));
        if Handle::current().runtime_flavor() != RuntimeFlavor::MultiThread {
            return Ok(Self { journal, writer: None });
        }
        let (writer, asked) = channel();
        let desk = Arc::clone(&journal);
        Builder::new().name("stops".to_owned()).spawn(move || run(&desk, &asked))?;
        Ok(Self { journal, writer: Some(writer) })
    }

    /// Writes `entries` down; they are on the disk once this comes to `Ok`. They are on their way when this returns,
    /// whether or not anybody waits for it.
    pub(crate) fn append(
        &self,
        entries: Vec<Entry>,
    ) -> impl Future<Output = io::Result<()>> + use<> {
        let (done, answer) = oneshot::channel();
        match &self.writer {
            // Where the thread has ended, `done` is dropped and the answer says so.
            Some(writer) => drop(writer.send(Append { entries, done })),
            None => drop(done.send(write(&self.journal, &entries))),
        }
        async move { answer.await.unwrap_or_else(|_| Err(io::Error::other("its thread has ended"))) }
    }

    /// Empties the journal where the store holds all that it says, as [`StopJournal::clear`].
    pub(crate) async fn clear(&self, held: BTreeMap<RobotId, u64>) -> io::Result<bool> {
        let journal = Arc::clone(&self.journal);
        let clear = move || journal.lock().unwrap_or_else(PoisonError::into_inner).clear(&held);
        tokio::task::spawn_blocking(clear).await.unwrap_or_else(|error| Err(error.into()))
    }
}

/// Writes what is asked for until no one can ask any more: all that waits in one go.
fn run(journal: &Mutex<StopJournal>, asked: &Receiver<Append>) {
    while let Ok(first) = asked.recv() {
        let group = std::iter::once(first).chain(asked.try_iter().take(MAX_GROUP - 1));
        let (entries, done): (Vec<_>, Vec<_>) = group.map(|it| (it.entries, it.done)).unzip();
        let written = write(journal, &entries.concat());
        for done in done {
            let result = match &written {
                Ok(()) => Ok(()),
                Err(error) => Err(same(error)),
            };
            // Whoever asked may have given up.
            let _ = done.send(result);
        }
    }
}

fn write(journal: &Mutex<StopJournal>, entries: &[Entry]) -> io::Result<()> {
    // What it says of itself is whole whatever happened behind the lock: lengths change after writes.
    journal.lock().unwrap_or_else(PoisonError::into_inner).append(entries)
}

/// Errors of the system cannot be cloned.
fn same(error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), error.to_string())
}
