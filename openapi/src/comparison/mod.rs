//! Comparisons: methods driven over environments and trials in the background, on the same seeds.

mod claim;
mod event;
mod kind;
mod progress;
mod quantities;
mod report;
mod request;
mod spec;

pub use crate::estimate::Estimate;
pub use crate::job::State;
pub use claim::{Claim, Finding, FindingResult, FindingSubject};
pub use event::Kind;
pub use kind::{Comparison, ComparisonKind, Event, Outcome, Page};
pub use progress::{Progress, Stage};
pub use quantities::{Quantities, Reductions};
pub use report::{Difference, Entry, EnvironmentReport, Recognition, Report};
pub use request::Request;
pub use spec::{DEFAULT_PRIOR, KNOWN_METHODS, MAX_EPISODES, METHODS, Scenario, Spec, TRIALS};

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Largest body of a request in bytes; a full one has 2 kB.
pub const MAX_BODY: usize = 16 * 1024;

/// The media type of the trials.
pub const TRIALS_MEDIA_TYPE: &str = "text/csv";

/// The columns of the trials. A row is one trial of one contender in one environment; trials count from 0, `arrived` is
/// `true` or `false`, and what was not asked is empty.
pub const TRIALS_COLUMNS: [&str; 9] = [
    "environment",
    "contender",
    "trial",
    "arrived",
    "time_s",
    "deviation_m",
    "recognised_samples",
    "covered_samples",
    "samples",
];

/// The media type of the report for people.
pub const REPORT_MEDIA_TYPE: &str = "text/markdown";

/// A figure of a comparison (thesis figures 8 to 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = ComparisonFigure)]
pub enum Figure {
    /// Share of the trials that deviate by more, environment by environment.
    Deviation,
    /// Share of the trials that take longer, environment by environment.
    Time,
    /// Time against deviation: who is beaten in both.
    Pareto,
}

impl Figure {
    /// Every figure.
    pub const ALL: [Self; 3] = [Self::Deviation, Self::Time, Self::Pareto];

    /// The media type of every figure.
    pub const MEDIA_TYPE: &str = "image/svg+xml";

    /// The name in a path.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deviation => "deviation",
            Self::Time => "time",
            Self::Pareto => "pareto",
        }
    }

    /// The figure of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|figure| figure.name() == name)
    }
}
