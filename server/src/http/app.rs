//! What every route can reach.

use crate::fleet::Fleet;
use crate::fleet::feed::Feed;
use crate::http::budget::{Bodies, Limits, Streams};
use crate::http::documents::Documents;
use crate::jobs::Jobs;
use crate::library::priors::Priors;
use crate::library::training::Environments;
use crate::program::config::Config;
use crate::store::Keeper;
use std::sync::Arc;
use tokio::sync::watch;
use umwelt_core::comparison::Comparison;
use umwelt_core::evolution::Evolution;

/// What every route can reach; cheap to clone.
#[derive(Clone)]
pub(crate) struct App {
    pub(crate) config: Arc<Config>,
    pub(crate) keeper: Keeper,
    pub(crate) fleet: Fleet,
    pub(crate) feed: Feed,
    pub(crate) priors: Priors,
    pub(crate) environments: Environments,
    pub(crate) evolutions: Jobs<Evolution>,
    pub(crate) comparisons: Jobs<Comparison>,
    /// Event streams that may be followed.
    pub(crate) streams: Streams,
    /// Figures, tables and reports that have been made.
    pub(crate) documents: Documents,
    /// Bytes of bodies in flight.
    pub(crate) bodies: Bodies,
    /// Set when event streams are to end, since they would outlast any shutdown.
    pub(crate) closing: Arc<watch::Sender<bool>>,
}

/// What an [`App`] is made of.
pub(crate) struct Parts {
    pub(crate) config: Config,
    pub(crate) keeper: Keeper,
    pub(crate) fleet: Fleet,
    pub(crate) feed: Feed,
    pub(crate) priors: Priors,
    pub(crate) environments: Environments,
    pub(crate) evolutions: Jobs<Evolution>,
    pub(crate) comparisons: Jobs<Comparison>,
}

impl App {
    pub(crate) fn new(parts: Parts) -> Self {
        let Parts { config, keeper, fleet, feed, priors, environments, evolutions, comparisons } =
            parts;
        Self {
            streams: Streams::new(Limits {
                overall: config.max_event_streams,
                per_peer: config.max_event_streams_per_peer,
            }),
            documents: Documents::new(config.keep_documents),
            bodies: Bodies::new(Limits {
                overall: config.max_bodies,
                per_peer: config.max_bodies_per_peer,
            }),
            closing: Arc::default(),
            config: Arc::new(config),
            keeper,
            fleet,
            feed,
            priors,
            environments,
            evolutions,
            comparisons,
        }
    }
}
