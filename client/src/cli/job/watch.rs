//! Watching a job: a progress bar while it goes on, what came of it at the end.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use super::{At, Job, News};
use crate::client::Client;
use crate::error::Error;
use futures_util::StreamExt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::Duration;
use tokio::time::Instant;
use umwelt_api::evolution::State;
use umwelt_api::visible;

/// A log, as opposed to a terminal, gets a line no more often than this.
const PAUSE: Duration = Duration::from_secs(2);

/// What JSON there is of watching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Told {
    /// A line for the job as it is, for each event, and for the job as it has ended.
    Everything,
    /// One document: the job as it has ended.
    TheEnd,
}

/// Watches until it has ended; then shows it. Fails where it did not succeed. Ctrl-C leaves it running.
pub(in super::super) async fn watch<J: Job>(
    client: &Client,
    output: &mut Output,
    job: &J,
    told: Told,
) -> Result<(), Failure> {
    tokio::select! {
        ended = follow(client, output, job, told) => ended,
        _ = tokio::signal::ctrl_c() => Err(left_running(job)),
    }
}

fn left_running<J: Job>(job: &J) -> Failure {
    let (id, noun) = (job.id(), J::NOUN);
    Failure::Failed(format!(
        "no longer watching; {id} goes on (umwelt {noun} watch {id}, umwelt {noun} cancel {id})"
    ))
}

async fn follow<J: Job>(
    client: &Client,
    output: &mut Output,
    job: &J,
    told: Told,
) -> Result<(), Failure> {
    let tells_events = told == Told::Everything;
    if tells_events {
        output.json_line(job)?;
    }
    let mut events = wait(job.events(client)).await.map_err(|error| unseen(job, error))?;
    let mut bar = Bar::new(job);
    bar.show(job.state(), &job.at());
    while let Some(event) = events.next().await {
        match event {
            Ok(event) => {
                let news = J::news(&event);
                if let News::State(state, at) = &news {
                    bar.show(*state, at);
                }
                if tells_events && !matches!(news, News::Unknown) {
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
    let job = wait(job.newest(client)).await.map_err(|error| unseen(job, error))?;
    match told {
        Told::Everything => output.line(&job, J::shown)?,
        Told::TheEnd => output.result(&job, J::shown)?,
    }
    ended(&job)
}

/// Why it cannot be watched; where it goes on all the same, how to come back to it.
fn unseen<J: Job>(job: &J, error: Error) -> Failure {
    let (id, noun) = (job.id(), J::NOUN);
    let transient = error.is_transient();
    match Failure::from(error) {
        Failure::Failed(text) if transient => Failure::Failed(format!(
            "{text}\n  {id} does not need a watcher: umwelt {noun} watch {id}"
        )),
        failure => failure,
    }
}

/// Whether it has succeeded.
fn ended<J: Job>(job: &J) -> Result<(), Failure> {
    let (id, noun) = (job.id(), J::NOUN);
    match job.state() {
        State::Succeeded => Ok(()),
        State::Failed => {
            let why = job.error().unwrap_or("the server does not say why");
            Err(Failure::Failed(format!("{id} has failed: {why}")))
        }
        State::Cancelled => Err(Failure::Failed(format!("{id} was cancelled"))),
        State::Queued | State::Running => Err(Failure::Failed(format!(
            "the events have ended, {id} has not: umwelt {noun} watch {id}"
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
    fn new(job: &impl Job) -> Self {
        let id = job.id().to_owned();
        let bar = io::stderr().is_terminal().then(|| {
            let (target, episodes) = (ProgressDrawTarget::stderr(), job.at().total_episodes);
            let bar = ProgressBar::with_draw_target(Some(episodes.max(1)), target)
                .with_prefix(id.clone());
            match ProgressStyle::with_template("{prefix} {bar:24} {percent:>3} % {msg}") {
                Ok(style) => bar.with_style(style.progress_chars("=> ")),
                Err(_) => bar,
            }
        });
        Self { id, bar, said: None }
    }

    fn show(&mut self, state: State, at: &At) {
        if let Some(bar) = &self.bar {
            bar.set_length(at.total_episodes.max(1));
            bar.set_position(at.episodes);
            bar.set_message(visible::line(&at.words).into_owned());
        } else if is_news(self.said.as_ref(), state, &at.words, Instant::now()) {
            say(&line(&self.id, state, at));
            self.said = Some((state, at.words.clone(), Instant::now()));
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

fn line(id: &str, state: State, at: &At) -> String {
    let share = 1e2 * at.episodes as f64 / at.total_episodes.max(1) as f64;
    format!("{id}: {}, {share:.0} %, {}", state.name(), at.words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::COMPARISON;
    use crate::evolve::tests::EVOLUTION;
    use crate::test_server::{Server, answer, json};
    use hyper::StatusCode;
    use serde::de::DeserializeOwned;
    use serde_json::Value;
    use umwelt_api::comparison::Comparison;
    use umwelt_api::evolution::Evolution;

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
        let evolution: Evolution = serde_json::from_str(EVOLUTION).unwrap();
        let comparison: Comparison = serde_json::from_str(COMPARISON).unwrap();
        for (left, id, noun) in [
            (left_running(&evolution), "evolution-12", "evolution"),
            (left_running(&comparison), "comparison-12", "comparison"),
        ] {
            let Failure::Failed(text) = left else { panic!("not wrong") };
            let watch = format!("{id} goes on (umwelt {noun} watch {id}, umwelt {noun} cancel");
            assert!(text.contains(&watch), "{text}");
        }
    }

    /// A server on which `job` ends in `state`, watched: what was written, and how it ended.
    async fn watched<J: Job + DeserializeOwned>(
        job: &'static str,
        state: &'static str,
        told: Told,
    ) -> (String, Result<(), Failure>) {
        let server = Server::start(move |request| async move {
            let ended = job.replace("\"state\": \"queued\"", &format!("\"state\": \"{state}\""));
            if !request.uri().path().ends_with("/events") {
                return json(StatusCode::OK, &ended);
            }
            let job: Value = serde_json::from_str(job).unwrap();
            let last = request.headers().get("last-event-id").map(|it| it.to_str().unwrap());
            // Generations that are over are not asked for again.
            assert_eq!(last, (J::NOUN == "evolution").then_some("0"));
            let event = serde_json::json!({"id": 0, J::NOUN: job[J::NOUN], "type": "state",
                "state": state, "progress": job["progress"], "error": null});
            let later = serde_json::json!({"id": 0, J::NOUN: job[J::NOUN], "type": "of-tomorrow"});
            let text = format!("id: 0\ndata: {later}\n\nid: 0\ndata: {event}\n\n");
            answer(StatusCode::OK, "text/event-stream", &text)
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let job: J = serde_json::from_str(job).unwrap();
        let (mut output, written) = Output::kept(true);
        let watched = watch(&client, &mut output, &job, told);
        // Who watches for ever fails here rather than hangs.
        let ended = tokio::time::timeout(Duration::from_secs(10), watched).await.unwrap();
        let written = written.lock().unwrap();
        (String::from_utf8_lossy(&written).into_owned(), ended)
    }

    #[tokio::test]
    async fn who_cannot_watch_is_told_how_to_come_back() {
        let client = Client::new("http://127.0.0.1:1").unwrap();
        let evolution: Evolution = serde_json::from_str(EVOLUTION).unwrap();
        let failed = watch(&client, &mut Output::nowhere(), &evolution, Told::Everything).await;
        let Err(Failure::Failed(text)) = failed else { panic!("nobody listens there") };
        assert!(text.contains("umwelt evolution watch evolution-12"), "{text}");
    }

    #[tokio::test]
    async fn only_success_is_success() {
        for (state, words) in [
            ("succeeded", None),
            ("failed", Some("has failed")),
            ("cancelled", Some("was cancelled")),
        ] {
            for (_, ended) in [
                watched::<Evolution>(EVOLUTION, state, Told::Everything).await,
                watched::<Comparison>(COMPARISON, state, Told::TheEnd).await,
            ] {
                match (ended, words) {
                    (Ok(()), None) => {}
                    (Err(Failure::Failed(text)), Some(words)) => {
                        assert!(text.contains(words), "{text}");
                    }
                    (ended, _) => panic!("{state}: {ended:?}"),
                }
            }
        }
    }

    #[tokio::test]
    async fn json_is_a_line_for_everything_or_the_end_alone() {
        let lines = |text: &str| -> Vec<Value> {
            text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
        };
        let (text, _) = watched::<Evolution>(EVOLUTION, "succeeded", Told::Everything).await;
        let told: Vec<_> = lines(&text).iter().map(|line| line["state"].clone()).collect();
        assert_eq!(told, ["queued", "succeeded", "succeeded"], "{text}");
        let (text, _) = watched::<Comparison>(COMPARISON, "succeeded", Told::TheEnd).await;
        let comparison: Comparison = serde_json::from_str(&text).unwrap();
        assert_eq!(comparison.state, State::Succeeded);
    }
}
