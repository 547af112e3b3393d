//! What is kept of a job: JSON with a version, of which the store knows nothing.
//!
//! The record changes with the state alone. What changes with every batch stands in the checkpoint and in the parts.

use super::work::Work;
use crate::store::{JobId, StoredJob};
use serde::de::DeserializeOwned;
use serde::ser::Error;
use serde::{Deserialize, Serialize};

/// Version of everything in this module. In version 1 there were evolutions alone, and their names for some fields.
const VERSION: u64 = 2;

/// The oldest version that is still read.
const OLDEST: u64 = 1;

/// Why something that is kept cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unreadable {
    /// Another program wrote it.
    #[error("it is of version {0}, this program reads {OLDEST} to {VERSION}")]
    Version(u64),
    /// The state in it is that of another program.
    #[error("its state is of version {found}, this program goes on from {current}")]
    State {
        /// That of the state.
        found: u64,
        /// That of this program.
        current: u32,
    },
    /// It is damaged.
    #[error("it is damaged: {0}")]
    Damaged(String),
}

/// Where a job stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum State {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl State {
    /// Whether it will never change again.
    pub(crate) fn has_ended(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

impl From<State> for umwelt_api::evolution::State {
    fn from(state: State) -> Self {
        match state {
            State::Queued => Self::Queued,
            State::Running => Self::Running,
            State::Succeeded => Self::Succeeded,
            State::Failed => Self::Failed,
            State::Cancelled => Self::Cancelled,
        }
    }
}

/// How far a job has got, as far as that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Reached<W: Work> {
    /// None before it was begun.
    pub(crate) stage: Option<W::Stage>,
    #[serde(alias = "fitness")]
    pub(crate) latest: Option<W::Latest>,
    pub(crate) episodes: u64,
    pub(crate) total_episodes: u64,
    /// Time in s for which it has run.
    pub(crate) elapsed: f64,
}

impl<W: Work> Reached<W> {
    /// Where a job is that has not begun.
    pub(crate) fn nothing(work: &W) -> Self {
        let total_episodes = work.total_episodes();
        Self { stage: None, latest: None, episodes: 0, total_episodes, elapsed: 0.0 }
    }
}

/// What is kept of a job but its parts and its checkpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Record<W: Work> {
    pub(crate) state: State,
    /// How often it went on after a restart.
    pub(crate) interrupted: u64,
    /// When it was submitted, in s since 1970.
    pub(crate) created_unix: u64,
    pub(crate) settings: W::Settings,
    #[serde(alias = "prior")]
    pub(crate) own: W::Own,
    /// The key under which it was submitted, if any.
    pub(crate) key: Option<String>,
    /// Hash of the request.
    pub(crate) request: String,
    /// Why it failed.
    pub(crate) error: Option<String>,
    pub(crate) report: Option<W::Report>,
    /// How far it had got when the state changed.
    pub(crate) reached: Reached<W>,
}

impl<W: Work> Record<W> {
    /// As it is kept.
    ///
    /// # Errors
    /// Where it would not be read back as it is: JSON has no infinity.
    pub(crate) fn stored(&self, id: JobId) -> Result<StoredJob, serde_json::Error> {
        let body = write(self)?;
        if Self::read(&body).as_ref() != Ok(self) {
            return Err(serde_json::Error::custom("some number in it is infinite or none at all"));
        }
        Ok(StoredJob { id, finished: self.state.has_ended(), body })
    }

    /// What is kept.
    pub(crate) fn read(body: &str) -> Result<Self, Unreadable> {
        read(body)
    }
}

/// Everything that a job goes on from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Checkpoint<W: Work> {
    #[serde(alias = "evolution")]
    pub(crate) work: W,
    #[serde(alias = "fitness")]
    pub(crate) latest: Option<W::Latest>,
    /// Time in s for which it has run.
    pub(crate) elapsed: f64,
}

impl<W: Work> Checkpoint<W> {
    /// How far that is.
    pub(crate) fn reached(&self) -> Reached<W> {
        let Self { work, latest, elapsed } = self;
        Reached {
            stage: Some(work.stage()),
            latest: *latest,
            episodes: work.episodes(),
            total_episodes: work.total_episodes(),
            elapsed: *elapsed,
        }
    }

    /// As it is kept.
    pub(crate) fn body(&self) -> Result<String, serde_json::Error> {
        write(self)
    }

    /// What is kept.
    pub(crate) fn read(body: &str) -> Result<Self, Unreadable> {
        // The versions first: what stands beside them may be anything.
        match serde_json::from_str(body) {
            Ok(Peek { content: PeekContent { work: Version { version } } })
                if version != u64::from(W::STATE_VERSION) =>
            {
                Err(Unreadable::State { found: version, current: W::STATE_VERSION })
            }
            _ => read(body),
        }
    }
}

#[derive(Deserialize)]
struct Version {
    version: u64,
}

#[derive(Deserialize)]
struct Peek {
    content: PeekContent,
}

#[derive(Deserialize)]
struct PeekContent {
    #[serde(alias = "evolution")]
    work: Version,
}

/// A part as it is kept.
pub(crate) fn part_body(part: &impl Serialize) -> Result<String, serde_json::Error> {
    write(part)
}

/// The part that is kept.
pub(crate) fn read_part<P: DeserializeOwned>(body: &str) -> Result<P, Unreadable> {
    read(body)
}

#[derive(Serialize, Deserialize)]
struct Versioned<T> {
    version: u64,
    content: T,
}

fn write(content: &impl Serialize) -> Result<String, serde_json::Error> {
    serde_json::to_string(&Versioned { version: VERSION, content })
}

fn read<T: DeserializeOwned>(body: &str) -> Result<T, Unreadable> {
    let damaged = |error: serde_json::Error| Unreadable::Damaged(error.to_string());
    let Version { version } = serde_json::from_str(body).map_err(damaged)?;
    if !(OLDEST..=VERSION).contains(&version) {
        return Err(Unreadable::Version(version));
    }
    let versioned: Versioned<T> = serde_json::from_str(body).map_err(damaged)?;
    Ok(versioned.content)
}
