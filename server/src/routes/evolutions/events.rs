//! What happens to an evolution, as server-sent events.
//!
//! Invariants: every generation is told once, in order, and only once it is kept; the id of an event is the number of
//! generations that have ended, so a stream resumes after a restart where it was; no state counts a generation that was
//! not told before it, and the state in which the evolution has ended is the last event.

use super::kept;
use crate::app::App;
use crate::evolution::{Job, Shown};
use crate::extract::Evolution;
use crate::failure::{self, Result};
use crate::routes::events::{KEEP_ALIVE, last_event_id};
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::IntoResponse;
use axum::response::sse::{self, KeepAlive, Sse};
use futures_util::stream;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, watch};
use umwelt_api::evolution::{Event, Generation, Kind};

/// How often the state is told while nothing but time passes.
const TICK: Duration = Duration::from_secs(2);

/// Generations that are read from the store at a time.
const AT_A_TIME: usize = 50;

pub(crate) async fn events(
    State(app): State<App>,
    Evolution(job): Evolution,
    headers: HeaderMap,
) -> Result {
    let told = last_event_id(&headers)?.unwrap_or(0);
    let limit = app.config.max_event_streams;
    let permit = Arc::clone(&app.streams).try_acquire_owned();
    let permit = permit.map_err(|_| failure::limit_reached("event streams", limit))?;
    let follower = Follower {
        shown: job.follow(),
        closing: app.closing.subscribe(),
        app,
        job,
        told,
        ready: VecDeque::new(),
        is_state_due: true,
        is_over: false,
        _permit: permit,
    };
    let events = stream::unfold(follower, |mut follower| async move {
        let event = follower.next().await?;
        Some((Ok::<_, Infallible>(event), follower))
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE)).into_response())
}

/// Somebody who follows an evolution.
struct Follower {
    app: App,
    job: Arc<Job>,
    shown: watch::Receiver<Shown>,
    closing: watch::Receiver<bool>,
    /// Generations that have been told.
    told: u64,
    ready: VecDeque<sse::Event>,
    /// Whether the state is to be told once the generations are.
    is_state_due: bool,
    is_over: bool,
    _permit: OwnedSemaphorePermit,
}

impl Follower {
    /// The next event; none at the end.
    async fn next(&mut self) -> Option<sse::Event> {
        loop {
            if let Some(event) = self.ready.pop_front() {
                return Some(event);
            }
            if self.is_over || *self.closing.borrow() {
                return None;
            }
            let shown = self.shown.borrow_and_update().clone();
            if shown.generations() > self.told {
                self.tell_generations().await?;
                self.is_state_due = true;
            } else if self.is_state_due {
                self.is_state_due = false;
                self.is_over = shown.has_ended() || shown.removed;
                self.tell(&self.job.event(&shown));
            } else {
                tokio::select! {
                    changed = self.shown.changed() => changed.ok()?,
                    () = tokio::time::sleep(TICK) => {}
                    _ = self.closing.wait_for(|closing| *closing) => return None,
                }
                self.is_state_due = true;
            }
        }
    }

    /// Makes the next generations ready; none where they cannot be had: the follower will ask again for them.
    async fn tell_generations(&mut self) -> Option<()> {
        let from = usize::try_from(self.told).ok()?;
        let bred = match kept(&self.app, &self.job, from, AT_A_TIME).await {
            Ok(bred) if !bred.is_empty() => bred,
            // Forgotten meanwhile.
            Ok(_) => return None,
            Err(failure) => {
                tracing::error!(evolution = %self.job.id(), error = failure.message(), "a stream ends");
                return None;
            }
        };
        for generation in &bred {
            let event = Event::generation(self.job.id().clone(), Generation::from(generation));
            self.told = event.id;
            self.tell(&event);
        }
        Some(())
    }

    /// Makes an event ready. A state has no id in the stream: it would count generations as told.
    fn tell(&mut self, event: &Event) {
        let mut written = sse::Event::default().event(event.kind.name());
        if matches!(event.kind, Kind::Generation { .. }) {
            written = written.id(event.id.to_string());
        }
        match written.json_data(event) {
            Ok(written) => self.ready.push_back(written),
            Err(error) => tracing::error!(id = event.id, %error, "an event could not be written"),
        }
    }
}
