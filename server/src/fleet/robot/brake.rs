//! What a robot was told of stopping, where everybody can reach it: whoever stops it need not wait for its task.

use super::stop_order::{Arrival, Overtaken, StopOrder};
use crate::fleet::feed::{Feed, Ring};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use umwelt_api::RobotId;
use umwelt_api::event::Kind;

/// The stop order of one robot. Its task reads it at every step, so a stop acts on the next reply, however long the
/// robot's queue is; it outlives the task.
#[derive(Debug)]
pub(crate) struct Brake {
    order: Mutex<StopOrder>,
    id: RobotId,
    feed: Feed,
}

impl Brake {
    pub(crate) fn new(id: RobotId, stopped: bool, feed: Feed) -> Self {
        Self { order: Mutex::new(StopOrder::new(stopped)), id, feed }
    }

    /// A stop has arrived. Followers of `ring` hear of it where it changes something. Returns how it stands now.
    pub(crate) fn stop(&self, arrival: Arrival, ring: &Arc<Ring>) -> StopOrder {
        let mut order = self.lock();
        let was_stopped = order.is_stopped();
        order.stop(arrival);
        self.tell(ring, was_stopped, *order);
        *order
    }

    /// A resume takes effect, or was overtaken.
    pub(crate) fn resume(&self, arrival: Arrival, ring: &Arc<Ring>) -> Result<(), Overtaken> {
        let mut order = self.lock();
        let was_stopped = order.is_stopped();
        order.resume(arrival)?;
        self.tell(ring, was_stopped, *order);
        Ok(())
    }

    /// How it stands now.
    pub(crate) fn order(&self) -> StopOrder {
        *self.lock()
    }

    /// Says a change while no one else can make one, so that events come in the order of what they say.
    fn tell(&self, ring: &Arc<Ring>, was_stopped: bool, now: StopOrder) {
        if was_stopped != now.is_stopped() {
            let kind = if now.is_stopped() { Kind::Stopped } else { Kind::Resumed };
            self.feed.publish(ring, &self.id, kind);
        }
    }

    fn lock(&self) -> MutexGuard<'_, StopOrder> {
        // Two numbers are whole whatever happened behind the lock.
        self.order.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
