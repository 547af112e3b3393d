//! Runs the jobs of one kind, one at a time, and keeps each step of them.
//!
//! Invariants: nothing is shown as reached that is not kept; a store that fails delays a job and never ends it;
//! whatever goes wrong in one, the next has its turn. When the server ends, what runs stays running in the store.

use crate::jobs::inner::{Inner, unwritable};
use crate::jobs::job::Job;
use crate::jobs::record::{Checkpoint, Record, State, part_body};
use crate::jobs::start::Start;
use crate::jobs::work::{SuccessEffect, Work};
use crate::resource::failure::Failure;
use crate::store::{Change, JobId};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;
use umwelt_lab::evaluator::Halt;
use umwelt_lab::work::BatchOutcome;

/// First pause after the store has failed; each is twice the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(50);

/// Longest pause: a store that works again is noticed within this.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// Gives every job its turn until the server ends.
pub(super) async fn run<W: Work>(inner: Arc<Inner<W>>) {
    let mut closing = inner.closing.subscribe();
    loop {
        let job = tokio::select! {
            biased;
            _ = closing.wait_for(|closing| *closing) => break,
            job = next(&inner) => job,
        };
        let turn = Turn { inner: Arc::clone(&inner), job: Arc::clone(&job) };
        // In a task of its own: what panics ends its turn and nothing else.
        if let Err(error) = tokio::spawn(turn.take()).await {
            tracing::error!(job = %job.id(), kind = W::KIND.name(), %error, "job panicked");
            let turn = Turn { inner: Arc::clone(&inner), job };
            turn.end(Ending::Failed("the server made a mistake; its log says which".to_owned()))
                .await;
        }
    }
    inner.ended.send_replace(true);
}

async fn next<W: Work>(inner: &Inner<W>) -> Arc<Job<W>> {
    loop {
        let woken = inner.wake.notified();
        if let Some(job) = inner.next() {
            return job;
        }
        woken.await;
    }
}

/// One job, from its start to its end or to that of the server.
struct Turn<W: Work> {
    inner: Arc<Inner<W>>,
    job: Arc<Job<W>>,
}

/// How a job ends.
enum Ending<W: Work> {
    Succeeded {
        checkpoint: Box<Checkpoint<W>>,
        /// What the last batch has left.
        parts: Vec<Change>,
    },
    Failed(String),
    Cancelled,
}

/// What is to be kept of a batch, or why it did not come to its end.
type Stepped = Result<Result<Vec<Change>, serde_json::Error>, Halt>;

/// What became of changes that were to be kept.
enum Kept {
    Done,
    /// The job was cancelled meanwhile.
    Cancelled,
    /// The server ends, or the job has.
    Over,
    /// The store will never keep it.
    Refused(String),
}

impl<W: Work> Turn<W> {
    async fn take(self) {
        if let Some(ending) = self.go_on().await {
            self.end(ending).await;
        }
    }

    /// Runs it. Returns how it is to end; nothing where the server ends or the job was cancelled before it began.
    async fn go_on(&self) -> Option<Ending<W>> {
        let mut checkpoint = match self.job.take_start() {
            Start::From(checkpoint) => *checkpoint,
            Start::Broken(error) => return Some(Ending::Failed(error)),
            Start::Fresh => match W::new(self.job.shown().record.settings.clone()) {
                Ok(work) => Checkpoint { work, latest: None, elapsed: 0.0 },
                Err(error) => return Some(Ending::Failed(error)),
            },
        };
        let (before, begin) = (checkpoint.elapsed, Instant::now());
        let record = self.record(State::Running, &checkpoint);
        let stored = match record.stored(self.job.id()) {
            Ok(stored) => stored,
            Err(error) => return Some(Ending::Failed(error.to_string())),
        };
        let (job, interrupted) = (self.job.id(), record.interrupted);
        tracing::info!(%job, kind = W::KIND.name(), interrupted, "job started");
        let mut kept = self.keep(vec![Change::PutJob(stored)], record, None, true).await;
        loop {
            match kept {
                Kept::Done => {}
                Kept::Cancelled => return Some(Ending::Cancelled),
                Kept::Over => return None,
                Kept::Refused(error) => return Some(Ending::Failed(error)),
            }
            if let Some(reason) = checkpoint.work.failure() {
                return Some(Ending::Failed(reason));
            }
            let (stepped, outcome) = self.step(checkpoint, before, begin).await?;
            checkpoint = stepped;
            let changes = match outcome {
                Ok(Ok(changes)) => changes,
                Ok(Err(error)) => {
                    return Some(Ending::Failed(unwritable(error).message().to_owned()));
                }
                Err(Halt::Stopped) if self.job.is_cancelled() => return Some(Ending::Cancelled),
                Err(Halt::Stopped) => return None,
                Err(halt) => return Some(Ending::Failed(halt.to_string())),
            };
            if checkpoint.work.report().is_some() {
                let checkpoint = Box::new(checkpoint);
                return Some(Ending::Succeeded { checkpoint, parts: changes });
            }
            let record = self.record(State::Running, &checkpoint);
            kept = self.keep(changes, record, None, true).await;
        }
    }

    /// One batch, and what is to be kept of it, off the async threads; nothing where the program ends.
    async fn step(
        &self,
        mut checkpoint: Checkpoint<W>,
        before: f64,
        begin: Instant,
    ) -> Option<(Checkpoint<W>, Stepped)> {
        let (pool, job) = (Arc::clone(&self.inner.pool), Arc::clone(&self.job));
        let evaluator = Arc::clone(&self.inner.evaluator);
        let step = move || {
            let id = job.id().to_string();
            let stepped = pool.step(&id, &mut checkpoint.work, &*evaluator, &job.meter);
            let kept = stepped.map(|outcome| {
                checkpoint.elapsed = before + begin.elapsed().as_secs_f64();
                checkpoint.latest = outcome.latest.or(checkpoint.latest);
                // A large state takes milliseconds to write down: at the priority of the pool.
                pool.install(|| progress(job.id(), &checkpoint, &outcome))
            });
            (checkpoint, kept)
        };
        match tokio::task::spawn_blocking(step).await {
            Ok(stepped) => Some(stepped),
            // To the task that gives the turns.
            Err(error) if error.is_panic() => std::panic::resume_unwind(error.into_panic()),
            Err(_) => None,
        }
    }

    fn record(&self, state: State, checkpoint: &Checkpoint<W>) -> Record<W> {
        Record { state, reached: checkpoint.reached(), ..(*self.job.shown().record).clone() }
    }

    /// Makes the changes and shows `record` with the effect that goes with it; tries again for as long as the store fails.
    async fn keep(
        &self,
        changes: Vec<Change>,
        mut record: Record<W>,
        effect: Option<&SuccessEffect>,
        is_cancellable: bool,
    ) -> Kept {
        let (inner, job, begin) = (&*self.inner, &*self.job, Instant::now());
        let mut closing = inner.closing.subscribe();
        let mut pause = FIRST_PAUSE;
        loop {
            {
                let _changing = job.changing.lock().await;
                if *closing.borrow() || job.state().has_ended() {
                    return Kept::Over;
                }
                if is_cancellable && job.is_cancelled() {
                    return Kept::Cancelled;
                }
                match inner.keeper.commit(changes.clone()).await {
                    Ok(()) if record.state.has_ended() => {
                        // First the effect: a client that sees the end may use it at once.
                        effect.into_iter().for_each(|effect| (effect.publish)());
                        inner.show_ended(job, record);
                        return Kept::Done;
                    }
                    Ok(()) => {
                        // Waiting for the store counts, as the next batch will see.
                        record.reached.elapsed += begin.elapsed().as_secs_f64();
                        job.show(record);
                        return Kept::Done;
                    }
                    Err(failure) if failure.is_of_content() => {
                        return Kept::Refused(failure.message().to_owned());
                    }
                    Err(failure) => job.show_trouble(&waiting(&failure)),
                }
            }
            tokio::select! {
                () = tokio::time::sleep(pause) => {}
                () = job.cancelling.notified(), if is_cancellable => {}
                _ = closing.wait_for(|closing| *closing) => {}
            }
            pause = (2 * pause).min(LONGEST_PAUSE);
        }
    }

    /// Keeps and shows how it has ended.
    async fn end(&self, ending: Ending<W>) {
        let mut ending = ending;
        loop {
            let (record, effect) = self.ended(&ending);
            let (mut more, is_cancellable) = match &ending {
                Ending::Succeeded { parts, .. } => (parts.clone(), true),
                _ => (Vec::new(), false),
            };
            more.extend(effect.as_ref().map(|effect| effect.change.clone()));
            let kept = match self.inner.ending(&self.job, &record, more) {
                Ok(changes) => {
                    self.keep(changes, record.clone(), effect.as_ref(), is_cancellable).await
                }
                Err(failure) => Kept::Refused(failure.message().to_owned()),
            };
            let id = self.job.id();
            ending = match (kept, ending) {
                (Kept::Done, _) => {
                    log_end::<W>(id, &record);
                    return;
                }
                (Kept::Over, _) => return,
                (Kept::Cancelled, _) => Ending::Cancelled,
                (Kept::Refused(error), Ending::Succeeded { .. }) => Ending::Failed(error),
                (Kept::Refused(error), _) => {
                    // It would stand in the way of the others for ever.
                    let kind = W::KIND.name();
                    tracing::error!(job = %id, kind, error, "cannot store job result");
                    self.inner.show_ended(&self.job, record);
                    return;
                }
            };
        }
    }

    /// What is left of it, and what its success changes.
    fn ended(&self, ending: &Ending<W>) -> (Record<W>, Option<SuccessEffect>) {
        // Of the time, too, only what is kept: it goes with the last checkpoint.
        let record = || (*self.job.shown().record).clone();
        match ending {
            Ending::Cancelled => (Record { state: State::Cancelled, ..record() }, None),
            Ending::Failed(error) => {
                let error = Some(error.clone());
                (Record { state: State::Failed, error, ..record() }, None)
            }
            Ending::Succeeded { checkpoint, .. } => {
                let report = checkpoint.work.report().cloned();
                let record = Record { report, ..self.record(State::Succeeded, checkpoint) };
                let effect = record.report.as_ref().and_then(|report| {
                    let (services, id) = (&self.inner.services, self.job.id());
                    W::success_effect(services, id, &record.own, &record.settings, report)
                });
                (record, effect)
            }
        }
    }
}

/// Says how a job has ended.
fn log_end<W: Work>(job: JobId, record: &Record<W>) {
    let kind = W::KIND.name();
    match (record.state, &record.error) {
        (State::Failed, Some(error)) => tracing::info!(%job, kind, error, "job failed"),
        (State::Cancelled, _) => tracing::info!(%job, kind, "job cancelled"),
        _ => tracing::info!(%job, kind, "job finished"),
    }
}

/// What is kept after a batch; no checkpoint after the last one, which ends the job.
fn progress<W: Work>(
    job: JobId,
    checkpoint: &Checkpoint<W>,
    outcome: &BatchOutcome<W>,
) -> Result<Vec<Change>, serde_json::Error> {
    let mut changes = Vec::new();
    if checkpoint.work.report().is_none() {
        changes.push(Change::PutCheckpoint { job, body: checkpoint.body()? });
    }
    for (index, part) in &outcome.parts {
        changes.push(Change::PutPart { job, index: *index, body: part_body(part)? });
    }
    Ok(changes)
}

/// Why a job does not go on.
fn waiting(failure: &Failure) -> String {
    format!("{}; it goes on as soon as it can be kept", failure.message())
}

#[cfg(test)]
mod tests;
