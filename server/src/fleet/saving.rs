//! Keeping what the robots learn: one background task reads what they show and writes all that is new in one commit.
//!
//! No robot's task waits for it, and it waits for none.

use super::{Fleet, Inner};
use crate::robot::Snapshot;
use crate::store::Change;
use std::collections::BTreeMap;
use std::sync::{Arc, Weak};
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};
use umwelt_api::RobotId;

/// How often what the robots learn is kept: a crash costs at most this and one write, well below a second.
const SAVE_EVERY: Duration = Duration::from_millis(500);

/// A store to which nothing was written for this long is tried, so that readiness does not speak of long ago.
const IDLE: Duration = Duration::from_secs(10);

/// What each robot showed when it was last kept.
pub(super) type Saver = BTreeMap<RobotId, Arc<Snapshot>>;

/// Saves what the robots of `fleet` learn as long as it is there.
pub(super) fn start(fleet: &Fleet) {
    let fleet: Weak<Inner> = Arc::downgrade(&fleet.0);
    let mut ticks = interval(SAVE_EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    tokio::spawn(async move {
        loop {
            ticks.tick().await;
            let Some(inner) = fleet.upgrade() else { return };
            let fleet = Fleet(inner);
            fleet.save().await;
            fleet.0.keeper.probe(IDLE).await;
        }
    });
}

impl Fleet {
    /// Keeps what every robot has learned since it was last kept. What cannot be kept now is tried again the next
    /// time; the keeper says so once.
    pub(crate) async fn save(&self) {
        let mut saver = self.0.saver.lock().await;
        let mut shown = Saver::new();
        let mut changes = Vec::new();
        for robot in self.robots(None) {
            let (id, snapshot) = (robot.id().clone(), robot.snapshot());
            let is_kept = saver
                .get(&id)
                .is_some_and(|kept| Arc::ptr_eq(kept, &snapshot) || kept.is_learned_as(&snapshot));
            if !is_kept {
                let posterior = Box::new(snapshot.posterior());
                changes.push(Change::PutPosterior(id.clone(), posterior));
            }
            shown.insert(id, snapshot);
        }
        if changes.is_empty() || self.0.keeper.commit(changes).await.is_ok() {
            *saver = shown;
        }
    }
}
