//! The way to the store for the async part of the server: calls off its threads, and whether the store works.

use super::{Change, Contents, JobId, Part, Store, StoreError};
use crate::resource::failure::{self, Failure};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;
use umwelt_api::problem::{Detail, Status, reason};

/// A store that does not answer for this long counts as down until it does.
const ANSWERS_WITHIN: Duration = Duration::from_secs(5);

/// The store, for all that keep something; cheap to clone.
#[derive(Clone)]
pub(crate) struct Keeper(Arc<Inner>);

struct Inner {
    store: Arc<dyn Store>,
    health: watch::Sender<Health>,
}

/// Whether the store works, as its last write showed.
#[derive(Clone, Debug)]
struct Health {
    /// When it answered last.
    since: Instant,
    fault: Option<StoreError>,
}

impl Keeper {
    pub(crate) fn new(store: Arc<dyn Store>) -> Self {
        let health = Health { since: Instant::now(), fault: None };
        Self(Arc::new(Inner { store, health: watch::Sender::new(health) }))
    }

    /// Makes changes: all or none of them, durable once this returns `Ok`.
    pub(crate) async fn commit(&self, changes: Vec<Change>) -> Result<(), Failure> {
        self.write(move |store| store.commit(changes)).await
    }

    /// Everything that is kept but parts and checkpoints.
    pub(crate) async fn load(&self) -> Result<Contents, StoreError> {
        let store = Arc::clone(&self.0.store);
        let loaded = tokio::task::spawn_blocking(move || store.load()).await;
        loaded.unwrap_or_else(|error| Err(StoreError::Damaged(error.to_string())))
    }

    /// The parts of a job from index `from` on, at most `limit`.
    pub(crate) async fn parts(
        &self,
        job: JobId,
        from: usize,
        limit: usize,
    ) -> Result<Vec<Part>, Failure> {
        self.read(move |store| store.parts(job, from, limit)).await
    }

    /// The checkpoint of a job.
    pub(crate) async fn checkpoint(&self, job: JobId) -> Result<Option<String>, Failure> {
        self.read(move |store| store.checkpoint(job)).await
    }

    /// Tries whether the store works where that is not known since `idle`, or where it did not.
    pub(crate) async fn probe(&self, idle: Duration) {
        let is_due = {
            let health = self.0.health.borrow();
            health.fault.is_some() || health.since.elapsed() >= idle
        };
        if is_due {
            // What came out shows in the health.
            let _ = self.write(|store| store.probe()).await;
        }
    }

    /// Tidies the store up before the process ends.
    pub(crate) async fn settle(&self) {
        if let Err(failure) = self.read(|store| store.settle()).await {
            tracing::warn!(?failure, "cannot tidy up store; nothing is lost");
        }
    }

    /// Why the store is down, where it is.
    pub(crate) fn fault(&self) -> Option<StoreError> {
        self.0.health.borrow().fault.clone()
    }

    async fn write(
        &self,
        call: impl FnOnce(&dyn Store) -> Result<(), StoreError> + Send + 'static,
    ) -> Result<(), Failure> {
        let store = Arc::clone(&self.0.store);
        let mut calling = tokio::task::spawn_blocking(move || call(&*store));
        let answer = match tokio::time::timeout(ANSWERS_WITHIN, &mut calling).await {
            Ok(answer) => answer,
            Err(_) => {
                self.note(&Err(StoreError::Unavailable("it does not answer".to_owned())));
                calling.await
            }
        };
        match answer {
            Ok(result) => {
                self.note(&result);
                Ok(result?)
            }
            Err(error) => {
                self.note(&Err(StoreError::Unavailable(error.to_string())));
                Err(failure::broken(&error))
            }
        }
    }

    async fn read<T: Send + 'static>(
        &self,
        call: impl FnOnce(&dyn Store) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, Failure> {
        let store = Arc::clone(&self.0.store);
        match tokio::task::spawn_blocking(move || call(&*store)).await {
            Ok(result) => Ok(result?),
            Err(error) => Err(failure::broken(&error)),
        }
    }

    /// Takes in how a write went; says so where that is news.
    fn note(&self, result: &Result<(), StoreError>) {
        let fault = match result {
            // It says something about what was to be kept, nothing about the store.
            Err(StoreError::Rejected(_)) => return,
            Err(fault) => Some(fault.clone()),
            Ok(()) => None,
        };
        self.0.health.send_modify(|health| {
            match (&health.fault, &fault) {
                (None, Some(fault)) => {
                    tracing::error!(%fault, "cannot write to store; robots that drive go on driving");
                }
                (Some(_), None) => tracing::info!("store works again"),
                _ => {}
            }
            *health = Health { since: Instant::now(), fault };
        });
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        let status = match error {
            StoreError::Unavailable(_) => Status::Unavailable,
            StoreError::Damaged(_) => Status::DataLoss,
            StoreError::Rejected(_) => Status::Internal,
        };
        let remedy = "nothing was changed; robots that drive go on driving";
        Self::new(status, error.to_string()).with(Detail::new(reason::STORE_FAILED, "", (), remedy))
    }
}
