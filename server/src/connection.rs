//! Connections: what `axum::serve` has no knob for.
//!
//! A connection must bring its first request, and each request its header, within a time limit; HTTP/2 is spoken to
//! whoever begins with it, and pinged, so that half-open connections are noticed; small replies leave at once. What a peer
//! may have of all this is counted in `budget` and `frames`.

use crate::budget::Place;
use crate::config::Config;
use crate::frames::Metered;
use axum::Router;
use axum::body::Body;
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use hyper_util::server::conn::auto::Builder;
use hyper_util::server::graceful::Watcher;
use hyper_util::service::TowerToHyperService;
use socket2::{SockRef, TcpKeepalive};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::net::TcpStream;
use tower::ServiceExt;

/// Largest header of a request: ids are short, and there is little else.
const MAX_HEADER: usize = 16 * 1024;

/// What a peer may send on one stream, and on all streams of a connection, before somebody reads it: it lies in memory
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

/// The protocols and their limits.
pub(crate) fn builder(config: &Config) -> Builder<TokioExecutor> {
    let mut builder = Builder::new(TokioExecutor::new());
    builder
        .http1()
        .timer(TokioTimer::new())
        .header_read_timeout(config.header_timeout)
        .max_buf_size(4 * MAX_HEADER);
    builder
        .http2()
        .timer(TokioTimer::new())
        .max_concurrent_streams(config.max_streams_per_connection)
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
    first_request: Duration,
    control_frames_per_s: u32,
) {
    if let Err(error) = prepare(&stream) {
        tracing::debug!(%error, "a connection was gone before it began");
        return;
    }
    let has_begun = Arc::new(AtomicBool::new(false));
    let begun = Arc::clone(&has_begun);
    let (peer, activity) = (place.peer(), Arc::clone(place.activity()));
    let service = tower::service_fn(move |request: axum::http::Request<_>| {
        begun.store(true, Ordering::Relaxed);
        let tracked = activity.tracked();
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(peer);
        let answer = router.clone().oneshot(request);
        async move { answer.await.map(|response| response.map(tracked)) }
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
        () = never_began(&has_begun, first_request) => {
            tracing::debug!("a connection brought no request");
        }
        () = place.evicted() => {
            tracing::debug!("an idle connection gave way to another one");
        }
    }
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
