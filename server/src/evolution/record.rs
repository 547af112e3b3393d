//! What is kept of an evolution: JSON with a version, of which the store knows nothing.
//!
//! The record changes with the state alone. What changes with every generation stands in the checkpoint and in the
//! generations.

use crate::store::StoredEvolution;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use umwelt_api::{EvolutionId, PriorId};
use umwelt_core::evolution::{
    Evolution, EvolutionSettings, Generation, Report, STATE_VERSION, Spread, Stage,
};

/// Version of everything in this module.
const VERSION: u32 = 1;

/// Why something that is kept cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unreadable {
    /// Another program wrote it.
    #[error("it is of version {0}, this program reads {VERSION}")]
    Version(u64),
    /// The state of the evolution in it is that of another program.
    #[error("its state is of version {0}, this program goes on from {STATE_VERSION}")]
    State(u64),
    /// It is damaged.
    #[error("it is damaged: {0}")]
    Damaged(String),
}

/// Where an evolution stands.
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

/// How far an evolution has got, as far as that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Reached {
    /// None before it was begun.
    pub(crate) stage: Option<Stage>,
    /// Of the last generation that has ended.
    pub(crate) fitness: Option<Spread>,
    pub(crate) episodes: u64,
    pub(crate) total_episodes: u64,
    /// Time in s for which it has run.
    pub(crate) elapsed: f64,
}

impl Reached {
    pub(crate) fn of(evolution: &Evolution, fitness: Option<Spread>, elapsed: f64) -> Self {
        Self {
            stage: Some(evolution.stage()),
            fitness,
            episodes: evolution.episodes(),
            total_episodes: evolution.total_episodes(),
            elapsed,
        }
    }
}

/// What is kept of an evolution but its generations and its checkpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    pub(crate) state: State,
    /// How often it went on after a restart.
    pub(crate) interrupted: u64,
    /// When it was submitted, in s since 1970.
    pub(crate) created_unix: u64,
    pub(crate) settings: EvolutionSettings,
    /// The name that the champion gets.
    pub(crate) prior: PriorId,
    /// The key under which it was submitted, if any.
    pub(crate) key: Option<String>,
    /// Hash of the request.
    pub(crate) request: String,
    /// Why it failed.
    pub(crate) error: Option<String>,
    pub(crate) report: Option<Report>,
    /// How far it had got when the state changed.
    pub(crate) reached: Reached,
}

impl Record {
    /// As it is kept.
    pub(crate) fn stored(&self, number: u64) -> Result<StoredEvolution, serde_json::Error> {
        Ok(StoredEvolution {
            id: EvolutionId::numbered(number).to_string(),
            number,
            finished: self.state.has_ended(),
            body: write(self)?,
        })
    }

    /// What is kept.
    pub(crate) fn read(body: &str) -> Result<Self, Unreadable> {
        read(body)
    }
}

/// Everything that an evolution goes on from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    pub(crate) evolution: Evolution,
    /// Of the last generation that has ended.
    pub(crate) fitness: Option<Spread>,
    /// Time in s for which it has run.
    pub(crate) elapsed: f64,
}

impl Checkpoint {
    /// As it is kept.
    pub(crate) fn body(&self) -> Result<String, serde_json::Error> {
        write(self)
    }

    /// What is kept.
    pub(crate) fn read(body: &str) -> Result<Self, Unreadable> {
        // The versions first: what stands beside them may be anything.
        match serde_json::from_str(body) {
            Ok(Peek { content: PeekContent { evolution: Version { version } } })
                if version != u64::from(STATE_VERSION) =>
            {
                Err(Unreadable::State(version))
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
    evolution: Version,
}

/// A generation as it is kept.
pub(crate) fn generation_body(generation: &Generation) -> Result<String, serde_json::Error> {
    write(generation)
}

/// The generation that is kept.
pub(crate) fn read_generation(body: &str) -> Result<Generation, Unreadable> {
    read(body)
}

#[derive(Serialize, Deserialize)]
struct Versioned<T> {
    version: u64,
    content: T,
}

fn write(content: &impl Serialize) -> Result<String, serde_json::Error> {
    serde_json::to_string(&Versioned { version: VERSION.into(), content })
}

fn read<T: DeserializeOwned>(body: &str) -> Result<T, Unreadable> {
    let damaged = |error: serde_json::Error| Unreadable::Damaged(error.to_string());
    let Version { version } = serde_json::from_str(body).map_err(damaged)?;
    if version != u64::from(VERSION) {
        return Err(Unreadable::Version(version));
    }
    let versioned: Versioned<T> = serde_json::from_str(body).map_err(damaged)?;
    Ok(versioned.content)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let settings = EvolutionSettings::preset("quick").unwrap();
        let evolution = Evolution::new(settings).unwrap();
        let fitness = Some(Spread { best: 0.1 + 0.2, mean: 1.0 / 3.0 });
        Checkpoint { evolution, fitness, elapsed: 12.5 }
    }

    #[test]
    fn a_checkpoint_comes_back_bit_for_bit() {
        let checkpoint = checkpoint();
        assert_eq!(Checkpoint::read(&checkpoint.body().unwrap()), Ok(checkpoint));
    }

    /// The bug to fear: a state of tomorrow's program read as if it were today's.
    #[test]
    fn another_version_is_told_from_damage() {
        let body = checkpoint().body().unwrap();
        assert_eq!(
            Checkpoint::read(&body.replacen("\"version\":1", "\"version\":2", 1)),
            Err(Unreadable::Version(2))
        );
        assert_eq!(Checkpoint::read(r#"{"version":2,"what":0}"#), Err(Unreadable::Version(2)));
        let state = body.replace("\"evolution\":{\"version\":1", "\"evolution\":{\"version\":7");
        assert_ne!(state, body);
        assert_eq!(Checkpoint::read(&state), Err(Unreadable::State(7)));
        let foreign = r#"{"version":1,"content":{"evolution":{"version":9,"all":"new"}}}"#;
        assert_eq!(Checkpoint::read(foreign), Err(Unreadable::State(9)));
        for damaged in
            ["", "{", "{}", r#"{"version":1}"#, r#"{"version":1,"content":{}}"#, &body[..90]]
        {
            assert!(matches!(Checkpoint::read(damaged), Err(Unreadable::Damaged(_))), "{damaged}");
        }
    }
}
