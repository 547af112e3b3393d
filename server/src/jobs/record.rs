//! What is kept of a job: bodies of forms of their own, of which the store knows nothing.
//!
//! The record changes with the state alone. What changes with every batch stands in the checkpoint and in the parts.

use super::work::Work;
use crate::store::document::{self, Form, Unreadable, Upgrade};
use crate::store::{JobId, StoredJob};
use serde::de::DeserializeOwned;
use serde::ser::Error;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// What leads the record of a job to the form of today: version 1 had evolutions alone and their names for some fields,
/// version 2 the settings in core's names; versions 3 and 4 knew less of a drive.
pub(crate) const UPGRADES: &[Upgrade] =
    &[names_of_all_kinds, document::job_settings, document::same, document::same];

/// How the parts of a job are kept. Their form has stayed; they go by the versions of records.
pub(crate) const PART: Form = Form { is_within: true, upgrades: &[stays, stays], base: "{}" };

/// How checkpoints are kept. Version 1 had the names of evolutions; version 2 had the settings in the state of the work as
/// well, which stand in the record.
pub(crate) const CHECKPOINT: Form = Form {
    is_within: true,
    upgrades: &[names_of_all_kinds, stays],
    base: r#"{"latest": null, "elapsed": 0.0}"#,
};

fn stays(_: &mut Map<String, Value>) {}

/// From the names that evolutions had for themselves.
fn names_of_all_kinds(content: &mut Map<String, Value>) {
    let mut rename = |before: &str, after: &str| {
        if let Some(value) = content.remove(before) {
            content.insert(after.to_owned(), value);
        }
    };
    rename("prior", "own");
    rename("evolution", "work");
    rename("fitness", "latest");
    if let Some(reached) = content.get_mut("reached").and_then(Value::as_object_mut)
        && let Some(fitness) = reached.remove("fitness")
    {
        reached.insert("latest".to_owned(), fitness);
    }
}

/// Why a checkpoint cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unusable {
    /// It cannot be read.
    #[error("{0}")]
    Unreadable(#[from] Unreadable),
    /// The state in it is that of another program.
    #[error("its state is of version {found}, this program goes on from {current}")]
    State {
        /// That of the state.
        found: u64,
        /// That of this program.
        current: u32,
    },
    /// It is none of these settings.
    #[error("{0}")]
    Settings(String),
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

impl From<State> for umwelt_api::job::State {
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

/// What is kept of a job but its parts and its checkpoint. It is written down with its settings as specs, `W::Spec`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "S: Serialize", deserialize = "S: DeserializeOwned"))]
pub(crate) struct Record<W: Work, S = <W as umwelt_lab::work::Work>::Settings> {
    pub(crate) state: State,
    /// How often it went on after a restart.
    pub(crate) interrupted: u64,
    /// When it was submitted, in s since 1970.
    pub(crate) created_unix: u64,
    pub(crate) settings: S,
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

impl<W: Work, S> Record<W, S> {
    /// The same with other settings.
    fn with<T>(self, settings: T) -> Record<W, T> {
        let Self {
            state,
            interrupted,
            created_unix,
            own,
            key,
            request,
            error,
            report,
            reached,
            ..
        } = self;
        Record {
            state,
            interrupted,
            created_unix,
            settings,
            own,
            key,
            request,
            error,
            report,
            reached,
        }
    }
}

impl<W: Work> Record<W> {
    /// As it is kept.
    ///
    /// # Errors
    /// Where it would not be read back as it is: JSON has no infinity.
    pub(crate) fn stored(&self, id: JobId) -> Result<StoredJob, serde_json::Error> {
        let body = W::FORM.write(&self.clone().with(W::spec(&self.settings)))?;
        if Self::read(&body).as_ref() != Ok(self) {
            return Err(serde_json::Error::custom("some number in it is infinite or none at all"));
        }
        Ok(StoredJob { id, finished: self.state.has_ended(), body })
    }

    /// What is kept.
    pub(crate) fn read(body: &str) -> Result<Self, Unreadable> {
        W::FORM.read_with(body, |content| {
            let kept: Record<W, W::Spec> =
                serde_json::from_value(content).map_err(|it| it.to_string())?;
            let settings = W::settings_of(&kept.settings)?;
            Ok::<_, String>(kept.with(settings))
        })
    }
}

/// Everything that a job goes on from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Checkpoint<W: Work> {
    pub(crate) work: W,
    pub(crate) latest: Option<W::Latest>,
    /// Time in s for which it has run.
    pub(crate) elapsed: f64,
}

/// A checkpoint in the form in which it is kept: the settings of the work stand in the record, and its state is a `T`.
#[derive(Serialize, Deserialize)]
#[serde(bound(serialize = "T: Serialize", deserialize = "T: DeserializeOwned"))]
struct Kept<W: Work, T> {
    work: T,
    latest: Option<W::Latest>,
    elapsed: f64,
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
        let Self { work, latest, elapsed } = self;
        CHECKPOINT.write(&Kept::<W, _> { work: work.state(), latest: *latest, elapsed: *elapsed })
    }

    /// What is kept of a job of these settings.
    pub(crate) fn read(body: &str, settings: &W::Settings) -> Result<Self, Unusable> {
        let Kept::<W, Value> { work, latest, elapsed } = CHECKPOINT.read(body)?;
        // The version first: what stands beside it may be anything.
        let found = work.get("version").and_then(Value::as_u64).unwrap_or(0);
        if found != u64::from(W::STATE_VERSION) {
            return Err(Unusable::State { found, current: W::STATE_VERSION });
        }
        let state: W::State =
            serde_json::from_value(work).map_err(|it| Unusable::Settings(it.to_string()))?;
        let work = W::resume(settings.clone(), state).map_err(Unusable::Settings)?;
        Ok(Self { work, latest, elapsed })
    }
}

/// A part as it is kept.
pub(crate) fn part_body(part: &impl Serialize) -> Result<String, serde_json::Error> {
    PART.write(part)
}

/// The part that is kept.
pub(crate) fn read_part<P: DeserializeOwned>(body: &str) -> Result<P, Unreadable> {
    PART.read(body)
}
