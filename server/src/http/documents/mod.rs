//! Figures, tables and reports: made once, kept, and not sent again to whoever has them.
//!
//! Invariants: a document is made by one thread at a time however many ask for it, and no more than [`AT_A_TIME`] of all
//! are made at a time, by threads that give way to the control of robots; who waits beyond [`WAITING`] is refused; what
//! is kept, and what is still being read by someone, has a bound in bytes.

mod document;
mod shelf;

pub(crate) use document::{Document, Name};

use crate::resource::change::to_the_end;
use crate::resource::etag;
use crate::resource::failure::{self, Failure};
use bytes::Bytes;
use shelf::Shelf;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

/// Documents that are made at a time.
const AT_A_TIME: usize = 2;

/// Documents that wait to be made: each takes tenths of a second, and a request waits 15 s.
const WAITING: usize = 32;

/// Memory of documents that someone may still be reading beside those that are kept, as a multiple of these.
const READ: usize = 2;

/// Niceness of the threads that make them: a tenth of the weight of a thread that controls robots. At the lowest
/// priority, that of jobs, no one would get a figure while a job runs.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 10;

/// The documents of a server; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Documents(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    shelf: Mutex<Shelf>,
    limit: usize,
    /// Bytes of all documents that are somewhere.
    alive: Arc<AtomicUsize>,
    makers: Arc<Semaphore>,
    waiting: Semaphore,
}

/// The bytes of a document, counted while they are somewhere.
struct Counted {
    text: String,
    alive: Arc<AtomicUsize>,
}

impl AsRef<[u8]> for Counted {
    fn as_ref(&self) -> &[u8] {
        self.text.as_bytes()
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.alive.fetch_sub(self.text.len(), Ordering::Relaxed);
    }
}

impl Documents {
    /// Keeps so many bytes of them.
    pub(crate) fn new(limit: usize) -> Self {
        Self(Arc::new(Inner {
            shelf: Mutex::new(Shelf::new(limit)),
            limit,
            alive: Arc::default(),
            makers: Arc::new(Semaphore::new(AT_A_TIME)),
            waiting: Semaphore::new(WAITING),
        }))
    }

    /// The document by that name. Where there is none yet, `source` fetches what it is made of, and `make` makes it on a
    /// thread of its own; that goes on when no one waits for it any more.
    ///
    /// # Errors
    /// Where it cannot be made, or too many are to be made already.
    pub(crate) async fn get<T: Send + 'static>(
        &self,
        name: Name,
        media_type: &'static str,
        source: impl Future<Output = Result<T, Failure>> + Send + 'static,
        make: impl FnOnce(T) -> Result<String, Failure> + Send + 'static,
    ) -> Result<Document, Failure> {
        let place = self.shelf().place(name);
        if let Some(document) = place.get() {
            return Ok(document.clone());
        }
        let documents = self.clone();
        to_the_end(async move {
            let made = place.get_or_try_init(|| documents.make(media_type, source, make)).await;
            let mut shelf = documents.shelf();
            match &made {
                Ok(document) => shelf.keep(name, document.bytes.len()),
                Err(_) => shelf.clear(name),
            }
            made.cloned()
        })
        .await
    }

    async fn make<T: Send + 'static>(
        &self,
        media_type: &'static str,
        source: impl Future<Output = Result<T, Failure>>,
        make: impl FnOnce(T) -> Result<String, Failure> + Send + 'static,
    ) -> Result<Document, Failure> {
        let waiting = self.0.waiting.try_acquire();
        let is_read = self.0.alive.load(Ordering::Relaxed) > READ * self.0.limit;
        let Some(_waiting) = waiting.ok().filter(|_| !is_read) else {
            return Err(failure::limit_reached("documents to be made", WAITING));
        };
        let turn = Arc::clone(&self.0.makers).acquire_owned().await;
        let turn = turn.map_err(|error| failure::internal(error.to_string()))?;
        let source = source.await?;
        let text = aside(turn, move || make(source)).await?;
        self.0.alive.fetch_add(text.len(), Ordering::Relaxed);
        let etag = etag::of_bytes(text.as_bytes());
        let bytes = Bytes::from_owner(Counted { text, alive: Arc::clone(&self.0.alive) });
        Ok(Document { bytes, etag, media_type })
    }

    fn shelf(&self) -> MutexGuard<'_, Shelf> {
        // No call panics between two changes, so a poisoned shelf is whole.
        self.0.shelf.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Does `work` on a thread that gives way to others; the turn is over when it is done.
async fn aside(
    turn: OwnedSemaphorePermit,
    work: impl FnOnce() -> Result<String, Failure> + Send + 'static,
) -> Result<String, Failure> {
    let (done, made) = oneshot::channel();
    let work = move || {
        give_way();
        // What a panic leaves half done is not used any more.
        let made = catch_unwind(AssertUnwindSafe(work));
        drop(turn);
        // A panic shows as an answer that does not come.
        if let Ok(made) = made {
            let _ = done.send(made);
        }
    };
    let thread = std::thread::Builder::new().name("documents".to_owned()).spawn(work);
    thread.map_err(|error| failure::internal(format!("no thread for a document: {error}")))?;
    made.await.unwrap_or_else(|_| Err(failure::internal("the document could not be made")))
}

/// Puts the calling thread behind those that control robots.
fn give_way() {
    // Of no thread but the calling one; other systems would mean the whole process.
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::setpriority_process(None, NICENESS) {
        tracing::debug!(%error, "documents are made at normal priority");
    }
}

#[cfg(test)]
mod tests;
