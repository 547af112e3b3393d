//! Where connections come in: each served in its place, beyond the limits in one that is reserved, or closed.

use crate::http::budget::{self, Connections, Limits, Peer, Place};
use crate::http::connection::{self, Times};
use axum::Router;
use hyper_util::rt::TokioExecutor;
use hyper_util::server::conn::auto::Builder;
use hyper_util::server::graceful::GracefulShutdown;
use std::io;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};

/// Beyond the limit the longest idle connection gives way to a new one, if it has been idle for this long: an agent sends
/// a request every 30 ms.
const IDLE: Duration = Duration::from_secs(1);

/// The part of the reserved connections that one peer may have.
const RESERVED_SHARE: usize = 4;

/// How much longer than an answer may take a reserved connection lives.
const RESERVED_MARGIN: Duration = Duration::from_secs(1);

/// Pause after the system had no more connections to give: it will not have one at once.
const OUT_OF_SOCKETS: Duration = Duration::from_millis(100);

/// What is set about connections.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// How many there may be.
    pub(crate) connections: Limits,
    /// How many beyond them for a stop and health.
    pub(crate) reserved: usize,
    pub(crate) times: Times,
    /// Requests in flight on one of HTTP/2.
    pub(crate) max_streams: u32,
    /// HTTP/2 frames without content that one may send.
    pub(crate) control_frames_per_s: u32,
    /// How long an answer may take where the request does not say.
    pub(crate) deadline: Duration,
}

/// Lets connections in.
pub(crate) struct Acceptor {
    router: Router,
    reserved_router: Router,
    builder: Arc<Builder<TokioExecutor>>,
    graceful: GracefulShutdown,
    connections: Connections,
    reserved: Connections,
    reserved_lifetime: Duration,
    times: Times,
    control_frames_per_s: u32,
}

impl Acceptor {
    pub(crate) fn new(settings: Settings, router: Router) -> Self {
        let Settings { connections, reserved, max_streams, control_frames_per_s, .. } = settings;
        let reserve = Limits { overall: reserved, per_peer: reserved.div_ceil(RESERVED_SHARE) };
        Self {
            reserved_router: budget::reserved(router.clone(), connections.overall),
            router,
            builder: Arc::new(connection::builder(max_streams)),
            graceful: GracefulShutdown::new(),
            connections: Connections::new(connections, IDLE),
            reserved: Connections::new(reserve, Duration::ZERO),
            reserved_lifetime: settings.deadline + RESERVED_MARGIN,
            times: settings.times,
            control_frames_per_s,
        }
    }

    /// Accepts connections for ever.
    pub(crate) async fn accept(&self, listener: &TcpListener) {
        loop {
            match listener.accept().await {
                Ok((stream, address)) => self.admit(stream, Peer::of(address.ip())),
                Err(error) if is_of_connection(&error) => {}
                Err(error) => {
                    tracing::error!(%error, "cannot accept connections");
                    tokio::time::sleep(OUT_OF_SOCKETS).await;
                }
            }
        }
    }

    /// Returns once every connection has ended.
    pub(crate) async fn close(self) {
        self.graceful.shutdown().await;
    }

    /// Serves the connection; beyond the limits what places are reserved for, and beyond those nothing: it is closed
    /// without a word.
    fn admit(&self, stream: TcpStream, peer: Peer) {
        if let Some(place) = self.connections.admit(peer) {
            self.serve(stream, place, &self.router, Duration::MAX);
        } else if let Some(place) = self.reserved.admit(peer) {
            self.serve(stream, place, &self.reserved_router, self.reserved_lifetime);
        }
    }

    fn serve(&self, stream: TcpStream, place: Place, router: &Router, lifetime: Duration) {
        let (router, builder) = (router.clone(), Arc::clone(&self.builder));
        // No one is told that a connection is kept for longer than it is.
        let times = Times { idle: self.times.idle.min(lifetime), ..self.times };
        let watcher = self.graceful.watcher();
        let frames = self.control_frames_per_s;
        tokio::spawn(async move {
            let connection =
                connection::serve(stream, &place, router, builder, watcher, times, frames);
            // Cut off where it lasts longer.
            let _ = tokio::time::timeout(lifetime, connection).await;
        });
    }
}

/// Whether an error of `accept` concerns the one connection that was to be accepted.
fn is_of_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}
