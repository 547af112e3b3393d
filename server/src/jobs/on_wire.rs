//! Jobs as the wire has them, whatever their kind.

use super::job::{Job, Shown};
use super::record::{Reached, Record};
use super::work::Work;
use umwelt_api::job::{self, JobEvent, JobKind};
use umwelt_lab::wire::Pace;

/// A kind of job that the contract describes.
pub(crate) trait OnWire: Work {
    /// Its kind in the contract.
    type Kind: JobKind;

    /// What was asked for, all filled in.
    fn wire_spec(record: &Record<Self>) -> <Self::Kind as JobKind>::Spec;

    /// How far it has got.
    fn progress(
        settings: &Self::Settings,
        reached: &Reached<Self>,
        pace: Pace,
    ) -> <Self::Kind as JobKind>::Progress;

    /// What it ends with.
    fn outcome(record: &Record<Self>) -> <Self::Kind as JobKind>::Outcome;

    /// The same in a list.
    fn listed_outcome(record: &Record<Self>) -> <Self::Kind as JobKind>::Outcome {
        Self::outcome(record)
    }
}

impl<W: OnWire> Job<W> {
    /// As the wire has it.
    pub(crate) fn on_wire(&self) -> job::Job<W::Kind> {
        self.with(W::outcome)
    }

    /// The same in a list.
    pub(crate) fn listed(&self) -> job::Job<W::Kind> {
        self.with(W::listed_outcome)
    }

    fn with(
        &self,
        outcome: impl FnOnce(&Record<W>) -> <W::Kind as JobKind>::Outcome,
    ) -> job::Job<W::Kind> {
        let shown = self.shown();
        let record = &shown.record;
        job::Job {
            id: W::Kind::id(self.id().number),
            state: record.state.into(),
            spec: W::wire_spec(record),
            progress: self.progress(&shown),
            interrupted: record.interrupted,
            created_unix_s: record.created_unix,
            error: shown.error(),
            outcome: outcome(record),
        }
    }

    /// Where it stands, as an event.
    pub(crate) fn event(&self, shown: &Shown<W>) -> JobEvent<W::Kind> {
        let (id, state) = (W::Kind::id(self.id().number), shown.record.state.into());
        JobEvent::state(id, state, self.progress(shown), shown.error())
    }

    fn progress(&self, shown: &Shown<W>) -> <W::Kind as JobKind>::Progress {
        let record = &shown.record;
        W::progress(&record.settings, &record.reached, self.pace(shown))
    }
}
