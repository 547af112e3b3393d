//! Connections: what `axum::serve` has no knob for.
//!
//! A connection must bring its first request, and each request its header, within a time limit; between requests it may
//! be silent for longer, and answers say for how long; HTTP/2 is spoken to whoever begins with it, and pinged, so that
//! half-open connections are noticed; small replies leave at once. What a peer may have of all this is counted in
//! `budget` and `frames`.

mod header_timeout;

use crate::http::budget::Place;
use crate::http::frames::Metered;
use axum::Router;
use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Request, Version, header};
use header_timeout::{Activity, Limits, Timed};
use http_body_util::BodyExt;
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use hyper_util::server::conn::auto::Builder;
use hyper_util::server::graceful::Watcher;
use hyper_util::service::TowerToHyperService;
use socket2::{SockRef, TcpKeepalive};
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::net::TcpStream;
use tower::{ServiceExt, service_fn};

/// Largest header of a request: ids are short, and there is little else.
const MAX_HEADER: usize = 16 * 1024;

/// What a peer may send on one stream, and on all streams of a connection, before someone reads it: it lies in memory
/// that no budget counts. A step has some 2 kB.
const STREAM_WINDOW: u32 = 64 * 1024;
const CONNECTION_WINDOW: u32 = 128 * 1024;

/// What may wait on one stream to be sent; a horizon of forty slots has 3 kB.
const SEND_BUFFER: usize = 64 * 1024;

/// Streams that a peer has reset before they were looked at; the connection ends beyond them.
const MAX_PENDING_RESETS: usize = 20;

/// A silent HTTP/2 connection is pinged after this long, and closed after as long again without an answer.
/// Together above the 12 s for which Wi-Fi to a moving robot has been seen to stall.
const PING: Duration = Duration::from_secs(10);

/// Data that is not acknowledged for this long ends the connection, whatever the protocol: an event stream whose
/// follower has gone is noticed, and a follower that stops reading.
const UNACKNOWLEDGED: Duration = Duration::from_secs(30);

/// How much longer a silent connection is kept than its peer was told: what was sent in the last moment arrives.
const GRACE: Duration = Duration::from_secs(2);

const KEEP_ALIVE: HeaderName = HeaderName::from_static("keep-alive");

/// How long a connection may take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times {
    /// To bring its first request, and for each header.
    pub(crate) first_request: Duration,
    /// Until its next request, where it is HTTP/1.1.
    pub(crate) idle: Duration,
}

/// The protocols and their limits, of which `max_streams` is one: requests in flight on a connection of HTTP/2.
pub(crate) fn builder(max_streams: u32) -> Builder<TokioExecutor> {
    let mut builder = Builder::new(TokioExecutor::new());
    builder
        .http1()
        .timer(TokioTimer::new())
        // `header_timeout` tells silence from a header that is late.
        .header_read_timeout(None)
        .max_buf_size(4 * MAX_HEADER);
    builder
        .http2()
        .timer(TokioTimer::new())
        .max_concurrent_streams(max_streams)
        .initial_stream_window_size(STREAM_WINDOW)
        .initial_connection_window_size(CONNECTION_WINDOW)
        .max_send_buf_size(SEND_BUFFER)
        .max_pending_accept_reset_streams(MAX_PENDING_RESETS)
        .max_header_list_size(MAX_HEADER as u32)
        .keep_alive_interval(PING)
        .keep_alive_timeout(PING);
    builder
}

/// Serves one connection to its end, until it has to give its place to another, or to the end of the server.
pub(crate) async fn serve(
    stream: TcpStream,
    place: &Place,
    router: Router,
    builder: Arc<Builder<TokioExecutor>>,
    watcher: Watcher,
    times: Times,
    control_frames_per_s: u32,
) {
    if let Err(error) = prepare(&stream) {
        tracing::debug!(%error, "a connection was gone before it began");
        return;
    }
    let has_begun = Arc::new(AtomicBool::new(false));
    let begun = Arc::clone(&has_begun);
    let activity = Arc::new(Activity::default());
    let limits = Limits { idle: times.idle + GRACE, header: times.first_request };
    let stream = Timed::new(stream, Arc::clone(&activity), limits);
    let keep_alive = keep_alive(times.idle);
    let (peer, place_activity) = (place.peer(), Arc::clone(place.activity()));
    let service = service_fn(move |request: Request<_>| {
        begun.store(true, Ordering::Relaxed);
        let answering = activity.begin(request.version() == Version::HTTP_2);
        let tracked = place_activity.tracked();
        let keep_alive = keep_alive.clone().filter(|_| is_kept(&request));
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(peer);
        let answer = router.clone().oneshot(request);
        async move {
            let mut response = answer.await?;
            if let Some(keep_alive) = keep_alive {
                response.headers_mut().insert(KEEP_ALIVE, keep_alive);
            }
            // The answer lasts as long as its body, which takes this along.
            Ok::<_, Infallible>(response.map(|body| {
                tracked(body.map_err(move |error| {
                    let _of_body = &answering;
                    error
                }))
            }))
        }
    });
    let stream = TokioIo::new(Metered::new(stream, control_frames_per_s));
    let connection =
        builder.serve_connection(stream, TowerToHyperService::new(service)).into_owned();
    tokio::select! {
        result = watcher.watch(connection) => {
            if let Err(error) = result {
                tracing::debug!(error = %error, "a connection ended badly");
            }
        }
        () = never_began(&has_begun, times.first_request) => {
            tracing::debug!("a connection brought no request");
        }
        () = place.evicted() => {
            tracing::debug!("an idle connection gave way to another one");
        }
    }
}

/// What tells the peer of HTTP/1.1 how long the connection is kept; none where it is kept for less than a second.
fn keep_alive(idle: Duration) -> Option<HeaderValue> {
    let seconds = idle.as_secs();
    let value = HeaderValue::try_from(format!("timeout={seconds}")).ok();
    value.filter(|_| seconds > 0)
}

/// Whether the connection of HTTP/1.1 is kept after this request.
fn is_kept<B>(request: &Request<B>) -> bool {
    request.version() == Version::HTTP_11 && !asks_to_close(request.headers())
}

fn asks_to_close(headers: &HeaderMap) -> bool {
    let said = headers.get_all(header::CONNECTION).iter().filter_map(|value| value.to_str().ok());
    said.flat_map(|text| text.split(',')).any(|word| word.trim().eq_ignore_ascii_case("close"))
}

/// Returns after `limit` where no request has come by then. hyper's own limit begins with the first bytes of
/// HTTP/1.1: it knows nothing of a peer that sends none, or half a preface of HTTP/2.
async fn never_began(has_begun: &AtomicBool, limit: Duration) {
    tokio::time::sleep(limit).await;
    if has_begun.load(Ordering::Relaxed) {
        std::future::pending().await
    }
}

fn prepare(stream: &TcpStream) -> std::io::Result<()> {
    // A horizon is one small packet: it must not wait for the next one (Nagle).
    stream.set_nodelay(true)?;
    let socket = SockRef::from(stream);
    socket.set_tcp_keepalive(&TcpKeepalive::new().with_time(UNACKNOWLEDGED))?;
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(UNACKNOWLEDGED))?;
    Ok(())
}
