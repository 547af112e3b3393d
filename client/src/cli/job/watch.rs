//! Watching an evolution: a progress bar while it goes on, its report at the end.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use crate::client::Client;
use crate::error::Error;
use futures_util::StreamExt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::Duration;
use tokio::time::Instant;
use umwelt_api::evolution::{Evolution, Kind, Progress, State};

/// A log, as opposed to a terminal, gets a line no more often than this.
const PAUSE: Duration = Duration::from_secs(2);

/// Watches until it has ended; then shows it. Fails where it did not succeed. Ctrl-C leaves it running.
pub(in super::super) async fn watch(
    client: &Client,
    output: &mut Output,
    evolution: Evolution,
) -> Result<(), Failure> {
    let id = evolution.evolution.clone();
    tokio::select! {
        ended = follow(client, output, evolution) => ended,
        _ = tokio::signal::ctrl_c() => Err(left_running(id.as_str())),
    }
}

fn left_running(id: &str) -> Failure {
    Failure::Failed(format!(
        "no longer watching; {id} goes on (umwelt evolution watch {id}, umwelt evolution cancel {id})"
    ))
}

async fn follow(client: &Client, output: &mut Output, evolution: Evolution) -> Result<(), Failure> {
    let id = evolution.evolution.clone();
    output.json_line(&evolution)?;
    // What has ended before is known: the bar needs what comes.
    let after = Some(evolution.progress.generation);
    let connected = wait(client.evolution_events(&id, after)).await;
    let mut events = connected.map_err(|error| unseen(error, id.as_str()))?;
    let mut bar = Bar::new(&evolution);
    bar.show(evolution.state, &evolution.progress);
    while let Some(event) = events.next().await {
        match event {
            Ok(event) => {
                if let Kind::State { state, progress, .. } = &event.kind {
                    bar.show(*state, progress);
                }
                if event.kind != Kind::Other {
                    output.json_line(&event)?;
                }
            }
            Err(error) if error.is_transient() => {
                bar.note(&format!("interrupted, trying again: {error}"));
            }
            Err(error @ Error::Protocol { .. }) => bar.note(&error.to_string()),
            Err(error) => return Err(error.into()),
        }
    }
    drop(bar);
    let evolution = wait(client.get_evolution(&id)).await;
    ended(output, &evolution.map_err(|error| unseen(error, id.as_str()))?)
}

/// Why it cannot be watched; where the evolution goes on all the same, how to come back to it.
fn unseen(error: Error, id: &str) -> Failure {
    let transient = error.is_transient();
    match Failure::from(error) {
        Failure::Failed(text) if transient => Failure::Failed(format!(
            "{text}\n  {id} does not need a watcher: umwelt evolution watch {id}"
        )),
        failure => failure,
    }
}

/// Shows what came of it.
fn ended(output: &mut Output, evolution: &Evolution) -> Result<(), Failure> {
    output.line(evolution, super::show)?;
    let id = &evolution.evolution;
    match evolution.state {
        State::Succeeded => Ok(()),
        State::Failed => {
            let why = evolution.error.as_deref().unwrap_or("the server does not say why");
            Err(Failure::Failed(format!("{id} has failed: {why}")))
        }
        State::Cancelled => Err(Failure::Failed(format!("{id} was cancelled"))),
        State::Queued | State::Running => Err(Failure::Failed(format!(
            "the events have ended, {id} has not: umwelt evolution watch {id}"
        ))),
    }
}

/// Progress on standard error: a bar on a terminal, lines elsewhere.
struct Bar {
    id: String,
    /// On a terminal.
    bar: Option<ProgressBar>,
    said: Option<(State, String, Instant)>,
}

impl Bar {
    fn new(evolution: &Evolution) -> Self {
        let id = evolution.evolution.to_string();
        let bar = io::stderr().is_terminal().then(|| {
            let (target, episodes) =
                (ProgressDrawTarget::stderr(), evolution.progress.total_episodes);
            let bar = ProgressBar::with_draw_target(Some(episodes.max(1)), target)
                .with_prefix(id.clone());
            match ProgressStyle::with_template("{prefix} {bar:24} {percent:>3} % {msg}") {
                Ok(style) => bar.with_style(style.progress_chars("=> ")),
                Err(_) => bar,
            }
        });
        Self { id, bar, said: None }
    }

    fn show(&mut self, state: State, progress: &Progress) {
        let text = super::progress(progress);
        if let Some(bar) = &self.bar {
            bar.set_length(progress.total_episodes.max(1));
            bar.set_position(progress.episodes);
            bar.set_message(text);
        } else if is_news(self.said.as_ref(), state, &text, Instant::now()) {
            say(&line(&self.id, state, progress, &text));
            self.said = Some((state, text, Instant::now()));
        }
    }

    /// Says something beside the progress.
    fn note(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| say(text)),
            None => say(text),
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Whether a log is told: what it has not been told, and not too often; a change of state always.
fn is_news(
    said: Option<&(State, String, Instant)>,
    state: State,
    text: &str,
    now: Instant,
) -> bool {
    said.is_none_or(|(before, line, when)| {
        *before != state || (line != text && now.duration_since(*when) >= PAUSE)
    })
}

fn line(id: &str, state: State, progress: &Progress, text: &str) -> String {
    let share = 1e2 * progress.episodes as f64 / progress.total_episodes.max(1) as f64;
    format!("{id}: {}, {share:.0} %, {text}", state.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolve::tests::EVOLUTION;
    use crate::test_server::{Server, answer, json};
    use hyper::StatusCode;

    #[test]
    fn a_log_is_told_no_more_than_every_two_seconds() {
        let now = Instant::now();
        let said = (State::Running, "a".to_owned(), now);
        let later = now + PAUSE;
        assert!(is_news(None, State::Running, "a", now));
        assert!(!is_news(Some(&said), State::Running, "b", now + PAUSE / 2));
        assert!(is_news(Some(&said), State::Running, "b", later));
        assert!(!is_news(Some(&said), State::Running, "a", later));
        assert!(is_news(Some(&said), State::Succeeded, "a", now));
    }

    #[test]
    fn who_stops_watching_is_told_that_it_goes_on() {
        let Failure::Failed(text) = left_running("evolution-12") else { panic!("not wrong") };
        assert!(
            text.contains("evolution-12 goes on (umwelt evolution watch evolution-12"),
            "{text}"
        );
    }

    /// A server on which evolution-12 ends in `state`.
    async fn watched(state: &'static str) -> Result<(), Failure> {
        let server = Server::start(move |request| async move {
            let ended =
                EVOLUTION.replace("\"state\": \"queued\"", &format!("\"state\": \"{state}\""));
            if !request.uri().path().ends_with("/events") {
                return json(StatusCode::OK, &ended);
            }
            assert_eq!(request.headers()["last-event-id"], "0");
            let evolution: serde_json::Value = serde_json::from_str(EVOLUTION).unwrap();
            let event = serde_json::json!({"id": 0, "evolution": "evolution-12", "type": "state",
                "state": state, "progress": evolution["progress"], "error": null});
            answer(StatusCode::OK, "text/event-stream", &format!("id: 0\ndata: {event}\n\n"))
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let evolution = serde_json::from_str(EVOLUTION).unwrap();
        watch(&client, &mut Output::nowhere(), evolution).await
    }

    #[tokio::test]
    async fn who_cannot_watch_is_told_how_to_come_back() {
        let client = Client::new("http://127.0.0.1:1").unwrap();
        let evolution = serde_json::from_str(EVOLUTION).unwrap();
        let failed = watch(&client, &mut Output::nowhere(), evolution).await;
        let Err(Failure::Failed(text)) = failed else { panic!("nobody listens there") };
        assert!(text.contains("umwelt evolution watch evolution-12"), "{text}");
    }

    #[tokio::test]
    async fn only_success_is_success() {
        assert!(watched("succeeded").await.is_ok());
        for (state, words) in [("failed", "has failed"), ("cancelled", "was cancelled")] {
            let Err(Failure::Failed(text)) = watched(state).await else { panic!("it did not") };
            assert!(text.contains(words), "{text}");
        }
    }
}
