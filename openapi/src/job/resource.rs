//! A job, a page of them, and what happens to one.

use super::field::{read_id, read_list, write_id, write_list};
use super::{JobKind, JobNews, State};
use crate::page::Unreadable;
use serde::{Deserialize, Serialize};

/// A job as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Job<K: JobKind> {
    /// Its id, given by the server; on the wire in the field of the kind's name.
    #[serde(flatten, serialize_with = "write_id::<K, _>", deserialize_with = "read_id::<K, _>")]
    pub id: K::Id,
    /// Where it stands.
    pub state: State,
    /// What was asked for, all filled in.
    pub spec: K::Spec,
    /// How far it has got.
    pub progress: K::Progress,
    /// How often it went on after a restart of the server.
    pub interrupted: u64,
    /// When it was submitted, in seconds since 1970 by the server's clock.
    pub created_unix_s: u64,
    /// Why it failed, or what keeps it from going on; null where nothing does.
    pub error: Option<String>,
    /// What it ends with; on the wire beside the other fields.
    #[serde(flatten)]
    pub outcome: K::Outcome,
}

/// Some of the jobs of a kind, the newest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct JobPage<K: JobKind> {
    /// The jobs; on the wire in the field of the kind's plural.
    #[serde(
        flatten,
        serialize_with = "write_list::<K, _, _>",
        deserialize_with = "read_list::<K, _, _>"
    )]
    pub jobs: Vec<Job<K>>,
    /// Those that cannot be read, in the same part of the list; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unreadable: Vec<Unreadable>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}

impl<K: JobKind> Default for JobPage<K> {
    /// Without jobs.
    fn default() -> Self {
        Self { jobs: Vec::new(), unreadable: Vec::new(), next_page_token: None }
    }
}

/// Something that happened to a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct JobEvent<K: JobKind> {
    /// How far the job had got: never decreasing, the same after a restart.
    pub id: u64,
    /// The job; on the wire in the field of the kind's name.
    #[serde(flatten, serialize_with = "write_id::<K, _>", deserialize_with = "read_id::<K, _>")]
    pub job: K::Id,
    /// What happened.
    #[serde(flatten)]
    pub kind: K::News,
}

impl<K: JobKind> JobEvent<K> {
    /// The event that the job stands here now.
    pub fn state(job: K::Id, state: State, progress: K::Progress, error: Option<String>) -> Self {
        let id = K::event_id(&progress);
        Self { id, job, kind: K::News::of_state(state, progress, error) }
    }
}
