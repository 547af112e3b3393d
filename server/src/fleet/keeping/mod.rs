//! How stops and resumes are kept: at once in the journal of stops beside the store, where there is one, and in the
//! store behind it. A task brings into the store what only the journal says, and empties the journal then.
//!
//! The journal is read at the start, and its word about a robot counts before the store's. So nothing is taken out of
//! it that the store does not hold, and nothing is acknowledged that an older word in it would take back.

mod words;

pub(crate) use words::{Stops, Unkept};

use super::{Fleet, Inner};
use crate::fleet::robot::{Arrival, Robot};
use crate::resource::change::to_the_end;
use crate::resource::failure::Failure;
use crate::store::{Change, Entry, Word};
use std::sync::{Arc, MutexGuard, PoisonError, Weak};
use std::time::Duration;
use tokio::time::{Instant, timeout, timeout_at};
use umwelt_api::problem::{Detail, Status, reason};

/// Longest wait for the disk before a stop is acknowledged: far above a sync, far below a person's patience.
const KEEP_STOP: Duration = Duration::from_millis(300);

/// Longest wait for the disk before a resume is refused.
const KEEP_RESUME: Duration = Duration::from_secs(2);

/// Pause before what could not be brought into the store is tried again.
const RETRY: Duration = Duration::from_millis(500);

/// How often the task looks whether the fleet is still there while it has nothing to do.
const IDLE: Duration = Duration::from_secs(10);

/// Most robots whose records go into one commit: large tasks, and others wait for the store as well.
const CHUNK: usize = 64;

/// Brings words into the store as long as `fleet` is there.
pub(super) fn start(fleet: &Fleet) {
    let (inner, wake): (Weak<Inner>, _) = (Arc::downgrade(&fleet.0), Arc::clone(&fleet.0.behind));
    tokio::spawn(async move {
        loop {
            let is_done = match inner.upgrade() {
                Some(inner) => Fleet(inner).catch_up().await,
                None => return,
            };
            let pause = if is_done { IDLE } else { RETRY };
            let woken = timeout(pause, wake.notified()).await;
            if woken.is_ok() && !is_done {
                // A store that fails is not asked more often because more is to be kept.
                tokio::time::sleep(RETRY).await;
            }
        }
    });
}

impl Fleet {
    /// Keeps that `robots` are stopped since `arrival`, soon; returns whether it is kept.
    pub(super) async fn keep_stops(&self, robots: Vec<Arc<Robot>>, arrival: Arrival) -> bool {
        if robots.is_empty() {
            return true;
        }
        let is_first = self.mark(&robots, arrival);
        let end = Instant::now() + KEEP_STOP;
        if let Some(journal) = &self.0.journal {
            let written = journal.append(entries(&robots, Word::Stop, arrival));
            match timeout_at(end, written).await {
                Ok(Ok(())) => {
                    self.0.behind.notify_one();
                    return true;
                }
                Ok(Err(error)) => tracing::error!(%error, "cannot write journal of stops"),
                Err(_) => tracing::error!("cannot keep a stop yet: the disk does not answer"),
            }
        }
        self.0.behind.notify_one();
        // An older word elsewhere might take the store's back, or the store is being asked already.
        if !is_first {
            return false;
        }
        let (fleet, count) = (self.clone(), robots.len());
        let keeping = to_the_end(async move { fleet.keep_as_they_are(&robots).await });
        let kept = matches!(timeout_at(end, keeping).await, Ok(Ok(())));
        if !kept {
            tracing::warn!(
                robots = count,
                "robots stopped, but that is not kept yet: a restart now would let them go on"
            );
        }
        kept
    }

    /// Keeps that `robots` go on since `arrival`, and lets them. Returns those that a stop has overtaken.
    pub(super) async fn keep_and_resume(
        &self,
        robots: &[Arc<Robot>],
        arrival: Arrival,
    ) -> Result<Vec<Arc<Robot>>, Failure> {
        let is_to_be_kept = |robot: &&Arc<Robot>| {
            let order = robot.brake().order();
            order.is_stopped() && !order.is_overtaken(arrival)
        };
        let resting: Vec<_> = robots.iter().filter(is_to_be_kept).cloned().collect();
        let Some(journal) = self.0.journal.as_ref().filter(|_| !resting.is_empty()) else {
            return self.resume_in_store(robots, &resting, arrival).await;
        };
        let is_first = self.mark(&resting, arrival);
        let written = journal.append(entries(&resting, Word::Resume, arrival));
        let written = timeout(KEEP_RESUME, written).await;
        self.0.behind.notify_one();
        match written {
            Ok(Ok(())) => {
                let overtaken = go_on(robots, arrival);
                for robot in &overtaken {
                    // What is answered as without effect is without effect after a restart as well.
                    let stop = robot.brake().order().newest();
                    let entries = entries(std::slice::from_ref(robot), Word::Stop, stop);
                    let _ = timeout(KEEP_STOP, journal.append(entries)).await;
                }
                Ok(overtaken)
            }
            Ok(Err(error)) if is_first => {
                tracing::error!(%error, "cannot write journal of stops");
                let done = self.resume_in_store(robots, &resting, arrival).await;
                if done.is_err() {
                    self.stay(resting).await;
                }
                done
            }
            _ => {
                self.stay(resting).await;
                let remedy = "nothing was changed: they rest; ask again";
                Err(Failure::new(Status::Unavailable, "the journal of stops cannot be written")
                    .with(Detail::new(reason::STORE_FAILED, "", (), remedy)))
            }
        }
    }

    /// A resume failed half way: its word may be on the disk, so a stop is put behind it.
    async fn stay(&self, mut robots: Vec<Arc<Robot>>) {
        let arrival = self.0.arrivals.next();
        robots.retain(|robot| robot.is_stopped() && robot.stop(arrival).is_stopped());
        self.keep_stops(robots, arrival).await;
    }

    /// The same without a journal: `resting` are those of `robots` for which it changes something.
    async fn resume_in_store(
        &self,
        robots: &[Arc<Robot>],
        resting: &[Arc<Robot>],
        arrival: Arrival,
    ) -> Result<Vec<Arc<Robot>>, Failure> {
        // Held until it has taken effect: what others write about the robots meanwhile must not say the opposite.
        let mut writing = Vec::with_capacity(resting.len());
        for robot in resting {
            writing.push(robot.writing.lock().await);
        }
        let going = |robot: &Arc<Robot>| {
            let record = robot.snapshot().record(false);
            Change::PutRobot(robot.id().clone(), Box::new(record))
        };
        let there = resting.iter().filter(|robot| !robot.snapshot().is_removed());
        let changes: Vec<_> = there.map(going).collect();
        if !changes.is_empty() {
            self.0.keeper.commit(changes).await?;
        }
        let overtaken = go_on(robots, arrival);
        let too_late: Vec<_> = resting.iter().filter(|robot| robot.is_stopped()).cloned().collect();
        if !too_late.is_empty() && self.commit_as_they_are(&too_late).await.is_err() {
            self.mark(&too_late, arrival);
            self.0.behind.notify_one();
        }
        Ok(overtaken)
    }

    /// Forgets what the journal says of a robot that is no more: another may get its name.
    pub(super) async fn forget_words(&self, robot: &Arc<Robot>) {
        let has_words = self.unkept().due.contains_key(robot.id());
        let Some(journal) = self.0.journal.as_ref().filter(|_| has_words) else { return };
        let arrival = self.0.arrivals.next();
        let robots = std::slice::from_ref(robot);
        self.mark(robots, arrival);
        let written = timeout(KEEP_RESUME, journal.append(entries(robots, Word::Resume, arrival)));
        if !matches!(written.await, Ok(Ok(()))) {
            tracing::warn!(robot = %robot.id(), "robot removed; one of that name would begin stopped after a restart now");
        }
        self.0.behind.notify_one();
    }

    /// Brings into the store what only the journal says, and empties the journal. Returns whether all is done.
    pub(crate) async fn catch_up(&self) -> bool {
        if self.unkept().due.is_empty() {
            return true;
        }
        let missing = self.unkept().missing();
        for ids in missing.chunks(CHUNK) {
            let newest = self.0.arrivals.newest();
            let mut robots = Vec::with_capacity(ids.len());
            for id in ids {
                match self.find(id).filter(|robot| !robot.snapshot().is_removed()) {
                    Some(robot) => robots.push(robot),
                    // All that was said so far was said of one that is gone.
                    None => self.unkept().hold(id, newest.0),
                }
            }
            if self.keep_as_they_are(&robots).await.is_err() {
                return false;
            }
        }
        let held = self.unkept().held.clone();
        if let Some(journal) = &self.0.journal {
            match journal.clear(held.clone()).await {
                Ok(true) => {}
                Ok(false) => return false,
                Err(error) => {
                    tracing::warn!(%error, "cannot empty journal of stops");
                    return false;
                }
            }
        }
        let mut unkept = self.unkept();
        unkept.settle(&held);
        unkept.due.is_empty()
    }

    /// Keeps in the store how `robots` are told to rest or to go on, in one commit.
    async fn keep_as_they_are(&self, robots: &[Arc<Robot>]) -> Result<(), Failure> {
        let mut writing = Vec::with_capacity(robots.len());
        for robot in robots {
            writing.push(robot.writing.lock().await);
        }
        self.commit_as_they_are(robots).await
    }

    /// The same for those whose records no one else writes meanwhile.
    async fn commit_as_they_are(&self, robots: &[Arc<Robot>]) -> Result<(), Failure> {
        let there: Vec<_> = robots.iter().filter(|robot| !robot.snapshot().is_removed()).collect();
        let orders: Vec<_> = there.iter().map(|robot| robot.brake().order()).collect();
        let change = |(robot, order): (&&Arc<Robot>, &crate::fleet::robot::StopOrder)| {
            let record = robot.snapshot().record(order.is_stopped());
            Change::PutRobot(robot.id().clone(), Box::new(record))
        };
        let changes: Vec<_> = there.iter().zip(&orders).map(change).collect();
        if !changes.is_empty() {
            self.0.keeper.commit(changes).await?;
        }
        let mut unkept = self.unkept();
        for (robot, order) in there.iter().zip(&orders) {
            // Words of an earlier run are part of what each robot began with.
            unkept.hold(robot.id(), order.newest().0.max(self.0.earlier));
        }
        if self.0.journal.is_none() {
            let held = unkept.held.clone();
            unkept.settle(&held);
        }
        Ok(())
    }

    /// Notes that the store does not hold the word of `arrival` about `robots`. Returns whether it held all about them.
    fn mark(&self, robots: &[Arc<Robot>], arrival: Arrival) -> bool {
        let mut unkept = self.unkept();
        let mut is_first = true;
        for robot in robots {
            is_first &= unkept.mark(robot.id(), arrival);
        }
        is_first
    }

    fn unkept(&self) -> MutexGuard<'_, Unkept> {
        // Each map is whole whatever happened behind the lock.
        self.0.unkept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Lets `robots` go on. Returns those that a stop has overtaken.
fn go_on(robots: &[Arc<Robot>], arrival: Arrival) -> Vec<Arc<Robot>> {
    robots.iter().filter(|robot| robot.resume(arrival).is_err()).cloned().collect()
}

fn entries(robots: &[Arc<Robot>], word: Word, arrival: Arrival) -> Vec<Entry> {
    let entry = |robot: &Arc<Robot>| Entry { arrival: arrival.0, robot: robot.id().clone(), word };
    robots.iter().map(entry).collect()
}

#[cfg(test)]
mod tests;
