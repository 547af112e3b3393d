//! The server: binds, accepts, and shuts down without leaving a robot in motion.

use crate::fleet::feed::Feed;
use crate::fleet::robot::{Common, Workers};
use crate::fleet::{Fleet, Stops};
use crate::http::app::{App, Parts};
use crate::http::budget::{self, Connections, Limits as Budget, Peer, Place};
use crate::http::connection::{self, Times};
use crate::http::router::router;
use crate::jobs::{Jobs, Limits, Pool};
use crate::library::priors::Priors;
use crate::library::training::Environments;
use crate::program::config::Config;
use crate::program::memory;
use crate::store::{Keeper, MemoryStore, SqliteStore, StopKeeper, Store, stop_journal};
use axum::Router;
use hyper_util::rt::TokioExecutor;
use hyper_util::server::conn::auto::Builder;
use hyper_util::server::graceful::GracefulShutdown;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, timeout_at};

/// Beyond the limit the longest idle connection gives way to a new one, if it has been idle for this long: an agent sends
/// a request every 30 ms.
const IDLE: Duration = Duration::from_secs(1);

/// The part of the reserved connections that one peer may have.
const RESERVED_SHARE: usize = 4;

/// How much longer than an answer may take a reserved connection lives.
const RESERVED_MARGIN: Duration = Duration::from_secs(1);

/// Pause after the system had no more connections to give: it will not have one at once.
const OUT_OF_SOCKETS: Duration = Duration::from_millis(100);

/// A server that is bound to its address.
pub struct Server {
    app: App,
    router: Router,
    listener: TcpListener,
    address: SocketAddr,
}

impl Server {
    /// Binds a server with what its data directory holds, [`Config::data`], or in memory where there is none.
    ///
    /// # Errors
    /// Where the address cannot be had, or is not of this machine alone and there is neither a token nor leave to do
    /// without, or the data directory cannot be used; the message says what to do.
    pub async fn bind(config: Config) -> io::Result<Self> {
        let Some(directory) = config.data.clone() else {
            return Self::with_store(config, Arc::new(MemoryStore::default())).await;
        };
        let opening = tokio::task::spawn_blocking(move || {
            let store = SqliteStore::open(&directory).map_err(io::Error::other)?;
            // The directory is ours now.
            let (journal, words) = stop_journal(&directory)?;
            Ok::<_, io::Error>((store, journal, words))
        });
        let (store, journal, words) = opening.await??;
        let journal = journal.map(StopKeeper::start).transpose()?;
        Self::with(config, Arc::new(store), Stops { journal, words }).await
    }

    /// Binds a server with what `store` keeps, whatever [`Config::data`] says.
    ///
    /// # Errors
    /// Where the address cannot be had or the store cannot be read.
    pub async fn with_store(config: Config, store: Arc<dyn Store>) -> io::Result<Self> {
        Self::with(config, store, Stops::default()).await
    }

    async fn with(config: Config, store: Arc<dyn Store>, stops: Stops) -> io::Result<Self> {
        config.check().map_err(|why| io::Error::new(io::ErrorKind::InvalidInput, why))?;
        budget::allow_files(&config);
        let keeper = Keeper::new(store);
        let contents = keeper.load().await.map_err(io::Error::other)?;
        // A full disk is no reason not to serve, and one to say so at once.
        keeper.probe(Duration::ZERO).await;
        let listener = TcpListener::bind(config.listen).await.map_err(|error| {
            let message = format!("cannot listen on {}: {error}", config.listen);
            io::Error::new(error.kind(), message)
        })?;
        let address = listener.local_addr()?;
        warn_of_exposure(&config, address);
        let feed = Feed::new();
        let pool = Arc::new(Pool::new(config.evolution_threads, config.evolution_priority)?);
        let priors = Priors::open(contents.priors.clone());
        let environments = Environments::open(&contents.environments);
        let limits = Limits { queued: config.max_queued_evolutions, kept: config.keep_evolutions };
        let evolutions =
            Jobs::open(limits, pool.clone(), keeper.clone(), priors.clone(), &contents).await?;
        let limits =
            Limits { queued: config.max_queued_comparisons, kept: config.keep_comparisons };
        let comparisons = Jobs::open(limits, pool, keeper.clone(), (), &contents).await?;
        let lost_after = config.lost_after;
        let workers = Workers::start()?;
        let common = Common { lost_after, feed: feed.clone(), priors: priors.clone(), workers };
        let fleet = Fleet::open(&config, keeper.clone(), common, contents.robots, stops);
        let parts =
            Parts { config, keeper, fleet, feed, priors, environments, evolutions, comparisons };
        let app = App::new(parts);
        Ok(Self { router: router(app.clone()), app, listener, address })
    }

    /// Where it listens, the port filled in.
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// Its routes, to be called in the same process without a connection.
    pub fn router(&self) -> Router {
        self.router.clone()
    }

    /// Serves until `shutdown`, then drains: robots are told to rest and steps still answered until every connected
    /// robot has fetched a stopping horizon or [`Config::drain`] has passed; then connections, jobs and store end in
    /// order or after [`Config::close`] together.
    ///
    /// # Errors
    /// None so far; a server that cannot go on will say why.
    pub async fn run(self, shutdown: impl Future<Output = ()>) -> io::Result<()> {
        let Self { app, router, listener, .. } = self;
        let door = Door::new(&app.config, router);
        let tidying = tokio::spawn(memory::give_back_what_is_free());
        tokio::select! {
            () = door.accept(&listener) => {}
            () = shutdown => {}
        }
        tidying.abort();
        tracing::info!("shutting down: robots are told to rest");
        // What runs goes on after the restart; the robots that are told to rest need the cores now.
        app.evolutions.close();
        app.comparisons.close();
        tokio::select! {
            () = door.accept(&listener) => {}
            drained = tokio::time::timeout(app.config.drain, app.fleet.drain()) => {
                if drained.is_err() {
                    tracing::warn!("not every robot has fetched a stopping horizon; they stop by themselves");
                }
            }
        }
        // One limit for all that is left, so that the whole takes no longer than it says.
        let end = Instant::now() + app.config.close;
        // The last they learned; steps that are still answered teach no more than the watchdog lasts.
        let saving = async { tokio::join!(app.fleet.save(), app.fleet.catch_up()) };
        if timeout_at(end - app.config.close / 2, saving).await.is_err() {
            tracing::warn!(
                "the store does not answer: the last that the robots learned is not kept"
            );
        }
        drop(listener);
        app.closing.send_replace(true);
        if timeout_at(end, door.graceful.shutdown()).await.is_err() {
            tracing::warn!("some connections did not end in time");
        }
        let jobs = async { tokio::join!(app.evolutions.closed(), app.comparisons.closed()) };
        if timeout_at(end, jobs).await.is_err() {
            tracing::warn!("a job did not stop in time; it goes on from its last checkpoint");
        }
        if timeout_at(end, app.keeper.settle()).await.is_err() {
            tracing::warn!("the store does not answer; what it has acknowledged is kept");
        }
        Ok(())
    }
}

/// Says in the log what the address to listen on exposes.
fn warn_of_exposure(config: &Config, listen: SocketAddr) {
    if config.is_local() {
        return;
    }
    if config.token.is_some() {
        tracing::warn!(
            %listen,
            "the token and all else cross the network in the clear: put a proxy with TLS or a tunnel in front"
        );
    } else {
        tracing::warn!(
            %listen,
            "insecure, as --allow-insecure says: everybody who reaches this address can drive every robot"
        );
    }
}

/// Lets connections in.
struct Door {
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

impl Door {
    fn new(config: &Config, router: Router) -> Self {
        let (overall, reserved) = (config.max_connections, config.reserved_connections);
        let limits = Budget { overall, per_peer: config.max_connections_per_peer };
        let reserve = Budget { overall: reserved, per_peer: reserved.div_ceil(RESERVED_SHARE) };
        Self {
            reserved_router: budget::reserved(router.clone(), overall),
            router,
            builder: Arc::new(connection::builder(config)),
            graceful: GracefulShutdown::new(),
            connections: Connections::new(limits, IDLE),
            reserved: Connections::new(reserve, Duration::ZERO),
            reserved_lifetime: config.deadline + RESERVED_MARGIN,
            times: Times::of(config),
            control_frames_per_s: config.max_control_frames_per_s,
        }
    }

    /// Accepts connections for ever.
    async fn accept(&self, listener: &TcpListener) {
        loop {
            match listener.accept().await {
                Ok((stream, address)) => self.admit(stream, Peer::of(address.ip())),
                Err(error) if is_of_connection(&error) => {}
                Err(error) => {
                    tracing::error!(%error, "no connection can be accepted");
                    tokio::time::sleep(OUT_OF_SOCKETS).await;
                }
            }
        }
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
        // Nobody is told that a connection is kept for longer than it is.
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
