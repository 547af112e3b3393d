//! Evolutions as the wire has them.

use crate::jobs::{Job, Pace, Shown, State};
use umwelt_api::EvolutionId;
use umwelt_api::evolution::{self, Champion, Event, Progress, Stage};
use umwelt_lab::evolution::Evolution;
use umwelt_lab::wire;

impl Job<Evolution> {
    /// As the wire has it.
    pub(crate) fn evolution(&self) -> evolution::Evolution {
        let shown = self.shown();
        let record = &shown.record;
        evolution::Evolution {
            evolution: EvolutionId::numbered(self.id().number),
            state: record.state.into(),
            spec: wire::evolution::spec(&record.settings, Some(record.own.as_str())),
            progress: self.progress(&shown),
            interrupted: record.interrupted,
            created_unix_s: record.created_unix,
            error: shown.error(),
            prior: (record.state == State::Succeeded).then(|| record.own.clone()),
            champion: record.report.as_ref().map(Champion::from),
        }
    }

    /// Where it stands, as an event.
    pub(crate) fn event(&self, shown: &Shown<Evolution>) -> Event {
        let (state, progress) = (shown.record.state.into(), self.progress(shown));
        Event::state(EvolutionId::numbered(self.id().number), state, progress, shown.error())
    }

    fn progress(&self, shown: &Shown<Evolution>) -> Progress {
        let (stage, generation) = shown.stage();
        let Pace { episodes, total_episodes, elapsed, remaining } = self.pace(shown);
        let fitness = shown.record.reached.latest;
        Progress {
            stage,
            generation,
            generations: shown.record.settings.generations as u64,
            best_fitness: fitness.map(|fitness| fitness.best),
            mean_fitness: fitness.map(|fitness| fitness.mean),
            episodes,
            total_episodes,
            elapsed_s: elapsed,
            remaining_s: remaining,
        }
    }
}

impl Shown<Evolution> {
    /// What it is doing, and how many generations have ended and are kept.
    fn stage(&self) -> (Stage, u64) {
        let generations = self.record.settings.generations as u64;
        self.record
            .reached
            .stage
            .map_or((Stage::Queued, 0), |it| wire::evolution::stage(it, generations))
    }

    /// Generations that have ended and are kept.
    pub(crate) fn generations(&self) -> u64 {
        self.stage().1
    }
}
