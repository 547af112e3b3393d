//! Comparisons as the wire has them.

use crate::jobs::{OnWire, Reached, Record};
use umwelt_api::comparison::{ComparisonKind, Outcome, Progress, Report, Spec};
use umwelt_lab::comparison::{Comparison, ComparisonSettings};
use umwelt_lab::wire::{self, Pace};

impl OnWire for Comparison {
    type Kind = ComparisonKind;

    fn wire_spec(record: &Record<Self>) -> Spec {
        wire::comparison::spec(&record.settings, record.own.as_str())
    }

    fn progress(settings: &ComparisonSettings, reached: &Reached<Self>, pace: Pace) -> Progress {
        wire::comparison::progress(settings, reached.stage, pace)
    }

    fn outcome(record: &Record<Self>) -> Outcome {
        Outcome { report: record.report.as_ref().map(Report::from) }
    }

    /// A list of reports would have some MB.
    fn listed_outcome(_: &Record<Self>) -> Outcome {
        Outcome::default()
    }
}
