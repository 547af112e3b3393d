//! What every route can reach.

use crate::budget::{Bodies, Limits, Streams};
use crate::config::Config;
use crate::documents::Documents;
use crate::feed::Feed;
use crate::fleet::Fleet;
use crate::jobs::Jobs;
use crate::priors::Priors;
use crate::store::{Keeper, Unreadables};
use crate::training::Environments;
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
    /// What is kept and cannot be read.
    pub(crate) unreadable: Unreadables,
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
    /// What is kept and cannot be read.
    pub(crate) unreadable: Unreadables,
}

impl App {
    pub(crate) fn new(parts: Parts) -> Self {
        let Parts {
            config,
            keeper,
            fleet,
            feed,
            priors,
            environments,
            evolutions,
            comparisons,
            unreadable,
        } = parts;
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
            unreadable,
        }
    }
}
