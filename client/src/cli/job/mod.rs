//! Jobs of any kind: submitted, listed, shown, watched, cancelled, removed.

pub(super) mod files;
pub(super) mod noun;
pub(super) mod submit;
pub(super) mod watch;

use super::failure::Failure;
use super::quantity::span;
use std::fmt::Write;
use umwelt_api::IdempotencyKey;
use umwelt_api::job::{Job, JobKind, State};
use umwelt_client::Error;

/// The names of the states.
pub(super) const STATES: &[&str] = &["queued", "running", "succeeded", "failed", "cancelled"];

/// A kind of job as the command line shows it; its name is that of its commands: `evolution` for `umwelt evolution`.
pub(super) trait Noun: JobKind {
    /// The command that submits one, as `evolve`.
    const VERB: &'static str;

    /// How far one has got, in words.
    fn words(progress: &Self::Progress) -> String;

    /// Some of them, one a line.
    fn table(jobs: &[Job<Self>]) -> String;

    /// One of them, all of it.
    fn show(job: &Job<Self>) -> String;
}

/// That it was submitted, and how to watch it.
pub(super) fn accepted<K: Noun>(job: &Job<K>) -> String {
    let (id, noun) = (&job.id, K::NAME);
    let state = match job.state {
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
pub(super) fn described<K: Noun>(job: &Job<K>, lines: &[(&str, String)]) -> String {
    let words = K::words(&job.progress);
    let mut text = format!("{}: {}, {words}\n", job.id, job.state.name());
    if let Some(error) = &job.error {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  error        {error}");
    }
    for (name, value) in lines {
        let _ = writeln!(text, "  {name:<12} {value}");
    }
    text
}

/// How many episodes were driven in what time, and over how many restarts of the server.
pub(super) fn episodes<K: Noun>(job: &Job<K>, elapsed_s: f64) -> String {
    let restarts = match job.interrupted {
        0 => String::new(),
        1 => ", resumed after one restart of the server".to_owned(),
        count => format!(", resumed after {count} restarts of the server"),
    };
    let (driven, total) = K::episodes(&job.progress);
    format!("{driven} of {total}, {}{restarts}", span(elapsed_s))
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
    fn an_error_that_may_hide_a_submission_names_the_key() {
        let key = "k-1".parse().unwrap();
        let what: Box<str> = "POST http://h/v1/evolutions".into();
        let cause = "reset".to_owned();
        let lost =
            Error::Transport { what: what.clone(), failure: umwelt_client::Failure::Closed, cause };
        let Failure::Failed(text) = refused(lost, &key) else { panic!("the call was right") };
        assert!(text.contains("--idempotency-key k-1"), "{text}");
        let foreign = Error::Protocol { what, why: "w".to_owned() };
        let Failure::Failed(text) = refused(foreign, &key) else { panic!("the call was right") };
        assert!(!text.contains("k-1"), "{text}");
    }
}
