//! Keeping what the robots learn: one background task reads what they show and writes all that is new in one commit.
//!
//! No robot's task waits for it, and it waits for none. A disk wears out with every write: what robots learn is kept
//! by how much that is ([`Saved::is_news_after`](umwelt_core::controller::Saved::is_news_after)), and seldom.

use super::{Fleet, Inner, Saver};
use crate::fleet::robot::Snapshot;
use crate::store::Change;
use std::sync::{Arc, Weak};
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};

/// How often it is looked whether a round is due, and what the store refused is tried again: well below a second.
const TICK: Duration = Duration::from_millis(500);

/// What has changed by little is kept all the same after this long: a write a minute wears out no disk.
const KEEP_WITHIN: Duration = Duration::from_secs(60);

/// A store to which nothing was written for this long is tried, so that readiness does not speak of long ago.
const IDLE: Duration = Duration::from_secs(10);

/// What is worth a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Worth {
    /// That the watch holds a robot, or no longer does: after a crash it must not go on by itself.
    Hold,
    /// News, and what has not been kept for long.
    News,
    /// Whatever has changed.
    Change,
}

/// Saves what the robots of `fleet` learn as long as it is there, in rounds at least `every` apart.
pub(super) fn start(fleet: &Fleet, every: Duration) {
    let fleet: Weak<Inner> = Arc::downgrade(&fleet.0);
    let mut ticks = interval(TICK.min(every));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    tokio::spawn(async move {
        let mut round: Option<Instant> = None;
        loop {
            let now = ticks.tick().await;
            let Some(inner) = fleet.upgrade() else { return };
            let fleet = Fleet(inner);
            let is_round = round.is_none_or(|round| now.duration_since(round) >= every);
            if is_round {
                round = Some(now);
            }
            fleet.save_what_is(if is_round { Worth::News } else { Worth::Hold }).await;
            fleet.0.keeper.probe(IDLE).await;
        }
    });
}

impl Fleet {
    /// Keeps what every robot has learned since it was last kept, however little.
    pub(crate) async fn save(&self) {
        self.save_what_is(Worth::Change).await;
    }

    /// All of it in one commit. What cannot be kept now is tried again in the next round; the keeper says so once.
    async fn save_what_is(&self, worth: Worth) {
        let mut saver = self.0.saver.lock().await;
        let now = Instant::now();
        let mut shown = Saver::new();
        let mut changes = Vec::new();
        for robot in self.robots(None) {
            let (id, snapshot) = (robot.id().clone(), robot.snapshot());
            match saver.get(&id) {
                Some(kept) if !is_worth(worth, kept, &snapshot, now) => {
                    shown.insert(id, kept.clone());
                }
                // Its first round is to come.
                None if worth == Worth::Hold && !snapshot.is_held_by_watch() => {}
                _ => {
                    let posterior = Box::new(snapshot.posterior());
                    changes.push(Change::PutPosterior(id.clone(), posterior));
                    shown.insert(id, (snapshot, now));
                }
            }
        }
        if changes.is_empty() || self.0.keeper.commit(changes).await.is_ok() {
            *saver = shown;
        }
    }
}

fn is_worth(
    worth: Worth,
    (kept, when): &(Arc<Snapshot>, Instant),
    now_shown: &Arc<Snapshot>,
    now: Instant,
) -> bool {
    let has_changed = !Arc::ptr_eq(kept, now_shown) && !kept.is_learned_as(now_shown);
    let is_due = || match worth {
        Worth::Hold => now_shown.is_held_otherwise(kept),
        Worth::News => now.duration_since(*when) >= KEEP_WITHIN || now_shown.is_news_after(kept),
        Worth::Change => true,
    };
    has_changed && is_due()
}
