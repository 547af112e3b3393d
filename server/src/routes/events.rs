//! What happens, as server-sent events.

use crate::app::App;
use crate::budget::Peer;
use crate::extract::Known;
use crate::failure::{Failure, Result};
use crate::feed::Ring;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::{KeepAlive, Sse};
use axum::response::{IntoResponse, sse};
use futures_util::stream;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use umwelt_api::event::Event;
use umwelt_api::problem::{Detail, Problems, reason};

/// A comment is sent after this long without an event: proxies close what is silent for a minute, and a follower
/// that has gone is only noticed by writing to it.
pub(super) const KEEP_ALIVE: Duration = Duration::from_secs(15);

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
    let (follower, closing) = (ring.follow(after), app.closing.subscribe());
    let events = stream::unfold((follower, closing, permit), |mut state| async move {
        loop {
            let (follower, closing, _) = &mut state;
            let event = tokio::select! {
                event = follower.next() => event?,
                _ = closing.wait_for(|closing| *closing) => return None,
            };
            if let Some(event) = written(&event) {
                return Some((Ok::<_, Infallible>(event), state));
            }
        }
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE)).into_response())
}

/// The event as it is sent; none where it holds a number that cannot be said.
fn written(event: &Event) -> Option<sse::Event> {
    let written = sse::Event::default().id(event.id.to_string()).event(event.kind.name());
    match written.json_data(event) {
        Ok(written) => Some(written),
        Err(error) => {
            tracing::error!(id = event.id, %error, "an event could not be written");
            None
        }
    }
}

pub(super) fn last_event_id(headers: &HeaderMap) -> Result<Option<u64>, Failure> {
    let Some(value) = headers.get("last-event-id") else { return Ok(None) };
    let text = value.to_str().unwrap_or_default();
    let id = text.parse().map_err(|_| {
        let remedy = "send the id of an event, or leave it out";
        Problems::from(Detail::new(reason::MALFORMED, "Last-Event-ID", text, remedy))
    })?;
    Ok(Some(id))
}
