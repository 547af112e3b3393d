//! What every route can reach.

use crate::fleet::Fleet;
use crate::fleet::feed::Feed;
use crate::http::budget::{Bodies, Streams};
use crate::http::deadline::Deadlines;
use crate::http::documents::Documents;
use crate::jobs::Jobs;
use crate::library::priors::Priors;
use crate::library::training::Environments;
use crate::store::{Keeper, Unreadables};
use axum::extract::FromRef;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use umwelt_lab::comparison::Comparison;
use umwelt_lab::evolution::Evolution;

/// What every route can reach; cheap to clone.
#[derive(Clone)]
pub(crate) struct App {
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
    /// Time for a body to arrive in full.
    pub(crate) body_timeout: Duration,
    /// How long answers may take.
    pub(crate) deadlines: Deadlines,
    /// Set when event streams are to end, since they would outlast any shutdown.
    pub(crate) closing: Arc<watch::Sender<bool>>,
}

impl FromRef<App> for Jobs<Evolution> {
    fn from_ref(app: &App) -> Self {
        app.evolutions.clone()
    }
}

impl FromRef<App> for Jobs<Comparison> {
    fn from_ref(app: &App) -> Self {
        app.comparisons.clone()
    }
}
