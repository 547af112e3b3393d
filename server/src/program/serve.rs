//! The server: put together, bound, and shut down without leaving a robot in motion.

use crate::fleet::feed::Feed;
use crate::fleet::robot::{Common, Workers};
use crate::fleet::{Fleet, Stops};
use crate::http::acceptor::{self, Acceptor};
use crate::http::app::App;
use crate::http::budget::{self, Bodies, Limits as Budget, Streams};
use crate::http::connection::Times;
use crate::http::deadline::Deadlines;
use crate::http::documents::Documents;
use crate::http::guard::Rules;
use crate::http::router::router;
use crate::jobs::{Jobs, Limits};
use crate::library::priors::Priors;
use crate::library::training::Environments;
use crate::program::config::Config;
use crate::program::memory;
use crate::store::{
    Keeper, MemoryStore, SqliteStore, StopKeeper, Store, Unreadables, stop_journal,
};
use axum::Router;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::time::{Instant, timeout_at};
use umwelt_lab::pool::Pool;

/// A server that is bound to its address.
pub struct Server {
    config: Config,
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
        budget::allow_files(config.max_connections.saturating_add(config.reserved_connections));
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
        let unreadable = Unreadables::default();
        contents.unreadable.iter().for_each(|it| unreadable.add(it.clone()));
        let priors = Priors::open(contents.priors.clone(), unreadable.clone());
        let environments = Environments::open(&contents.environments, &unreadable);
        let limits = Limits { queued: config.max_queued_evolutions, kept: config.keep_evolutions };
        let evolutions = Jobs::open(
            limits,
            pool.clone(),
            keeper.clone(),
            priors.clone(),
            &contents,
            &unreadable,
        )
        .await?;
        let limits =
            Limits { queued: config.max_queued_comparisons, kept: config.keep_comparisons };
        let comparisons =
            Jobs::open(limits, pool, keeper.clone(), (), &contents, &unreadable).await?;
        let lost_after = config.lost_after;
        let workers = Workers::start()?;
        let common = Common { lost_after, feed: feed.clone(), priors: priors.clone(), workers };
        let (max_robots, save_every) = (config.max_robots, config.save_every);
        let robots = contents.robots;
        let fleet = Fleet::open(
            max_robots,
            save_every,
            keeper.clone(),
            common,
            robots,
            stops,
            unreadable.clone(),
        );
        let app = App {
            keeper,
            fleet,
            feed,
            priors,
            environments,
            evolutions,
            comparisons,
            unreadable,
            streams: Streams::new(Budget {
                overall: config.max_event_streams,
                per_peer: config.max_event_streams_per_peer,
            }),
            documents: Documents::new(config.keep_documents),
            bodies: Bodies::new(Budget {
                overall: config.max_bodies,
                per_peer: config.max_bodies_per_peer,
            }),
            body_timeout: config.body_timeout,
            deadlines: Deadlines { usual: config.deadline, longest: config.max_deadline },
            closing: Arc::default(),
        };
        let router = router(app.clone(), rules(&config));
        Ok(Self { config, app, router, listener, address })
    }

    /// Where it listens, the port filled in.
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// Its routes, to be called in the same process without a connection.
    pub fn router(&self) -> Router {
        self.router.clone()
    }

    /// What its routes can reach.
    #[cfg(test)]
    pub(crate) fn app(&self) -> App {
        self.app.clone()
    }

    /// Serves until `shutdown`, then drains: robots are told to rest and steps still answered until every connected
    /// robot has fetched a stopping horizon or [`Config::drain`] has passed; then connections, jobs and store end in
    /// order or after [`Config::close`] together.
    ///
    /// # Errors
    /// None so far; a server that cannot go on will say why.
    pub async fn run(self, shutdown: impl Future<Output = ()>) -> io::Result<()> {
        let Self { config, app, router, listener, .. } = self;
        let acceptor = Acceptor::new(connections(&config), router);
        let tidying = tokio::spawn(memory::give_back_what_is_free());
        tokio::select! {
            () = acceptor.accept(&listener) => {}
            () = shutdown => {}
        }
        tidying.abort();
        tracing::info!("server shuts down: robots are told to rest");
        // What runs goes on after the restart; the robots that are told to rest need the cores now.
        app.evolutions.close();
        app.comparisons.close();
        tokio::select! {
            () = acceptor.accept(&listener) => {}
            drained = tokio::time::timeout(config.drain, app.fleet.drain()) => {
                if drained.is_err() {
                    tracing::warn!("not every robot has fetched a stopping horizon; they stop by themselves");
                }
            }
        }
        // One limit for all that is left, so that the whole takes no longer than it says.
        let end = Instant::now() + config.close;
        // The last they learned; steps that are still answered teach no more than the watchdog lasts.
        let saving = async { tokio::join!(app.fleet.save(), app.fleet.catch_up()) };
        if timeout_at(end - config.close / 2, saving).await.is_err() {
            tracing::warn!(
                "the store does not answer: the last that the robots learned is not kept"
            );
        }
        drop(listener);
        app.closing.send_replace(true);
        if timeout_at(end, acceptor.close()).await.is_err() {
            tracing::warn!("connections did not end in time");
        }
        let jobs = async { tokio::join!(app.evolutions.closed(), app.comparisons.closed()) };
        if timeout_at(end, jobs).await.is_err() {
            tracing::warn!("job did not stop in time; it goes on from its last checkpoint");
        }
        if timeout_at(end, app.keeper.settle()).await.is_err() {
            tracing::warn!("store does not answer; what it has acknowledged is kept");
        }
        Ok(())
    }
}

/// Whom the guard lets through.
fn rules(config: &Config) -> Rules {
    Rules {
        listen: config.listen.ip(),
        hosts: config.allow_hosts.clone(),
        origins: config.cors_origins.clone(),
        token: config.token.clone(),
    }
}

/// What is set about connections.
fn connections(config: &Config) -> acceptor::Settings {
    acceptor::Settings {
        connections: Budget {
            overall: config.max_connections,
            per_peer: config.max_connections_per_peer,
        },
        reserved: config.reserved_connections,
        times: Times { first_request: config.header_timeout, idle: config.idle_timeout },
        max_streams: config.max_streams_per_connection,
        control_frames_per_s: config.max_control_frames_per_s,
        deadline: config.deadline,
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
