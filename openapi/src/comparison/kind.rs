//! Comparisons among the jobs.

use super::{Kind, Progress, Report, Request, Spec};
use crate::id::ComparisonId;
use crate::job::{Job, JobDescription, JobEvent, JobKind, JobPage};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Comparisons among the jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComparisonKind;

/// A comparison as it is now.
pub type Comparison = Job<ComparisonKind>;

/// Some of the comparisons, the newest first, each without its report.
pub type Page = JobPage<ComparisonKind>;

/// What a comparison ends with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Outcome {
    /// What came of it; null until it has succeeded, and in lists: it may have a hundred kilobytes.
    pub report: Option<Report>,
}

impl JobKind for ComparisonKind {
    const NAME: &'static str = "comparison";
    const LIST: &'static str = "comparisons";
    const DESCRIPTION: JobDescription = JobDescription {
        job: "Comparison",
        page: "ComparisonPage",
        event: "ComparisonEvent",
        one: "a comparison",
        listed: "The comparisons, each without its report.",
        event_id: "Trials that every contender has driven: never decreasing, the same after a restart.",
    };
    type Id = ComparisonId;
    type Request = Request;
    type Spec = Spec;
    type Progress = Progress;
    type Outcome = Outcome;
    type News = Kind;

    fn id(number: u64) -> ComparisonId {
        ComparisonId::numbered(number)
    }

    fn event_id(progress: &Progress) -> u64 {
        progress.trials_done
    }

    fn episodes(progress: &Progress) -> (u64, u64) {
        (progress.episodes, progress.total_episodes)
    }
}

/// Something that happened to a comparison.
///
/// ```
/// use umwelt_api::comparison::{Event, Kind};
/// let later = r#"{"id": 8, "comparison": "comparison-1", "type": "of-tomorrow", "much": 1}"#;
/// assert_eq!(serde_json::from_str::<Event>(later)?.kind, Kind::Other);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Event = JobEvent<ComparisonKind>;
