//! The evolutions of a server: submitted, waiting, running, ended.
//!
//! Invariants: what is acknowledged is kept; numbers never come back; no two evolutions that have not ended give their
//! champions the same name. Locks are taken in this order: the names of priors, submitting, the change of one evolution.

use super::dispatch;
use super::job::Job;
use super::record::{Checkpoint, Reached, Record, State};
use super::run::Pool;
use crate::failure::{self, Failure};
use crate::priors::Priors;
use crate::store::{Change, Contents, Keeper, StoredEvolution, prune};
use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::{Mutex, MutexGuard, Notify, watch};
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::{EvolutionId, IdempotencyKey, PriorId};
use umwelt_core::evolution::{Evolution, EvolutionSettings};

/// The evolutions of a server; cheap to clone. They stop when the last clone is dropped, and go on with the next server
/// on the same store.
#[derive(Clone)]
pub(crate) struct Evolutions {
    inner: Arc<Inner>,
    _end: Arc<End>,
}

/// What the dispatcher shares with those who submit, watch and cancel.
pub(super) struct Inner {
    jobs: RwLock<BTreeMap<u64, Arc<Job>>>,
    /// The highest number that was ever given; held by whoever submits.
    last: Mutex<u64>,
    pub(super) keeper: Keeper,
    pub(super) priors: Priors,
    pub(super) pool: Arc<Pool>,
    pub(super) wake: Notify,
    pub(super) closing: watch::Sender<bool>,
    /// Set once the dispatcher has ended.
    pub(super) ended: watch::Sender<bool>,
    max_queued: usize,
    /// How many that have ended are kept; at least one.
    keep: usize,
}

struct End(Arc<Inner>);

impl Drop for End {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// What is submitted.
pub(crate) struct Submission {
    pub(crate) settings: EvolutionSettings,
    /// The name that the champion is to have; that of the evolution where none is said.
    pub(crate) prior: Option<PriorId>,
    pub(crate) key: Option<IdempotencyKey>,
    /// Hash of the request.
    pub(crate) request: String,
}

/// Somebody is submitting.
pub(crate) struct Submitting<'a> {
    evolutions: &'a Evolutions,
    last: MutexGuard<'a, u64>,
}

/// Where an evolution is taken up when its turn comes.
#[derive(Debug)]
pub(super) enum Start {
    /// At the beginning.
    Fresh,
    /// Where it was when the server before ended.
    From(Box<Checkpoint>),
    /// Nowhere, and why.
    Broken(String),
}

impl Evolutions {
    /// The evolutions that the store keeps; those that have not ended go on.
    ///
    /// # Errors
    /// Where a checkpoint cannot be had from the store, or threads from the system.
    pub(crate) async fn open(
        limits: (usize, usize),
        pool: Pool,
        keeper: Keeper,
        priors: Priors,
        contents: &Contents,
    ) -> io::Result<Self> {
        let mut jobs = BTreeMap::new();
        for stored in &contents.evolutions {
            if let Some(job) = restore(stored, &keeper).await? {
                jobs.insert(stored.number, Arc::new(job));
            }
        }
        let inner = Arc::new(Inner {
            jobs: RwLock::new(jobs),
            last: Mutex::new(contents.last_evolution),
            keeper,
            priors,
            pool: Arc::new(pool),
            wake: Notify::new(),
            closing: watch::Sender::new(false),
            ended: watch::Sender::new(false),
            max_queued: limits.0,
            keep: limits.1.max(1),
        });
        tokio::spawn(dispatch::run(Arc::clone(&inner)));
        Ok(Self { _end: Arc::new(End(Arc::clone(&inner))), inner })
    }

    /// The evolution of this id.
    pub(crate) fn find(&self, id: &EvolutionId) -> Option<Arc<Job>> {
        let number = id.as_str().strip_prefix("evolution-")?.parse().ok()?;
        // Not by another spelling of its number.
        self.inner.jobs().get(&number).filter(|job| job.id() == id).cloned()
    }

    /// Those of numbers below `before`, the newest first.
    pub(crate) fn below(&self, before: Option<u64>) -> Vec<Arc<Job>> {
        let jobs = self.inner.jobs();
        jobs.range(..before.unwrap_or(u64::MAX)).rev().map(|(_, job)| Arc::clone(job)).collect()
    }

    /// The evolution that has not ended and will give its champion this name.
    pub(crate) fn reserves(&self, prior: &PriorId) -> Option<EvolutionId> {
        let jobs = self.inner.jobs();
        let reserves = |job: &&Arc<Job>| {
            let record = job.shown().record;
            !record.state.has_ended() && record.prior == *prior
        };
        jobs.values().find(reserves).map(|job| job.id().clone())
    }

    /// Begins to submit: nobody else does until what is returned is dropped.
    pub(crate) async fn submitting(&self) -> Submitting<'_> {
        Submitting { evolutions: self, last: self.inner.last.lock().await }
    }

    /// Ends an evolution for good; one that was cancelled already is left as it is.
    pub(crate) async fn cancel(&self, job: &Job) -> Result<(), Failure> {
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
                let name = umwelt_api::evolution::State::from(state).name();
                let message = format!("{} has {name} already", job.id());
                let detail =
                    Detail::new(reason::ENDED, "evolution", job.id().as_str(), "remove it");
                Err(Failure::new(Status::FailedPrecondition, message).with(detail))
            }
        }
    }

    /// Forgets an evolution that has ended, with its generations; the prior stays.
    pub(crate) async fn delete(&self, job: &Job) -> Result<(), Failure> {
        let _changing = job.changing.lock().await;
        if !job.state().has_ended() {
            let message = format!("{} has not ended", job.id());
            let remedy = "cancel it first: POST /v1/evolutions/{evolution}/cancel";
            let detail = Detail::new(reason::NOT_ENDED, "evolution", job.id().as_str(), remedy);
            return Err(Failure::new(Status::FailedPrecondition, message).with(detail));
        }
        if job.shown().removed {
            return Err(failure::no_such("evolution", job.id().as_str()));
        }
        let id = job.id().to_string();
        self.inner.keeper.commit(vec![Change::DeleteEvolution(id)]).await?;
        self.inner.remove(job.number());
        Ok(())
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

impl Submitting<'_> {
    /// The evolution that was submitted under this key; another request under the key is refused.
    pub(crate) fn repeated(
        &self,
        key: &IdempotencyKey,
        request: &str,
    ) -> Result<Option<Arc<Job>>, Failure> {
        let jobs = self.evolutions.inner.jobs();
        let is_same = |job: &&Arc<Job>| job.shown().record.key.as_deref() == Some(key.as_str());
        let Some(job) = jobs.values().rev().find(is_same) else { return Ok(None) };
        if job.shown().record.request == request {
            return Ok(Some(Arc::clone(job)));
        }
        let message = format!("the key came with another body before, for {}", job.id());
        let detail = Detail::new(
            reason::IDEMPOTENCY_KEY_REUSED,
            IdempotencyKey::HEADER,
            key.as_str(),
            "use a new key for a new evolution",
        );
        Err(Failure::new(Status::FailedPrecondition, message).with(detail))
    }

    /// Queues an evolution. The caller holds the names of priors, so that the champion's stays free.
    pub(crate) async fn submit(&mut self, submission: Submission) -> Result<Arc<Job>, Failure> {
        let inner = &self.evolutions.inner;
        if *inner.closing.borrow() {
            return Err(failure::draining());
        }
        let queued = inner.jobs().values().filter(|job| job.state() == State::Queued).count();
        if queued >= inner.max_queued {
            let message = format!("{queued} evolutions wait already, which is the limit");
            let remedy = "wait until one has ended, or cancel one";
            let detail = Detail::new(reason::QUEUE_FULL, "", inner.max_queued, remedy);
            return Err(Failure::new(Status::ResourceExhausted, message).with(detail));
        }
        let Submission { settings, prior, key, request } = submission;
        if let Some(name) = &prior {
            self.check_free(name)?;
        }
        let is_free = |number: u64| match EvolutionId::numbered(number).as_str().parse() {
            Ok(name) => prior.is_some() || self.check_free(&name).is_ok(),
            Err(_) => false,
        };
        let number = (*self.last + 1..).find(|number| is_free(*number));
        let number = number.ok_or_else(|| failure::internal("there are no more numbers"))?;
        let prior = prior.or_else(|| EvolutionId::numbered(number).as_str().parse().ok());
        let prior = prior.ok_or_else(|| failure::internal("an evolution's id is no name"))?;
        let evolution = Evolution::new(settings.clone());
        let evolution = evolution.map_err(|error| failure::internal(error.to_string()))?;
        let record = Record {
            state: State::Queued,
            interrupted: 0,
            created_unix: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |it| it.as_secs()),
            settings,
            prior,
            key: key.map(|key| key.to_string()),
            request,
            error: None,
            report: None,
            reached: Reached { stage: None, ..Reached::of(&evolution, None, 0.0) },
        };
        let stored = record.stored(number).map_err(unwritable)?;
        inner.keeper.commit(vec![Change::PutEvolution(stored)]).await?;
        *self.last = number;
        let job = Arc::new(Job::new(number, record, Start::Fresh));
        inner.jobs.write().unwrap_or_else(PoisonError::into_inner).insert(number, Arc::clone(&job));
        inner.wake.notify_one();
        Ok(job)
    }

    /// Whether a champion can have this name.
    fn check_free(&self, name: &PriorId) -> Result<(), Failure> {
        let taken = if self.evolutions.inner.priors.all().find(name).is_some() {
            format!("there is a prior {name} already")
        } else if let Some(evolution) = self.evolutions.reserves(name) {
            format!("{evolution} will give its champion the name {name}")
        } else {
            return Ok(());
        };
        let detail = Detail::new(reason::NAME_TAKEN, "prior", name.as_str(), "choose another name");
        Err(Failure::new(Status::AlreadyExists, taken).with(detail))
    }
}

impl Inner {
    fn jobs(&self) -> std::sync::RwLockReadGuard<'_, BTreeMap<u64, Arc<Job>>> {
        self.jobs.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The evolution whose turn it is: the oldest that has not ended.
    pub(super) fn next(&self) -> Option<Arc<Job>> {
        self.jobs().values().find(|job| !job.state().has_ended()).cloned()
    }

    fn close(&self) {
        self.closing.send_replace(true);
        for job in self.jobs().values() {
            job.meter.stop();
        }
    }

    /// The changes that end an evolution, so that `record` is left of it, and what else goes with them; the oldest that
    /// have ended go where there are too many.
    pub(super) fn ending(
        &self,
        job: &Job,
        record: &Record,
        more: Vec<Change>,
    ) -> Result<Vec<Change>, Failure> {
        let id = job.id().to_string();
        let stored = record.stored(job.number()).map_err(unwritable)?;
        let mut changes = vec![Change::PutEvolution(stored), Change::DeleteCheckpoint(id)];
        changes.extend(more);
        changes.extend(prune(&self.others_ended(job), self.keep - 1));
        Ok(changes)
    }

    /// Shows how an evolution has ended, and no more those that went for it.
    pub(super) fn show_ended(&self, job: &Job, record: Record) {
        job.show(record);
        let others = self.others_ended(job);
        let excess = others.len().saturating_sub(self.keep - 1);
        others.iter().take(excess).for_each(|ended| self.remove(ended.number));
    }

    /// All others that have ended, the oldest first; without what stands in them. One that has just ended stays,
    /// however old it is: somebody waits for it.
    fn others_ended(&self, job: &Job) -> Vec<StoredEvolution> {
        let jobs = self.jobs();
        let ended =
            jobs.values().filter(|it| it.state().has_ended() && it.number() != job.number());
        let stored = ended.map(|job| StoredEvolution {
            id: job.id().to_string(),
            number: job.number(),
            finished: true,
            body: String::new(),
        });
        stored.collect()
    }

    fn remove(&self, number: u64) {
        let job = self.jobs.write().unwrap_or_else(PoisonError::into_inner).remove(&number);
        if let Some(job) = job {
            job.show_removed();
        }
    }
}

/// What is to be kept cannot be written down.
pub(super) fn unwritable(error: serde_json::Error) -> Failure {
    failure::internal(format!("it cannot be written down: {error}"))
}

/// The evolution that is kept; none where its record cannot be read.
async fn restore(stored: &StoredEvolution, keeper: &Keeper) -> io::Result<Option<Job>> {
    let mut record = match Record::read(&stored.body) {
        Ok(record) => record,
        Err(error) => {
            tracing::error!(evolution = stored.id, %error, "what is kept of it cannot be used");
            return Ok(None);
        }
    };
    let mut start = Start::Fresh;
    if record.state == State::Running {
        record.interrupted += 1;
        let body = keeper.checkpoint(&stored.id).await;
        let body = body.map_err(|failure| io::Error::other(failure.message().to_owned()))?;
        match body.map(|body| Checkpoint::read(&body)) {
            Some(Ok(checkpoint)) => {
                let Checkpoint { evolution, fitness, elapsed } = &checkpoint;
                record.reached = Reached::of(evolution, *fitness, *elapsed);
                start = Start::From(Box::new(checkpoint));
            }
            Some(Err(error)) => {
                let remedy = "submit it again: the same seed gives the same champion";
                start = Start::Broken(format!("its checkpoint cannot be used: {error}; {remedy}"));
            }
            None => {}
        }
    }
    Ok(Some(Job::new(stored.number, record, start)))
}
