//! What every route can reach.

use crate::config::Config;
use crate::feed::Feed;
use crate::fleet::Fleet;
use std::sync::Arc;
use tokio::sync::{Semaphore, watch};

/// What every route can reach; cheap to clone.
#[derive(Clone)]
pub(crate) struct App {
    pub(crate) config: Arc<Config>,
    pub(crate) fleet: Fleet,
    pub(crate) feed: Feed,
    /// One permit per event stream.
    pub(crate) streams: Arc<Semaphore>,
    /// Set when event streams are to end, since they would outlast any shutdown.
    pub(crate) closing: Arc<watch::Sender<bool>>,
}

impl App {
    pub(crate) fn new(config: Config, fleet: Fleet, feed: Feed) -> Self {
        Self {
            streams: Arc::new(Semaphore::new(config.max_event_streams.min(Semaphore::MAX_PERMITS))),
            closing: Arc::default(),
            config: Arc::new(config),
            fleet,
            feed,
        }
    }
}
