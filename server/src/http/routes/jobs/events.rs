//! What happens to a job, as server-sent events.
//!
//! Invariants: nothing is sent that is not kept; no state counts anything that was not sent before it, and the state in
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
use umwelt_api::job::{JobEvent, JobNews};

/// How often the state is sent while nothing but time passes.
const TICK: Duration = Duration::from_secs(2);

pub(crate) async fn events<W: Resource>(
    State(app): State<App>,
    Named(job): Named<W>,
    peer: Peer,
    headers: HeaderMap,
) -> Result {
    let last = last_event_id(&headers)?.unwrap_or(0);
    let permit = app.streams.follow(peer)?;
    let follower = Follower {
        shown: job.follow(),
        closing: app.closing.subscribe(),
        app,
        job,
        last,
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

/// One stream of a job.
struct Follower<W: Resource> {
    app: App,
    job: Arc<Job<W>>,
    shown: watch::Receiver<Shown<W>>,
    closing: watch::Receiver<bool>,
    /// Id of the last event that was sent, beside states.
    last: u64,
    ready: VecDeque<sse::Event>,
    /// Whether the state is to be sent once the events before it are.
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
            // None where they cannot be had: the client will ask again for them.
            let before = W::events_after(&self.app, &self.job, &shown, self.last).await?;
            if !before.is_empty() {
                for event in before {
                    self.last = event.id;
                    self.send(&event, true);
                }
                self.is_state_due = true;
            } else if self.is_state_due {
                self.is_state_due = false;
                self.is_over = shown.has_ended() || shown.removed;
                self.send(&self.job.event(&shown), W::STATES_HAVE_IDS);
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
    fn send(&mut self, event: &JobEvent<W::Kind>, has_id: bool) {
        let mut written = sse::Event::default().event(event.kind.name());
        if has_id {
            written = written.id(event.id.to_string());
        }
        match written.json_data(event) {
            Ok(event) => self.ready.push_back(event),
            Err(error) => {
                let (job, kind) = (self.job.id(), W::KIND.name());
                tracing::error!(%job, kind, %error, "cannot write job event");
            }
        }
    }
}
