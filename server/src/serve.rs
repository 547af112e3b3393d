//! The server: binds, accepts, and shuts down without leaving a robot in motion.

use crate::app::{App, Parts};
use crate::config::Config;
use crate::connection::{self, Times};
use crate::failure;
use crate::feed::Feed;
use crate::fleet::Fleet;
use crate::jobs::{Jobs, Limits, Pool};
use crate::priors::Priors;
use crate::robot::Common;
use crate::router::router;
use crate::store::{Keeper, MemoryStore, SqliteStore, Store};
use crate::training::Environments;
use axum::Router;
use hyper_util::rt::TokioExecutor;
use hyper_util::server::conn::auto::Builder;
use hyper_util::server::graceful::GracefulShutdown;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Connections beyond the limit that are told so at a time; those beyond these are closed without a word.
const REFUSALS: usize = 32;

/// How long a refused connection may take to hear it.
const REFUSAL: Duration = Duration::from_secs(1);

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
        let store: Arc<dyn Store> = match config.data.clone() {
            None => Arc::new(MemoryStore::default()),
            Some(directory) => {
                let opening = tokio::task::spawn_blocking(move || SqliteStore::open(&directory));
                Arc::new(opening.await?.map_err(io::Error::other)?)
            }
        };
        Self::with_store(config, store).await
    }

    /// Binds a server with what `store` keeps, whatever [`Config::data`] says.
    ///
    /// # Errors
    /// Where the address cannot be had or the store cannot be read.
    pub async fn with_store(config: Config, store: Arc<dyn Store>) -> io::Result<Self> {
        config.check().map_err(|why| io::Error::new(io::ErrorKind::InvalidInput, why))?;
        let keeper = Keeper::new(store);
        let contents = keeper.load().await.map_err(io::Error::other)?;
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
        let common = Common { lost_after, feed: feed.clone(), priors: priors.clone() };
        let fleet = Fleet::open(&config, keeper.clone(), common, contents.robots);
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
    /// robot has fetched a stopping horizon or [`Config::drain`] has passed; then connections end in order or after
    /// [`Config::close`].
    ///
    /// # Errors
    /// None so far; a server that cannot go on will say why.
    pub async fn run(self, shutdown: impl Future<Output = ()>) -> io::Result<()> {
        let Self { app, router, listener, .. } = self;
        let door = Door::new(&app.config, router);
        tokio::select! {
            () = door.accept(&listener) => {}
            () = shutdown => {}
        }
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
        // The last they learned; steps that are still answered teach no more than the watchdog lasts.
        if tokio::time::timeout(app.config.close, app.fleet.save()).await.is_err() {
            tracing::warn!(
                "the store does not answer: the last that the robots learned is not kept"
            );
        }
        drop(listener);
        app.closing.send_replace(true);
        if tokio::time::timeout(app.config.close, door.graceful.shutdown()).await.is_err() {
            tracing::warn!("some connections did not end in time");
        }
        let jobs = async { tokio::join!(app.evolutions.closed(), app.comparisons.closed()) };
        if tokio::time::timeout(app.config.close, jobs).await.is_err() {
            tracing::warn!("a job did not stop in time; it goes on from its last checkpoint");
        }
        if tokio::time::timeout(app.config.close, app.keeper.settle()).await.is_err() {
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
    full: Router,
    builder: Arc<Builder<TokioExecutor>>,
    graceful: GracefulShutdown,
    places: Arc<Semaphore>,
    refusals: Arc<Semaphore>,
    times: Times,
}

impl Door {
    fn new(config: &Config, router: Router) -> Self {
        let limit = config.max_connections;
        Self {
            router,
            full: Router::new()
                .fallback(move || async move { failure::limit_reached("connections", limit) }),
            builder: Arc::new(connection::builder()),
            graceful: GracefulShutdown::new(),
            places: Arc::new(Semaphore::new(limit.min(Semaphore::MAX_PERMITS))),
            refusals: Arc::new(Semaphore::new(REFUSALS)),
            times: Times::of(config),
        }
    }

    /// Accepts connections for ever.
    async fn accept(&self, listener: &TcpListener) {
        loop {
            match listener.accept().await {
                Ok((stream, _)) => self.admit(stream),
                Err(error) if is_of_connection(&error) => {}
                Err(error) => {
                    tracing::error!(%error, "no connection can be accepted");
                    tokio::time::sleep(OUT_OF_SOCKETS).await;
                }
            }
        }
    }

    /// Serves the connection, or tells it that there are too many, or closes it.
    fn admit(&self, stream: TcpStream) {
        let serve = |router: &Router, permit: OwnedSemaphorePermit, lifetime: Duration| {
            // Nobody is told that a connection is kept for longer than it is.
            let times = Times { idle: self.times.idle.min(lifetime), ..self.times };
            let connection = connection::serve(
                stream,
                router.clone(),
                Arc::clone(&self.builder),
                self.graceful.watcher(),
                times,
            );
            tokio::spawn(async move {
                // Cut off where it lasts longer.
                let _ = tokio::time::timeout(lifetime, connection).await;
                drop(permit);
            });
        };
        if let Ok(place) = Arc::clone(&self.places).try_acquire_owned() {
            serve(&self.router, place, Duration::MAX);
        } else if let Ok(refusal) = Arc::clone(&self.refusals).try_acquire_owned() {
            serve(&self.full, refusal, REFUSAL);
        }
    }
}

/// Whether an error of `accept` concerns the one connection that was to be accepted.
fn is_of_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}
