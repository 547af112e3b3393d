//! Evolutions as the wire has them.

use crate::jobs::{OnWire, Reached, Record, Shown, State};
use umwelt_api::evolution::{Champion, EvolutionKind, Outcome, Progress, Spec};
use umwelt_lab::evolution::{Evolution, EvolutionSettings};
use umwelt_lab::wire::{self, Pace};

impl OnWire for Evolution {
    type Kind = EvolutionKind;

    fn wire_spec(record: &Record<Self>) -> Spec {
        wire::evolution::spec(&record.settings, Some(record.own.as_str()))
    }

    fn progress(settings: &EvolutionSettings, reached: &Reached<Self>, pace: Pace) -> Progress {
        wire::evolution::progress(settings, reached.stage, reached.latest, pace)
    }

    fn outcome(record: &Record<Self>) -> Outcome {
        Outcome {
            prior: (record.state == State::Succeeded).then(|| record.own.clone()),
            champion: record.report.as_ref().map(Champion::from),
        }
    }
}

impl Shown<Evolution> {
    /// Generations that have ended and are kept.
    pub(crate) fn generations(&self) -> u64 {
        wire::evolution::stage(&self.record.settings, self.record.reached.stage).1
    }
}
