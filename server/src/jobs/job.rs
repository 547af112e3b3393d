//! One job in the server: what is shown of it, and how it is stopped.
//!
//! Invariant: what is shown is what is kept, but for the episodes and the time of the batch that is going on.

use super::record::{Record, State};
use super::start::Start;
use super::work::Work;
use crate::store::JobId;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use tokio::sync::{Mutex, Notify, watch};
use tokio::time::Instant;
use umwelt_lab::evaluator::Meter;
use umwelt_lab::pool::remaining;
use umwelt_lab::wire::Pace;

/// A job.
#[derive(Debug)]
pub(crate) struct Job<W: Work> {
    id: JobId,
    shown: watch::Sender<Shown<W>>,
    /// Held while its state is changed outside its turn.
    pub(super) changing: Mutex<()>,
    pub(super) meter: Meter,
    /// Where it is taken up; fresh once it was.
    start: std::sync::Mutex<Start<W>>,
    is_cancelled: AtomicBool,
    /// Wakes what waits for the store on behalf of it.
    pub(super) cancelling: Notify,
}

/// What is shown of a job at one moment.
#[derive(Clone, Debug)]
pub(crate) struct Shown<W: Work> {
    pub(crate) record: Arc<Record<W>>,
    /// Since when it runs; none while it does not.
    since: Option<Instant>,
    /// What keeps it from going on.
    pub(crate) trouble: Option<Arc<str>>,
    /// Whether it was removed.
    pub(crate) removed: bool,
}

impl<W: Work> Job<W> {
    pub(super) fn new(id: JobId, record: Record<W>, start: Start<W>) -> Self {
        let shown = Shown { record: record.into(), since: None, trouble: None, removed: false };
        Self {
            id,
            shown: watch::Sender::new(shown),
            changing: Mutex::default(),
            meter: Meter::default(),
            start: start.into(),
            is_cancelled: AtomicBool::default(),
            cancelling: Notify::new(),
        }
    }

    /// Its id.
    pub(crate) fn id(&self) -> JobId {
        self.id
    }

    /// What is shown of it now.
    pub(crate) fn shown(&self) -> Shown<W> {
        self.shown.borrow().clone()
    }

    /// Where it stands.
    pub(crate) fn state(&self) -> State {
        self.shown.borrow().record.state
    }

    /// To wait for what is shown next.
    pub(crate) fn follow(&self) -> watch::Receiver<Shown<W>> {
        self.shown.subscribe()
    }

    /// Shows what is kept now. Time counts from now on while it runs.
    pub(super) fn show(&self, record: Record<W>) {
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
    pub(super) fn take_start(&self) -> Start<W> {
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

    /// How fast it goes, at the moment of `shown`.
    pub(crate) fn pace(&self, shown: &Shown<W>) -> Pace {
        let reached = &shown.record.reached;
        let total_episodes = reached.total_episodes;
        let Some(since) = shown.since else {
            let (episodes, elapsed_s) = (reached.episodes, reached.elapsed);
            return Pace { episodes, total_episodes, elapsed_s, remaining_s: None };
        };
        let episodes = reached.episodes.max(self.meter.episodes());
        let elapsed_s = reached.elapsed + since.elapsed().as_secs_f64();
        let remaining_s = remaining(elapsed_s, episodes, total_episodes);
        Pace { episodes, total_episodes, elapsed_s, remaining_s }
    }
}

impl<W: Work> Shown<W> {
    /// Why it failed, or what keeps it from going on.
    pub(crate) fn error(&self) -> Option<String> {
        let trouble = self.trouble.as_deref().map(str::to_owned);
        self.record.error.clone().or(trouble)
    }

    /// Whether it will never change again.
    pub(crate) fn has_ended(&self) -> bool {
        self.record.state.has_ended()
    }
}
