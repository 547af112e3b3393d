//! Watching a job: a progress bar while it goes on, its result at the end. As JSON it is a line for the job as it is, for
//! each event, and for the job as it has ended.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use super::Noun;
use futures_util::StreamExt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::Duration;
use tokio::time::Instant;
use umwelt_api::job::{Job, JobNews, State};
use umwelt_api::visible;
use umwelt_client::{Client, Error};

/// A log, as opposed to a terminal, gets a line no more often than this.
const PAUSE: Duration = Duration::from_secs(2);

/// The name of an event that this program does not know.
const OF_A_LATER_VERSION: &str = "other";

/// How far a job has got.
#[derive(Clone, Debug, PartialEq, Eq)]
struct At {
    /// Simulated episodes driven.
    episodes: u64,
    /// Episodes in all.
    total_episodes: u64,
    /// The same in words.
    words: String,
}

impl At {
    fn of<K: Noun>(progress: &K::Progress) -> Self {
        let (episodes, total_episodes) = K::episodes(progress);
        Self { episodes, total_episodes, words: K::words(progress) }
    }
}

/// Watches until it has ended; then shows it. Fails where it did not succeed. Ctrl-C leaves it running.
pub(in super::super) async fn watch<K: Noun>(
    client: &Client,
    output: &mut Output,
    job: &Job<K>,
) -> Result<(), Failure> {
    tokio::select! {
        ended = follow(client, output, job) => ended,
        _ = tokio::signal::ctrl_c() => Err(left_running(job)),
    }
}

fn left_running<K: Noun>(job: &Job<K>) -> Failure {
    let (id, noun) = (&job.id, K::NAME);
    Failure::Failed(format!(
        "no longer watching; {id} goes on (umwelt {noun} watch {id}, umwelt {noun} cancel {id})"
    ))
}

async fn follow<K: Noun>(
    client: &Client,
    output: &mut Output,
    job: &Job<K>,
) -> Result<(), Failure> {
    output.json_line(job)?;
    // What has happened before is no news.
    let after = Some(K::event_id(&job.progress));
    let events = wait(client.job_events::<K>(&job.id, after)).await;
    let mut events = events.map_err(|error| unseen(job, error))?;
    let mut bar = Bar::new(job);
    bar.show(job.state, &At::of::<K>(&job.progress));
    while let Some(event) = events.next().await {
        match event {
            Ok(event) => {
                if let Some((state, progress)) = event.kind.state() {
                    bar.show(state, &At::of::<K>(progress));
                }
                if event.kind.name() != OF_A_LATER_VERSION {
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
    let job = wait(client.job::<K>(&job.id)).await.map_err(|error| unseen(job, error))?;
    output.line(&job, K::show)?;
    ended(&job)
}

/// Why it cannot be watched; where it goes on all the same, how to come back to it.
fn unseen<K: Noun>(job: &Job<K>, error: Error) -> Failure {
    let (id, noun) = (&job.id, K::NAME);
    let transient = error.is_transient();
    match Failure::from(error) {
        Failure::Failed(text) if transient => Failure::Failed(format!(
            "{text}\n  {id} does not need a watcher: umwelt {noun} watch {id}"
        )),
        failure => failure,
    }
}

/// Whether it has succeeded.
fn ended<K: Noun>(job: &Job<K>) -> Result<(), Failure> {
    let (id, noun) = (&job.id, K::NAME);
    match job.state {
        State::Succeeded => Ok(()),
        State::Failed => {
            let why = job.error.as_deref().unwrap_or("the server does not say why");
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
    fn new<K: Noun>(job: &Job<K>) -> Self {
        let id = job.id.to_string();
        let bar = io::stderr().is_terminal().then(|| {
            let (_, episodes) = K::episodes(&job.progress);
            let target = ProgressDrawTarget::stderr();
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

/// Whether a log gets a line: for what it has not shown, and not too often; for a change of state always.
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
    use crate::samples::{COMPARISON, EVOLUTION};
    use crate::test_server::{Server, answer, json};
    use hyper::StatusCode;
    use serde_json::Value;
    use umwelt_api::comparison::{Comparison, ComparisonKind};
    use umwelt_api::evolution::{Evolution, EvolutionKind};

    #[test]
    fn a_log_gets_a_line_no_more_than_every_two_seconds() {
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
    fn the_end_of_watching_says_that_the_job_goes_on() {
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
    async fn watched<K: Noun>(
        job: &'static str,
        state: &'static str,
    ) -> (String, Result<(), Failure>) {
        let server = Server::start(move |request| async move {
            let ended = job.replace("\"state\": \"queued\"", &format!("\"state\": \"{state}\""));
            if !request.uri().path().ends_with("/events") {
                return json(StatusCode::OK, &ended);
            }
            let job: Value = serde_json::from_str(job).unwrap();
            let last = request.headers().get("last-event-id").map(|it| it.to_str().unwrap());
            // What is over is not asked for again.
            assert_eq!(last, Some("0"));
            let event = serde_json::json!({"id": 0, K::NAME: job[K::NAME], "type": "state",
                "state": state, "progress": job["progress"], "error": null});
            let later = serde_json::json!({"id": 0, K::NAME: job[K::NAME], "type": "of-tomorrow"});
            let text = format!("id: 0\ndata: {later}\n\nid: 0\ndata: {event}\n\n");
            answer(StatusCode::OK, "text/event-stream", &text)
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let job: Job<K> = serde_json::from_str(job).unwrap();
        let (mut output, written) = Output::kept(true);
        let watched = watch(&client, &mut output, &job);
        // Watching for ever fails here rather than hangs.
        let ended = tokio::time::timeout(Duration::from_secs(10), watched).await.unwrap();
        let written = written.lock().unwrap();
        (String::from_utf8_lossy(&written).into_owned(), ended)
    }

    #[tokio::test]
    async fn a_job_that_cannot_be_watched_names_the_command_to_come_back() {
        let client = Client::new("http://127.0.0.1:1").unwrap();
        let evolution: Evolution = serde_json::from_str(EVOLUTION).unwrap();
        let failed = watch(&client, &mut Output::nowhere(), &evolution).await;
        let Err(Failure::Failed(text)) = failed else { panic!("no server listens there") };
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
                watched::<EvolutionKind>(EVOLUTION, state).await,
                watched::<ComparisonKind>(COMPARISON, state).await,
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
    async fn json_is_a_line_for_the_job_each_event_and_the_end() {
        for (text, _) in [
            watched::<EvolutionKind>(EVOLUTION, "succeeded").await,
            watched::<ComparisonKind>(COMPARISON, "succeeded").await,
        ] {
            let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
            let states: Vec<_> = lines.map(|line| line["state"].clone()).collect();
            assert_eq!(states, ["queued", "succeeded", "succeeded"], "{text}");
        }
    }
}
