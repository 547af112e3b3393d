//! Runs the evolutions of a server, one at a time, and keeps each step of them.
//!
//! Invariants: nothing is shown as reached that is not kept; a store that fails delays an evolution and never ends it;
//! whatever goes wrong in one, the next has its turn. When the server ends, what runs stays running in the store.

use super::job::Job;
use super::queue::{Inner, Start, unwritable};
use super::record::{Checkpoint, Reached, Record, State, generation_body};
use super::run::Halt;
use crate::failure::Failure;
use crate::priors::Named;
use crate::store::Change;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;
use umwelt_api::EvolutionId;
use umwelt_api::prior::Source;
use umwelt_core::evolution::{Evolution, Generation, Report};

/// First pause after the store has failed; each is twice the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(50);

/// Longest pause: a store that works again is noticed within this.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// Gives every evolution its turn until the server ends.
pub(super) async fn run(inner: Arc<Inner>) {
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
            tracing::error!(evolution = %job.id(), %error, "it broke off");
            let turn = Turn { inner: Arc::clone(&inner), job };
            turn.end(Ending::Failed("the server made a mistake; its log says which".to_owned()))
                .await;
        }
    }
    inner.ended.send_replace(true);
}

async fn next(inner: &Inner) -> Arc<Job> {
    loop {
        let woken = inner.wake.notified();
        if let Some(job) = inner.next() {
            return job;
        }
        woken.await;
    }
}

/// One evolution, from its start to its end or to that of the server.
struct Turn {
    inner: Arc<Inner>,
    job: Arc<Job>,
}

/// How an evolution ends.
enum Ending {
    Succeeded(Box<Checkpoint>, Box<Report>),
    Failed(String),
    Cancelled,
}

/// What came of a batch: what is to be kept of it.
type Stepped = Result<Result<Vec<Change>, serde_json::Error>, Halt>;

/// What became of changes that were to be kept.
enum Kept {
    Done,
    /// The evolution was cancelled meanwhile.
    Cancelled,
    /// The server ends, or the evolution has.
    Over,
    /// The store will never keep it.
    Refused(String),
}

impl Turn {
    async fn take(self) {
        if let Some(ending) = self.go_on().await {
            self.end(ending).await;
        }
    }

    /// Runs it. Returns how it is to end; nothing where the server ends or the evolution was cancelled before it began.
    async fn go_on(&self) -> Option<Ending> {
        let mut checkpoint = match self.job.take_start() {
            Start::From(checkpoint) => *checkpoint,
            Start::Broken(error) => return Some(Ending::Failed(error)),
            Start::Fresh => match Evolution::new(self.job.shown().record.settings.clone()) {
                Ok(evolution) => Checkpoint { evolution, fitness: None, elapsed: 0.0 },
                Err(error) => return Some(Ending::Failed(error.to_string())),
            },
        };
        let (before, begin) = (checkpoint.elapsed, Instant::now());
        let record = self.record(State::Running, &checkpoint);
        let stored = match record.stored(self.job.number()) {
            Ok(stored) => stored,
            Err(error) => return Some(Ending::Failed(error.to_string())),
        };
        tracing::info!(evolution = %self.job.id(), interrupted = record.interrupted, "it begins");
        let mut kept = self.keep(vec![Change::PutEvolution(stored)], record, None, true).await;
        loop {
            match kept {
                Kept::Done => {}
                Kept::Cancelled => return Some(Ending::Cancelled),
                Kept::Over => return None,
                Kept::Refused(error) => return Some(Ending::Failed(error)),
            }
            let (stepped, told) = self.step(checkpoint, before, begin).await?;
            checkpoint = stepped;
            let changes = match told {
                Ok(Ok(changes)) => changes,
                Ok(Err(error)) => {
                    return Some(Ending::Failed(unwritable(error).message().to_owned()));
                }
                Err(Halt::Stopped) if self.job.is_cancelled() => return Some(Ending::Cancelled),
                Err(Halt::Stopped) => return None,
                Err(halt) => return Some(Ending::Failed(halt.to_string())),
            };
            if let Some(report) = checkpoint.evolution.report().cloned() {
                return Some(Ending::Succeeded(Box::new(checkpoint), Box::new(report)));
            }
            let record = self.record(State::Running, &checkpoint);
            kept = self.keep(changes, record, None, true).await;
        }
    }

    /// One batch, and what is to be kept of it, off the async threads; nothing where the program ends.
    async fn step(
        &self,
        mut checkpoint: Checkpoint,
        before: f64,
        begin: Instant,
    ) -> Option<(Checkpoint, Stepped)> {
        let (pool, job) = (Arc::clone(&self.inner.pool), Arc::clone(&self.job));
        let step = move || {
            let told = pool.step(&mut checkpoint.evolution, &job.meter).map(|generation| {
                checkpoint.elapsed = before + begin.elapsed().as_secs_f64();
                checkpoint.fitness =
                    generation.as_ref().map(|it| it.fitness).or(checkpoint.fitness);
                // A large population takes milliseconds to write down: at the priority of the pool.
                pool.install(|| progress(job.id(), &checkpoint, generation.as_ref()))
            });
            (checkpoint, told)
        };
        match tokio::task::spawn_blocking(step).await {
            Ok(stepped) => Some(stepped),
            // To whoever gives the turns.
            Err(error) if error.is_panic() => std::panic::resume_unwind(error.into_panic()),
            Err(_) => None,
        }
    }

    fn record(&self, state: State, checkpoint: &Checkpoint) -> Record {
        let Checkpoint { evolution, fitness, elapsed } = checkpoint;
        let reached = Reached::of(evolution, *fitness, *elapsed);
        Record { state, reached, ..(*self.job.shown().record).clone() }
    }

    /// Makes the changes and shows `record` with the prior that goes with it; tries again for as long as the store
    /// fails.
    async fn keep(
        &self,
        changes: Vec<Change>,
        mut record: Record,
        prior: Option<&Named>,
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
                        // First the prior: whoever sees the end may give it to a robot.
                        prior
                            .into_iter()
                            .for_each(|prior| inner.priors.all().insert(prior.clone()));
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
    async fn end(&self, ending: Ending) {
        let mut ending = ending;
        loop {
            let (record, prior) = self.ended(&ending);
            let stored = prior.as_ref().and_then(Named::stored).map(Change::PutPrior);
            let changes = self.inner.ending(&self.job, &record, stored.into_iter().collect());
            let is_cancellable = matches!(ending, Ending::Succeeded(..));
            let kept = match changes {
                Ok(changes) => {
                    self.keep(changes, record.clone(), prior.as_ref(), is_cancellable).await
                }
                Err(failure) => Kept::Refused(failure.message().to_owned()),
            };
            let id = self.job.id();
            ending = match (kept, ending) {
                (Kept::Done, _) => {
                    tracing::info!(evolution = %id, state = ?record.state, "it has ended");
                    return;
                }
                (Kept::Over, _) => return,
                (Kept::Cancelled, _) => Ending::Cancelled,
                (Kept::Refused(error), Ending::Succeeded(..)) => Ending::Failed(error),
                (Kept::Refused(error), _) => {
                    // It would stand in the way of the others for ever.
                    tracing::error!(evolution = %id, error, "its end cannot be kept");
                    self.inner.show_ended(&self.job, record);
                    return;
                }
            };
        }
    }

    /// What is left of it, and the prior that it gives.
    fn ended(&self, ending: &Ending) -> (Record, Option<Named>) {
        let shown = self.job.shown();
        // Of the time, too, only what is kept: it goes with the last generation.
        let record = (*shown.record).clone();
        match ending {
            Ending::Cancelled => (Record { state: State::Cancelled, ..record }, None),
            Ending::Failed(error) => {
                let error = Some(error.clone());
                (Record { state: State::Failed, error, ..record }, None)
            }
            Ending::Succeeded(checkpoint, report) => {
                let settings = &record.settings;
                let source = Source::Evolution {
                    evolution: self.job.id().clone(),
                    seed: settings.seed,
                    optimizer: settings.optimizer.into(),
                    fitness: report.entries.first().map(|champion| champion.fitness.mean),
                };
                let (id, prior) = (record.prior.clone(), report.champion);
                let named = Named { id, prior, note: None, source };
                let report = Some((**report).clone());
                (Record { report, ..self.record(State::Succeeded, checkpoint) }, Some(named))
            }
        }
    }
}

/// What is kept after a batch; nothing after the last one, which ends the evolution.
fn progress(
    id: &EvolutionId,
    checkpoint: &Checkpoint,
    generation: Option<&Generation>,
) -> Result<Vec<Change>, serde_json::Error> {
    let mut changes = Vec::new();
    if checkpoint.evolution.report().is_none() {
        let (evolution, body) = (id.to_string(), checkpoint.body()?);
        changes.push(Change::PutCheckpoint { evolution, body });
    }
    if let Some(generation) = generation {
        let (evolution, body) = (id.to_string(), generation_body(generation)?);
        changes.push(Change::PutGeneration { evolution, index: generation.index, body });
    }
    Ok(changes)
}

/// Why an evolution does not go on.
fn waiting(failure: &Failure) -> String {
    format!("{}; it goes on as soon as it can be kept", failure.message())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolution::run::{Pool, Priority};
    use crate::evolution::{Evolutions, Submission};
    use crate::priors::Priors;
    use crate::store::{Contents, Keeper, MemoryStore};
    use std::sync::atomic::{AtomicBool, Ordering};
    use umwelt_core::evolution::{Evaluation, EvolutionSettings, Job as Episode};

    /// The bug to fear: one evolution that panics takes the server with it, or all that wait.
    #[tokio::test]
    async fn an_evolution_that_panics_fails_and_the_next_has_its_turn() {
        static FAILS: AtomicBool = AtomicBool::new(true);
        fn evaluate(evolution: &Evolution, episode: &Episode) -> Evaluation {
            assert!(!FAILS.load(Ordering::SeqCst), "no floor under the robot");
            evolution.evaluate(episode)
        }
        let pool = Pool::new(Some(2), Priority::Normal).unwrap().evaluating(evaluate);
        let (keeper, contents) = (Keeper::new(Arc::<MemoryStore>::default()), Contents::default());
        let evolutions =
            Evolutions::open((16, 200), pool, keeper, Priors::default(), &contents).await.unwrap();
        let submit = async || {
            let quick = EvolutionSettings::preset("quick").unwrap();
            let settings = EvolutionSettings {
                environments: quick.environments[..1].to_vec(),
                population: 2,
                generations: 1,
                trials: 1,
                selection_trials: 1,
                report_trials: 2,
                ..quick
            };
            let submission =
                Submission { settings, prior: None, key: None, request: String::new() };
            evolutions.submitting().await.submit(submission).await.unwrap()
        };
        let ended = async |job: &Job| {
            let record =
                job.follow().wait_for(|shown| shown.has_ended()).await.unwrap().record.clone();
            (record.state, record.error.clone())
        };
        let (state, error) = ended(&*submit().await).await;
        assert_eq!(state, State::Failed);
        assert_eq!(error.unwrap(), "an evaluation failed: no floor under the robot");
        FAILS.store(false, Ordering::SeqCst);
        assert_eq!(ended(&*submit().await).await, (State::Succeeded, None));
    }
}
