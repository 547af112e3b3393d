//! What happens, as server-sent events.

use crate::app::App;
use crate::extract::Known;
use crate::failure::{self, Failure, Result};
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
    headers: HeaderMap,
) -> Result {
    follow(&app, robot.ring(), &headers)
}

pub(crate) async fn of_all(State(app): State<App>, headers: HeaderMap) -> Result {
    follow(&app, app.feed.all(), &headers)
}

fn follow(app: &App, ring: &Arc<Ring>, headers: &HeaderMap) -> Result {
    let after = last_event_id(headers)?;
    let limit = app.config.max_event_streams;
    let permit = Arc::clone(&app.streams).try_acquire_owned();
    let permit = permit.map_err(|_| failure::limit_reached("event streams", limit))?;
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
