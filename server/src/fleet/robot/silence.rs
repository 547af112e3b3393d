//! Notices that nothing comes from a robot's agent any more.

use super::command::Event;
use super::snapshot::Snapshot;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};

/// Tells the robot's task where nothing has come from its agent for `lost_after`, until the robot is gone.
pub(super) async fn watch(
    mut shown: watch::Receiver<Arc<Snapshot>>,
    queue: mpsc::WeakSender<Event>,
    lost_after: Duration,
) {
    loop {
        let silent = match shown.wait_for(|now| now.falls_silent(lost_after).is_some()).await {
            Ok(now) => now.falls_silent(lost_after),
            Err(_) => return,
        };
        let Some(silent) = silent else { continue };
        tokio::time::sleep_until(silent).await;
        let now = shown.borrow_and_update().falls_silent(lost_after);
        if now.is_none_or(|now| now > silent) {
            continue;
        }
        let Some(queue) = queue.upgrade() else { return };
        // Its task decides; whatever it does then shows.
        if queue.send(Event::Silence).await.is_err() {
            return;
        }
        drop(queue);
        if shown.changed().await.is_err() {
            return;
        }
    }
}
