//! Whether a robot's task is well: one whose computation does not end is shown as failed until it does.

use crate::fleet::feed::{Feed, Ring};
use std::sync::Arc;
use tokio::sync::watch;
use umwelt_api::RobotId;
use umwelt_api::event::Kind;
use umwelt_api::robot::State;

/// Whether the computation of a robot has failed to end.
#[derive(Debug)]
pub(crate) struct Vitals {
    id: RobotId,
    ring: Arc<Ring>,
    feed: Feed,
    failed: watch::Sender<bool>,
}

impl Vitals {
    pub(crate) fn new(id: RobotId, ring: Arc<Ring>, feed: Feed) -> Self {
        Self { id, ring, feed, failed: watch::Sender::new(false) }
    }

    /// Its computation has not ended for long.
    pub(super) fn fail(&self) {
        if !self.failed.send_replace(true) {
            tracing::error!(
                robot = %self.id,
                "robot computation does not end: it is shown as failed, its requests are refused; please report this"
            );
            self.feed.publish(&self.ring, &self.id, Kind::Link { state: State::Failed });
        }
    }

    /// It has ended after all.
    pub(super) fn recover(&self) {
        if self.failed.send_replace(false) {
            tracing::warn!(robot = %self.id, "robot computation ended after all: it goes on");
            self.feed.publish(&self.ring, &self.id, Kind::Link { state: State::Connected });
        }
    }

    /// Whether it has not ended for long.
    pub(crate) fn has_failed(&self) -> bool {
        *self.failed.borrow()
    }

    /// Comes once it has failed.
    pub(crate) async fn failed(&self) {
        // The sender is here, so this ends only where it has failed.
        let _ = self.failed.subscribe().wait_for(|failed| *failed).await;
    }
}
