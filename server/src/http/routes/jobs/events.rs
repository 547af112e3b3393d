//! What happens to a job, as server-sent events.
//!
//! Invariants: nothing is told that is not kept; no state counts anything that was not told before it, and the state in
//! which the job has ended is the last event; the id of an event is the same after a restart, so a stream resumes where
//! it was.

use super::named::Named;
use super::resource::Resource;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::budget::{Peer, Stream};
use crate::http::routes::events::{KEEP_ALIVE, last_event_id};
use crate::jobs::{Job, Shown};
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::IntoResponse;
use axum::response::sse::{self, KeepAlive, Sse};
use futures_util::stream;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// How often the state is told while nothing but time passes.
const TICK: Duration = Duration::from_secs(2);

pub(crate) async fn events<W: Resource>(
    State(app): State<App>,
    Named(job): Named<W>,
    peer: Peer,
    headers: HeaderMap,
) -> Result {
    let told = last_event_id(&headers)?.unwrap_or(0);
    let permit = app.streams.follow(peer)?;
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

/// Somebody who follows a job.
struct Follower<W: Resource> {
    app: App,
    job: Arc<Job<W>>,
    shown: watch::Receiver<Shown<W>>,
    closing: watch::Receiver<bool>,
    /// What has been told, beside states.
    told: u64,
    ready: VecDeque<sse::Event>,
    /// Whether the state is to be told once the news are.
    is_state_due: bool,
    is_over: bool,
    _permit: Stream,
}

impl<W: Resource> Follower<W> {
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
            // None where they cannot be had: the follower will ask again for them.
            let news = W::news(&self.app, &self.job, &shown, self.told).await?;
            if !news.is_empty() {
                for (told, event) in news {
                    self.told = told;
                    self.tell(event);
                }
                self.is_state_due = true;
            } else if self.is_state_due {
                self.is_state_due = false;
                self.is_over = shown.has_ended() || shown.removed;
                self.tell(W::event(&self.job, &shown));
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

    /// Makes an event ready.
    fn tell(&mut self, event: Result<sse::Event, axum::Error>) {
        match event {
            Ok(event) => self.ready.push_back(event),
            Err(error) => {
                tracing::error!(job = %self.job.id(), %error, "an event could not be written");
            }
        }
    }
}
