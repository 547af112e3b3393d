//! Comparisons as the wire has them.

use crate::jobs::{Job, Pace, Shown};
use umwelt_api::ComparisonId;
use umwelt_api::comparison::{self, Event, Progress, Report, Stage};
use umwelt_lab::comparison::{Comparison, Stage as Reached};
use umwelt_lab::wire;

impl Job<Comparison> {
    /// As the wire has it.
    pub(crate) fn comparison(&self) -> comparison::Comparison {
        let shown = self.shown();
        let record = &shown.record;
        comparison::Comparison {
            comparison: ComparisonId::numbered(self.id().number),
            state: record.state.into(),
            spec: wire::comparison::spec(&record.settings, record.own.as_str()),
            progress: self.progress(&shown),
            interrupted: record.interrupted,
            created_unix_s: record.created_unix,
            error: shown.error(),
            report: record.report.as_ref().map(Report::from),
        }
    }

    /// Where it stands, as an event.
    pub(crate) fn event(&self, shown: &Shown<Comparison>) -> Event {
        let (state, progress) = (shown.record.state.into(), self.progress(shown));
        Event::state(ComparisonId::numbered(self.id().number), state, progress, shown.error())
    }

    fn progress(&self, shown: &Shown<Comparison>) -> Progress {
        let trials = shown.record.settings.trials as u64;
        let (stage, trials_done) = match shown.record.reached.stage {
            None => (Stage::Queued, 0),
            Some(Reached::Reference) => (Stage::Reference, 0),
            Some(Reached::Trials { done }) => (Stage::Trials, done as u64),
            Some(Reached::Done) => (Stage::Done, trials),
        };
        let Pace { episodes, total_episodes, elapsed, remaining } = self.pace(shown);
        Progress {
            stage,
            trials_done,
            trials,
            episodes,
            total_episodes,
            elapsed_s: elapsed,
            remaining_s: remaining,
        }
    }
}
