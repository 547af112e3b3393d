//! The robots there are: describing, removing, listing and telling them, in step with the store.
//!
//! A change is kept by the store first and told to the robot then: what is acknowledged is kept, and what cannot be
//! kept is refused and changes nothing. Stopping is the other way round: it must work whatever the store does.
//! A change once begun runs to its end, even if the caller has gone.

pub(crate) mod feed;
mod keeping;
mod open;
pub(crate) mod robot;
mod saving;
mod stop;

use crate::fleet::robot::{Arrivals, Brake, Command, Common, Robot, RobotChange, Snapshot};
use crate::library::priors::Users;
use crate::resource::change::{Put, to_the_end};
use crate::resource::condition::Condition;
use crate::resource::failure::{self, Failure};
use crate::store::{Change, Keeper, Kind, Posterior, Record, StopKeeper, Told, Unreadables};
pub(crate) use keeping::Stops;
use keeping::Unkept;
use std::collections::BTreeMap;
use std::ops::Bound;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use tokio::sync::{Mutex, Notify};
use tokio::time::Instant;
use umwelt_api::RobotId;
use umwelt_core::controller::Saved;
use umwelt_core::task::Task;

/// What each robot showed when it was last kept, and when that was.
type Saver = BTreeMap<RobotId, (Arc<Snapshot>, Instant)>;

/// All robots; cheap to clone.
#[derive(Clone)]
pub(crate) struct Fleet(Arc<Inner>);

struct Inner {
    robots: RwLock<BTreeMap<RobotId, Arc<Robot>>>,
    /// Held while a robot comes into being, so that there is one of each id and no more than the limit.
    creating: Mutex<()>,
    keeper: Keeper,
    /// What was last kept of what the robots learn.
    saver: Mutex<Saver>,
    /// Gives stops and resumes their places.
    arrivals: Arrivals,
    /// The highest place that an earlier run of the server has written down.
    earlier: u64,
    /// Where stops and resumes are kept at once; none where there is only the store.
    journal: Option<StopKeeper>,
    /// What of them the store has still to take in.
    unkept: std::sync::Mutex<Unkept>,
    /// Wakes the one who brings it there.
    behind: Arc<Notify>,
    /// The highest revision that a record ever had.
    revision: AtomicU64,
    /// What is kept of robots and cannot be read.
    unreadable: Unreadables,
    common: Common,
    max_robots: usize,
    draining: AtomicBool,
}

impl Fleet {
    /// The robot with this id.
    pub(crate) fn find(&self, id: &RobotId) -> Option<Arc<Robot>> {
        self.0.robots.read().unwrap_or_else(PoisonError::into_inner).get(id).cloned()
    }

    /// Every robot whose id is above `after`, in the order of the ids.
    pub(crate) fn robots(&self, after: Option<&RobotId>) -> Vec<Arc<Robot>> {
        let robots = self.0.robots.read().unwrap_or_else(PoisonError::into_inner);
        let from = after.map_or(Bound::Unbounded, Bound::Excluded);
        robots
            .range::<RobotId, _>((from, Bound::Unbounded))
            .map(|(_, robot)| Arc::clone(robot))
            .collect()
    }

    /// Which robots use which prior, in the order of their ids.
    pub(crate) fn users(&self) -> Users {
        let named = |robot: Arc<Robot>| {
            let prior = robot.snapshot().prior().map(str::to_owned);
            prior.map(|prior| (prior, robot.id().clone()))
        };
        self.robots(None).into_iter().filter_map(named).collect()
    }

    /// Describes a robot, for the first time or anew.
    pub(crate) async fn put(
        &self,
        id: RobotId,
        told: Told,
        condition: Condition,
    ) -> Result<(Arc<Robot>, Put), Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            loop {
                fleet.accepts_changes()?;
                let done = match fleet.find(&id) {
                    Some(robot) => fleet.replace(robot, &told, &condition).await?,
                    None => fleet.create(&id, &told, &condition).await?,
                };
                // Otherwise it was removed or created by someone else meanwhile: look again.
                if let Some(done) = done {
                    return Ok(done);
                }
            }
        })
        .await
    }

    async fn create(
        &self,
        id: &RobotId,
        told: &Told,
        condition: &Condition,
    ) -> Result<Option<(Arc<Robot>, Put)>, Failure> {
        let _creating = self.0.creating.lock().await;
        if self.find(id).is_some() {
            return Ok(None);
        }
        condition.check(None)?;
        id.check_new()?;
        if self.robots(None).len() >= self.0.max_robots {
            return Err(failure::limit_reached("robots", self.0.max_robots));
        }
        let revision = self.next_revision();
        let record = Record { told: told.clone(), task: None, stopped: false, revision };
        self.keep(id, &record, None).await?;
        self.0.unreadable.remove(Kind::Robot, id.as_str());
        Ok(Some((self.insert(id.clone(), record, None, None), Put::Created)))
    }

    async fn replace(
        &self,
        robot: Arc<Robot>,
        told: &Told,
        condition: &Condition,
    ) -> Result<Option<(Arc<Robot>, Put)>, Failure> {
        let _writing = robot.writing.lock().await;
        let snapshot = robot.snapshot();
        if snapshot.is_removed() {
            return Ok(None);
        }
        robot.is_not_stuck()?;
        condition.check(Some(snapshot.etag()))?;
        let change = RobotChange::Told(Box::new(told.clone()));
        if !robot.is_alive() {
            // Its task has died. Someone describes it anew, so it may drive again; followers begin anew. What it
            // learned may be what it died of.
            let record = change.kept(robot.record(), self.next_revision());
            self.keep(robot.id(), &record, None).await?;
            robot.ring().close();
            // A stop that comes meanwhile comes to the one brake.
            let brake = Some(Arc::clone(robot.brake()));
            return Ok(Some((self.insert(robot.id().clone(), record, None, brake), Put::Replaced)));
        }
        self.make(&robot, &snapshot, change).await?;
        Ok(Some((Arc::clone(&robot), Put::Replaced)))
    }

    /// Removes a robot with its task.
    pub(crate) async fn delete(
        &self,
        robot: Arc<Robot>,
        condition: Condition,
    ) -> Result<(), Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            fleet.accepts_changes()?;
            let (_writing, snapshot) = robot.lock().await?;
            condition.check(Some(snapshot.etag()))?;
            let id = robot.id().clone();
            fleet.0.keeper.commit(vec![Change::DeleteRobot(id)]).await?;
            let told = robot.tell(Command::Remove).await;
            fleet.forget_words(&robot).await;
            fleet.0.robots.write().unwrap_or_else(PoisonError::into_inner).remove(robot.id());
            // A task that has died cannot be told, nor one whose computation does not end; the robot is gone all the same.
            robot.ring().close();
            if robot.unable().is_some() { Ok(()) } else { told }
        })
        .await
    }

    /// Removes a robot that cannot be read.
    pub(crate) async fn give_up(&self, id: RobotId, condition: Condition) -> Result<(), Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            fleet.accepts_changes()?;
            let _creating = fleet.0.creating.lock().await;
            if !fleet.0.unreadable.has(Kind::Robot, id.as_str()) {
                return Err(failure::no_such_robot(&id));
            }
            // No one has seen a version of it.
            condition.check(None)?;
            fleet.0.keeper.commit(vec![Change::DeleteRobot(id.clone())]).await?;
            fleet.0.unreadable.remove(Kind::Robot, id.as_str());
            Ok(())
        })
        .await
    }

    /// Sets a robot's task. The very task that it has already goes on as it is: a PUT that is sent twice, by whoever did
    /// not get the answer, does not send a robot back to its first waypoint.
    pub(crate) async fn put_task(
        &self,
        robot: Arc<Robot>,
        task: Task,
        condition: Condition,
    ) -> Result<Put, Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            let before = fleet.change_task(&robot, Some(task), &condition).await?;
            Ok(if before { Put::Replaced } else { Put::Created })
        })
        .await
    }

    /// Cancels a robot's task.
    pub(crate) async fn delete_task(
        &self,
        robot: Arc<Robot>,
        condition: Condition,
    ) -> Result<(), Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            if robot.snapshot().task_etag().is_none() {
                return Err(failure::no_task(robot.id()));
            }
            fleet.change_task(&robot, None, &condition).await?;
            Ok(())
        })
        .await
    }

    /// Keeps and tells another task. Returns whether there was one before.
    async fn change_task(
        &self,
        robot: &Robot,
        task: Option<Task>,
        condition: &Condition,
    ) -> Result<bool, Failure> {
        self.accepts_changes()?;
        let (_writing, snapshot) = robot.change().await?;
        condition.check(snapshot.task_etag())?;
        if robot.is_alive() && task.as_ref().is_some_and(|task| snapshot.has_task(task)) {
            return Ok(true);
        }
        self.make(robot, &snapshot, RobotChange::Task(task)).await?;
        Ok(snapshot.task_etag().is_some())
    }

    /// Keeps a change of a robot, and tells it then.
    async fn make(
        &self,
        robot: &Robot,
        snapshot: &Snapshot,
        change: RobotChange,
    ) -> Result<(), Failure> {
        let revision = self.next_revision();
        let record = change.kept(robot.record(), revision);
        self.keep(robot.id(), &record, Some(snapshot.saved_after(&change))).await?;
        robot.tell(Command::Change { change, revision }).await
    }

    /// Whether the server is shutting down.
    pub(crate) fn is_draining(&self) -> bool {
        self.0.draining.load(Ordering::SeqCst)
    }

    fn accepts_changes(&self) -> Result<(), Failure> {
        if self.is_draining() { Err(failure::draining()) } else { Ok(()) }
    }

    fn insert(
        &self,
        id: RobotId,
        record: Record,
        saved: Option<Saved>,
        brake: Option<Arc<Brake>>,
    ) -> Arc<Robot> {
        let common = self.0.common.clone();
        let robot = Arc::new(Robot::spawn(id.clone(), record, saved, brake, common));
        let mut robots = self.0.robots.write().unwrap_or_else(PoisonError::into_inner);
        robots.insert(id, Arc::clone(&robot));
        robot
    }

    /// One that no record of this fleet has had.
    fn next_revision(&self) -> u64 {
        self.0.revision.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Keeps a record and, with it, what the robot has learned as it is under that record.
    async fn keep(
        &self,
        id: &RobotId,
        record: &Record,
        saved: Option<Saved>,
    ) -> Result<(), Failure> {
        let revision = record.revision;
        let mut changes = vec![Change::PutRobot(id.clone(), Box::new(record.clone()))];
        changes.extend(saved.map(|saved| {
            Change::PutPosterior(id.clone(), Box::new(Posterior { revision, saved }))
        }));
        self.0.keeper.commit(changes).await
    }
}

#[cfg(test)]
mod tests;
