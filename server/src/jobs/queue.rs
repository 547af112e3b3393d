//! The jobs of one kind: submitted, waiting, running, ended.
//!
//! Invariants: what is acknowledged is kept; numbers never come back. Locks are taken in this order: what a kind needs to
//! stay free, submitting, the change of one job.

use super::dispatch;
use super::inner::{Inner, Limits, unwritable};
use super::job::Job;
use super::record::{Checkpoint, Reached, Record, State};
use super::start::Start;
use super::work::Work;
use crate::resource::failure::{self, Failure};
use crate::store::{
    Change, Contents, JobId, Keeper, Kind, StoredJob, StoredKind, Unreadable, Unreadables,
};
use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::{Mutex, MutexGuard, Notify, watch};
use umwelt_api::IdempotencyKey;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_lab::evaluator::Evaluator;
use umwelt_lab::pool::Pool;

/// The jobs of one kind; cheap to clone. They stop when the last clone is dropped, and go on with the next server on
/// the same store.
#[derive(Clone)]
pub(crate) struct Jobs<W: Work> {
    inner: Arc<Inner<W>>,
    _end: Arc<End<W>>,
}

struct End<W: Work>(Arc<Inner<W>>);

impl<W: Work> Drop for End<W> {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// What is submitted.
pub(crate) struct Submission<W: Work> {
    pub(crate) settings: W::Settings,
    pub(crate) key: Option<IdempotencyKey>,
    /// Hash of the request.
    pub(crate) request: String,
}

/// The right to submit: one caller has it at a time.
pub(crate) struct Submitting<'a, W: Work> {
    inner: &'a Inner<W>,
    last: MutexGuard<'a, u64>,
}

impl<W: Work> Jobs<W> {
    /// The jobs that the store keeps; those that have not ended go on, what cannot be read is noted.
    ///
    /// # Errors
    /// Where a checkpoint cannot be had from the store.
    pub(crate) async fn open(
        limits: Limits,
        pool: Arc<Pool>,
        keeper: Keeper,
        services: W::Services,
        contents: &Contents,
        unreadable: &Unreadables,
    ) -> io::Result<Self> {
        let mut jobs = BTreeMap::new();
        for stored in contents.jobs_of(W::KIND) {
            match restore(stored, &keeper).await? {
                Ok(job) => drop(jobs.insert(stored.id.number, Arc::new(job))),
                Err(why) => unreadable.add(why),
            }
        }
        let inner = Arc::new(Inner {
            jobs: RwLock::new(jobs),
            last: Mutex::new(contents.last_number(W::KIND)),
            keeper,
            services,
            evaluator: Arc::clone(&pool) as Arc<dyn Evaluator<W>>,
            pool,
            wake: Notify::new(),
            closing: watch::Sender::new(false),
            ended: watch::Sender::new(false),
            limits,
        });
        tokio::spawn(dispatch::run(Arc::clone(&inner)));
        Ok(Self { _end: Arc::new(End(Arc::clone(&inner))), inner })
    }

    /// The job of this id.
    pub(crate) fn find(&self, id: &str) -> Option<Arc<Job<W>>> {
        let number = number(W::KIND, id)?;
        // Not by another spelling of its number.
        self.inner.jobs().get(&number).filter(|job| job.id().to_string() == id).cloned()
    }

    /// Those of numbers below `before`, the newest first.
    pub(crate) fn below(&self, before: Option<u64>) -> Vec<Arc<Job<W>>> {
        let jobs = self.inner.jobs();
        jobs.range(..before.unwrap_or(u64::MAX)).rev().map(|(_, job)| Arc::clone(job)).collect()
    }

    /// Begins to submit: no other caller does until what is returned is dropped.
    pub(crate) async fn submitting(&self) -> Submitting<'_, W> {
        Submitting { inner: &self.inner, last: self.inner.last.lock().await }
    }

    /// Ends a job for good; one that was cancelled already is left as it is.
    pub(crate) async fn cancel(&self, job: &Job<W>) -> Result<(), Failure> {
        {
            let _changing = job.changing.lock().await;
            if job.state() == State::Queued {
                let record = Record { state: State::Cancelled, ..(*job.shown().record).clone() };
                self.inner.keeper.commit(self.inner.ending(job, &record, Vec::new())?).await?;
                self.inner.show_ended(job, record);
                return Ok(());
            }
        }
        let (mut follow, mut closing) = (job.follow(), self.inner.closing.subscribe());
        let mut has_ended = follow.borrow_and_update().has_ended();
        if !has_ended {
            job.cancel();
        }
        while !has_ended {
            tokio::select! {
                changed = follow.changed() => changed.map_err(|_| failure::draining())?,
                _ = closing.wait_for(|closing| *closing) => return Err(failure::draining()),
            }
            let shown = follow.borrow_and_update();
            has_ended = shown.has_ended();
            if let Some(trouble) = shown.trouble.as_deref().filter(|_| !has_ended) {
                let message = format!("{} has stopped, which is not kept yet: {trouble}", job.id());
                let remedy = "ask again when the store works; without, it goes on after a restart";
                let detail = Detail::new(reason::STORE_FAILED, "", (), remedy);
                return Err(Failure::new(Status::Unavailable, message).with(detail));
            }
        }
        match job.state() {
            State::Cancelled => Ok(()),
            state => {
                let how = if state == State::Succeeded { "succeeded" } else { "failed" };
                let (kind, id) = (W::KIND.name(), job.id().to_string());
                let message = format!("{id} has {how} already");
                let detail = Detail::new(reason::ENDED, kind, id, "remove it");
                Err(Failure::new(Status::FailedPrecondition, message).with(detail))
            }
        }
    }

    /// Forgets a job that has ended, with its parts; what it gave stays.
    pub(crate) async fn delete(&self, job: &Job<W>) -> Result<(), Failure> {
        let _changing = job.changing.lock().await;
        let (kind, id) = (W::KIND.name(), job.id().to_string());
        if !job.state().has_ended() {
            let message = format!("{id} has not ended");
            let remedy = format!("cancel it first: POST /v1/{kind}s/{{{kind}}}/cancel");
            let detail = Detail::new(reason::NOT_ENDED, kind, id, remedy);
            return Err(Failure::new(Status::FailedPrecondition, message).with(detail));
        }
        if job.shown().removed {
            return Err(failure::no_such(kind, &id));
        }
        self.inner.keeper.commit(vec![Change::DeleteJob(job.id())]).await?;
        self.inner.remove(job.id());
        Ok(())
    }

    /// Forgets a job that cannot be read, with its parts.
    pub(crate) async fn give_up(&self, id: &str) -> Result<(), Failure> {
        let Some(number) = number(W::KIND, id) else {
            return Err(failure::no_such(W::KIND.name(), id));
        };
        let id = JobId { kind: W::KIND, number };
        self.inner.keeper.commit(vec![Change::DeleteJob(id)]).await
    }

    /// Begins to stop: what runs stops at the next episode, and stays running in the store.
    pub(crate) fn close(&self) {
        self.inner.close();
    }

    /// Waits until nothing runs any more.
    pub(crate) async fn closed(&self) {
        // The sender lives as long as this.
        let _ = self.inner.ended.subscribe().wait_for(|ended| *ended).await;
    }
}

impl<W: Work> Submitting<'_, W> {
    /// The job that was submitted under this key; another request under the key is refused.
    pub(crate) fn repeated(
        &self,
        key: &IdempotencyKey,
        request: &str,
    ) -> Result<Option<Arc<Job<W>>>, Failure> {
        let jobs = self.inner.jobs();
        let is_same = |job: &&Arc<Job<W>>| job.shown().record.key.as_deref() == Some(key.as_str());
        let Some(job) = jobs.values().rev().find(is_same) else { return Ok(None) };
        if job.shown().record.request == request {
            return Ok(Some(Arc::clone(job)));
        }
        let message = format!("the key came with another body before, for {}", job.id());
        let detail = Detail::new(
            reason::IDEMPOTENCY_KEY_REUSED,
            IdempotencyKey::HEADER,
            key.as_str(),
            format!("use a new key for a new {}", W::KIND),
        );
        Err(Failure::new(Status::FailedPrecondition, message).with(detail))
    }

    /// Queues a job. `own` gives it a number from the one that it is called with on, and what is its own; what that needs
    /// to stay free the caller holds.
    pub(crate) async fn submit(
        &mut self,
        submission: Submission<W>,
        own: impl FnOnce(u64) -> Result<(u64, W::Own), Failure>,
    ) -> Result<Arc<Job<W>>, Failure> {
        let inner = self.inner;
        if *inner.closing.borrow() {
            return Err(failure::draining());
        }
        let queued = inner.jobs().values().filter(|job| job.state() == State::Queued).count();
        if queued >= inner.limits.queued {
            let message = format!("{queued} {}s wait already, which is the limit", W::KIND);
            let remedy = "wait until one has ended, or cancel one";
            let detail = Detail::new(reason::QUEUE_FULL, "", inner.limits.queued, remedy);
            return Err(Failure::new(Status::ResourceExhausted, message).with(detail));
        }
        let next = self.last.checked_add(1);
        let next = next.ok_or_else(|| failure::internal("there are no more numbers"))?;
        let (number, own) = own(next)?;
        let Submission { settings, key, request } = submission;
        let work = W::new(settings.clone()).map_err(failure::internal)?;
        let record = Record {
            state: State::Queued,
            interrupted: 0,
            created_unix: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |it| it.as_secs()),
            settings,
            own,
            key: key.map(|key| key.to_string()),
            request,
            error: None,
            report: None,
            reached: Reached::nothing(&work),
        };
        let id = JobId { kind: W::KIND, number };
        let stored = record.stored(id).map_err(unwritable)?;
        inner.keeper.commit(vec![Change::PutJob(stored)]).await?;
        *self.last = number;
        let job = Arc::new(Job::new(id, record, Start::Fresh));
        inner.jobs.write().unwrap_or_else(PoisonError::into_inner).insert(number, Arc::clone(&job));
        inner.wake.notify_one();
        Ok(job)
    }
}

/// The number in the id of a job.
fn number(kind: StoredKind, id: &str) -> Option<u64> {
    id.strip_prefix(kind.name())?.strip_prefix('-')?.parse().ok()
}

/// The job that is kept, or why it cannot be read.
async fn restore<W: Work>(
    stored: &StoredJob,
    keeper: &Keeper,
) -> io::Result<Result<Job<W>, Unreadable>> {
    let mut record = match Record::<W>::read(&stored.body) {
        Ok(record) => record,
        Err(why) => {
            let kind = Kind::Job(stored.id.kind);
            return Ok(Err(Unreadable::new(kind, stored.id.to_string(), &why)));
        }
    };
    let mut start = Start::Fresh;
    if record.state == State::Running {
        record.interrupted += 1;
        let body = keeper.checkpoint(stored.id).await;
        let body = body.map_err(|failure| io::Error::other(failure.message().to_owned()))?;
        match body.map(|body| Checkpoint::read(&body, &record.settings)) {
            Some(Ok(checkpoint)) => {
                record.reached = checkpoint.reached();
                start = Start::From(Box::new(checkpoint));
            }
            Some(Err(error)) => {
                let remedy = "submit it again: the same seed gives the same result";
                start = Start::Broken(format!("its checkpoint cannot be used: {error}; {remedy}"));
            }
            None => {}
        }
    }
    Ok(Ok(Job::new(stored.id, record, start)))
}
