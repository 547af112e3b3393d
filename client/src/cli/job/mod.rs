//! What evolutions and comparisons have in common: the server does them in the background, one at a time.

pub(super) mod files;
pub(super) mod watch;

use super::failure::Failure;
use super::quantity::span;
use crate::client::Client;
use crate::error::Error;
use futures_util::stream::BoxStream;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Write;
use umwelt_api::IdempotencyKey;
use umwelt_api::evolution::State;

/// The names of the states.
pub(super) const STATES: &[&str] = &["queued", "running", "succeeded", "failed", "cancelled"];

/// How far a job has got.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct At {
    /// Simulated episodes driven.
    pub(super) episodes: u64,
    /// Episodes in all.
    pub(super) total_episodes: u64,
    /// The same in words.
    pub(super) words: String,
}

/// What an event of a job tells.
pub(super) enum News {
    /// Where it stands, and how far it has got.
    State(State, At),
    /// Something else.
    Other,
    /// Something of a later version.
    Unknown,
}

/// Something that the server does in the background.
pub(super) trait Job: Serialize + DeserializeOwned + Sized {
    /// What it is called, and its commands with it: `evolution` for `umwelt evolution`.
    const NOUN: &str;

    /// What happens to it.
    type Event: Serialize + DeserializeOwned;

    fn id(&self) -> &str;

    fn state(&self) -> State;

    fn at(&self) -> At;

    /// Why it failed, or what keeps it from going on.
    fn error(&self) -> Option<&str>;

    /// What people are shown of it.
    fn shown(&self) -> String;

    /// The same as it is now.
    async fn newest(&self, client: &Client) -> Result<Self, Error>;

    /// What happens to it from now on.
    async fn events(
        &self,
        client: &Client,
    ) -> Result<BoxStream<'static, Result<Self::Event, Error>>, Error>;

    fn news(event: &Self::Event) -> News;
}

/// That it was submitted, and how to watch it.
pub(super) fn accepted<J: Job>(job: &J) -> String {
    let (id, noun) = (job.id(), J::NOUN);
    let state = match job.state() {
        State::Queued => "waits for its turn",
        State::Running => "goes on",
        State::Succeeded => "has succeeded",
        State::Failed => "has failed",
        State::Cancelled => "was cancelled",
    };
    format!("{id} {state}; watch it: umwelt {noun} watch {id}")
}

/// Why it was not submitted; where it may have been all the same, how to find out without a second one.
pub(super) fn refused(error: Error, key: &IdempotencyKey) -> Failure {
    let unsure = matches!(error, Error::Transport { .. });
    match Failure::from(error) {
        Failure::Failed(text) if unsure => Failure::Failed(format!(
            "{text}\n  the same again with --idempotency-key {key} submits it no more than once"
        )),
        failure => failure,
    }
}

/// A job in words: where it stands, why it does not go on, and `lines` of a name and a text.
pub(super) fn described<J: Job>(job: &J, lines: &[(&str, String)]) -> String {
    let mut text = format!("{}: {}, {}\n", job.id(), job.state().name(), job.at().words);
    if let Some(error) = job.error() {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  error        {error}");
    }
    for (name, value) in lines {
        let _ = writeln!(text, "  {name:<12} {value}");
    }
    text
}

/// How many episodes were driven in what time, and over how many restarts of the server.
pub(super) fn episodes(at: &At, elapsed_s: f64, interrupted: u64) -> String {
    let restarts = match interrupted {
        0 => String::new(),
        1 => ", resumed after one restart of the server".to_owned(),
        count => format!(", resumed after {count} restarts of the server"),
    };
    format!("{} of {}, {}{restarts}", at.episodes, at.total_episodes, span(elapsed_s))
}

/// The time that a job which goes on still needs, as `, 12.0 s left`; nothing where it is not known.
pub(super) fn time_left(remaining_s: Option<f64>) -> String {
    remaining_s.map_or_else(String::new, |seconds| format!(", {} left", span(seconds)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_called_as_on_the_wire() {
        assert_eq!(STATES, State::ALL.map(State::name));
    }

    #[test]
    fn who_cannot_know_whether_it_was_submitted_is_told_the_key() {
        let key = "k-1".parse().unwrap();
        let what: Box<str> = "POST http://h/v1/evolutions".into();
        let cause = "reset".to_owned();
        let lost = Error::Transport { what: what.clone(), failure: crate::Failure::Closed, cause };
        let Failure::Failed(text) = refused(lost, &key) else { panic!("the call was right") };
        assert!(text.contains("--idempotency-key k-1"), "{text}");
        let foreign = Error::Protocol { what, why: "w".to_owned() };
        let Failure::Failed(text) = refused(foreign, &key) else { panic!("the call was right") };
        assert!(!text.contains("k-1"), "{text}");
    }
}
