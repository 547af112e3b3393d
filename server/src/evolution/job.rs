//! One evolution in the server: what is shown of it, and how it is told to stop.
//!
//! Invariant: what is shown is what is kept, but for the episodes and the time of the batch that is going on.

use super::queue::Start;
use super::record::{Record, State};
use super::run::Meter;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use tokio::sync::{Mutex, Notify, watch};
use tokio::time::Instant;
use umwelt_api::EvolutionId;
use umwelt_api::evolution::{self, Champion, Event, Progress, Spec, Stage};

/// An evolution.
#[derive(Debug)]
pub(crate) struct Job {
    id: EvolutionId,
    number: u64,
    shown: watch::Sender<Shown>,
    /// Held by whoever changes its state while it is not running.
    pub(super) changing: Mutex<()>,
    pub(super) meter: Meter,
    /// Where it is taken up; fresh once it was.
    start: std::sync::Mutex<Start>,
    is_cancelled: AtomicBool,
    /// Wakes whoever waits for the store on behalf of it.
    pub(super) cancelling: Notify,
}

/// What is shown of an evolution at one moment.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) record: Arc<Record>,
    /// Since when it runs; none while it does not.
    since: Option<Instant>,
    /// What keeps it from going on.
    pub(crate) trouble: Option<Arc<str>>,
    /// Whether it was removed.
    pub(crate) removed: bool,
}

impl Job {
    pub(super) fn new(number: u64, record: Record, start: Start) -> Self {
        let shown = Shown { record: record.into(), since: None, trouble: None, removed: false };
        Self {
            id: EvolutionId::numbered(number),
            number,
            shown: watch::Sender::new(shown),
            changing: Mutex::default(),
            meter: Meter::default(),
            start: start.into(),
            is_cancelled: AtomicBool::default(),
            cancelling: Notify::new(),
        }
    }

    /// Its id.
    pub(crate) fn id(&self) -> &EvolutionId {
        &self.id
    }

    /// Its number, in the order of submission.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// What is shown of it now.
    pub(crate) fn shown(&self) -> Shown {
        self.shown.borrow().clone()
    }

    /// Where it stands.
    pub(crate) fn state(&self) -> State {
        self.shown.borrow().record.state
    }

    /// To wait for what is shown next.
    pub(crate) fn follow(&self) -> watch::Receiver<Shown> {
        self.shown.subscribe()
    }

    /// Shows what is kept now. Time counts from now on while it runs.
    pub(super) fn show(&self, record: Record) {
        let since = (record.state == State::Running).then(Instant::now);
        self.shown.send_modify(|shown| {
            *shown = Shown { record: record.into(), since, trouble: None, removed: false };
        });
    }

    /// Shows what keeps it from going on.
    pub(super) fn show_trouble(&self, trouble: &str) {
        self.shown.send_modify(|shown| shown.trouble = Some(trouble.into()));
    }

    /// Shows it no more.
    pub(super) fn show_removed(&self) {
        self.shown.send_modify(|shown| shown.removed = true);
    }

    /// Where it is to be taken up.
    pub(super) fn take_start(&self) -> Start {
        let mut start = self.start.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::replace(&mut start, Start::Fresh)
    }

    /// Tells it to stop for good.
    pub(super) fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::SeqCst);
        self.meter.stop();
        self.cancelling.notify_one();
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::SeqCst)
    }

    /// As the wire has it.
    pub(crate) fn evolution(&self) -> evolution::Evolution {
        let shown = self.shown();
        let record = &shown.record;
        evolution::Evolution {
            evolution: self.id.clone(),
            state: record.state.into(),
            spec: Spec::from_core(&record.settings, Some(record.prior.as_str())),
            progress: self.progress(&shown),
            interrupted: record.interrupted,
            created_unix_s: record.created_unix,
            error: shown.error(),
            prior: (record.state == State::Succeeded).then(|| record.prior.clone()),
            champion: record.report.as_ref().map(Champion::from),
        }
    }

    /// Where it stands, as an event.
    pub(crate) fn event(&self, shown: &Shown) -> Event {
        let (state, progress) = (shown.record.state.into(), self.progress(shown));
        Event::state(self.id.clone(), state, progress, shown.error())
    }

    fn progress(&self, shown: &Shown) -> Progress {
        let record = &shown.record;
        let reached = &record.reached;
        let generations = record.settings.generations as u64;
        let (stage, generation) = match reached.stage {
            Some(stage) => Stage::of(stage, generations),
            None => (Stage::Queued, 0),
        };
        let (mut episodes, mut elapsed) = (reached.episodes, reached.elapsed);
        if let Some(since) = shown.since {
            episodes = episodes.max(self.meter.episodes());
            elapsed += since.elapsed().as_secs_f64();
        }
        let total_episodes = reached.total_episodes;
        let remaining =
            shown.since.and_then(|_| super::remaining(elapsed, episodes, total_episodes));
        Progress {
            stage,
            generation,
            generations,
            best_fitness: reached.fitness.map(|fitness| fitness.best),
            mean_fitness: reached.fitness.map(|fitness| fitness.mean),
            episodes,
            total_episodes,
            elapsed_s: elapsed,
            remaining_s: remaining,
        }
    }
}

impl Shown {
    /// Why it failed, or what keeps it from going on.
    fn error(&self) -> Option<String> {
        let trouble = self.trouble.as_deref().map(str::to_owned);
        self.record.error.clone().or(trouble)
    }

    /// Generations that have ended and are kept.
    pub(crate) fn generations(&self) -> u64 {
        let generations = self.record.settings.generations as u64;
        self.record.reached.stage.map_or(0, |stage| Stage::of(stage, generations).1)
    }

    /// Whether it will never change again.
    pub(crate) fn has_ended(&self) -> bool {
        self.record.state.has_ended()
    }
}
