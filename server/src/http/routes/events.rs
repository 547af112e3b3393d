//! What happens, as server-sent events.

use crate::fleet::feed::{BATCH, Entry, Follower, Ring};
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::budget::{Peer, Stream};
use crate::http::extract::Known;
use crate::resource::failure::Failure;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::IntoResponse;
use bytes::{Bytes, BytesMut};
use futures_util::stream;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;
use umwelt_api::problem::{Detail, Problems, reason};

/// A comment is sent after this long without an event: proxies close what is silent for a minute, and a follower
/// that has gone is only noticed by writing to it.
pub(super) const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// The comment: it is no event.
const COMMENT: Bytes = Bytes::from_static(b":\n\n");

/// What happens within this time after events were sent is sent together: no one sees so short a delay, and many
/// followers of many robots do not wake up for each event.
const PACE: Duration = Duration::from_millis(20);

pub(crate) async fn of_robot(
    State(app): State<App>,
    Known(robot): Known,
    peer: Peer,
    headers: HeaderMap,
) -> Result {
    follow(&app, robot.ring(), peer, &headers)
}

pub(crate) async fn of_all(State(app): State<App>, peer: Peer, headers: HeaderMap) -> Result {
    follow(&app, app.feed.all(), peer, &headers)
}

fn follow(app: &App, ring: &Arc<Ring>, peer: Peer, headers: &HeaderMap) -> Result {
    let after = last_event_id(headers)?;
    let permit = app.streams.follow(peer)?;
    let reader = Reader {
        follower: ring.follow(after),
        closing: app.closing.subscribe(),
        not_before: Instant::now(),
        _permit: permit,
    };
    let chunks = stream::unfold(reader, |mut reader| async move {
        let chunk = reader.next().await?;
        Some((Ok::<_, Infallible>(chunk), reader))
    });
    let headers =
        [(header::CONTENT_TYPE, "text/event-stream"), (header::CACHE_CONTROL, "no-cache")];
    Ok((headers, Body::from_stream(chunks)).into_response())
}

/// One stream of events on its way out.
struct Reader {
    follower: Follower,
    closing: watch::Receiver<bool>,
    /// When the next events are to be sent.
    not_before: Instant,
    _permit: Stream,
}

impl Reader {
    /// What is to be sent next, as soon as it is; none at the end.
    async fn next(&mut self) -> Option<Bytes> {
        let (follower, not_before) = (&mut self.follower, self.not_before);
        let events = async {
            if not_before > Instant::now() {
                tokio::time::sleep_until(not_before).await;
            }
            loop {
                let events = follower.next().await?;
                let chunk = joined(&events);
                if !chunk.is_empty() {
                    return Some((chunk, events.len()));
                }
            }
        };
        tokio::select! {
            events = tokio::time::timeout(KEEP_ALIVE, events) => match events {
                Ok(events) => {
                    let (chunk, count) = events?;
                    // Behind as many as it could take there may be more.
                    let pause = if count < BATCH { PACE } else { Duration::ZERO };
                    self.not_before = Instant::now() + pause;
                    Some(chunk)
                }
                Err(_) => Some(COMMENT),
            },
            _ = self.closing.wait_for(|closing| *closing) => None,
        }
    }
}

/// Events one after the other.
fn joined(events: &[Arc<Entry>]) -> Bytes {
    match events {
        [event] => event.written().clone(),
        events => {
            let mut joined = BytesMut::new();
            events.iter().for_each(|event| joined.extend_from_slice(event.written()));
            joined.freeze()
        }
    }
}

pub(super) fn last_event_id(headers: &HeaderMap) -> Result<Option<u64>, Failure> {
    let Some(value) = headers.get("last-event-id") else { return Ok(None) };
    let text = value.to_str().unwrap_or_default();
    // A browser that has received none yet may say so.
    if value.is_empty() {
        return Ok(None);
    }
    let id = text.parse().map_err(|_| {
        let remedy = "send the id of an event, or leave it out";
        Problems::from(Detail::new(reason::MALFORMED, "Last-Event-ID", text, remedy))
    })?;
    Ok(Some(id))
}
