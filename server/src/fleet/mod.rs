//! The robots there are: describing, removing, listing and telling them, in step with the store.
//!
//! A change is kept by the store first and told to the robot then: what is acknowledged is kept, and what cannot be
//! kept is refused and changes nothing. Stopping is the other way round: it must work whatever the store does.
//! A change once begun runs to its end, even if the caller has gone.

mod stop;

use crate::condition::Condition;
use crate::config::Config;
use crate::failure::{self, Failure};
use crate::feed::Feed;
use crate::robot::{Command, Robot};
use crate::store::{Record, Store, StoreError};
use std::collections::BTreeMap;
use std::ops::Bound;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;
use tokio::sync::Mutex;
use umwelt_api::RobotId;
use umwelt_core::controller::settings::Settings;
use umwelt_core::controller::task::Task;

/// What a PUT did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Put {
    /// There was nothing before.
    Created,
    /// It took the place of another.
    Replaced,
}

/// All robots; cheap to clone.
#[derive(Clone)]
pub(crate) struct Fleet(Arc<Inner>);

struct Inner {
    robots: RwLock<BTreeMap<RobotId, Arc<Robot>>>,
    /// Held while a robot comes into being, so that there is one of each id and no more than the limit.
    creating: Mutex<()>,
    store: Arc<dyn Store>,
    feed: Feed,
    max_robots: usize,
    lost_after: Duration,
    draining: AtomicBool,
}

impl Fleet {
    /// The robots that the store keeps.
    pub(crate) async fn open(
        config: &Config,
        store: Arc<dyn Store>,
        feed: Feed,
    ) -> Result<Self, StoreError> {
        let fleet = Self(Arc::new(Inner {
            robots: RwLock::default(),
            creating: Mutex::default(),
            store,
            feed,
            max_robots: config.max_robots,
            lost_after: config.lost_after,
            draining: AtomicBool::new(false),
        }));
        let store = Arc::clone(&fleet.0.store);
        let listed = tokio::task::spawn_blocking(move || store.list()).await;
        for (id, record) in listed.map_err(|error| StoreError::Damaged(error.to_string()))?? {
            fleet.insert(id, record);
        }
        Ok(fleet)
    }

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

    /// Describes a robot, for the first time or anew.
    pub(crate) async fn put(
        &self,
        id: RobotId,
        settings: Settings,
        condition: Condition,
    ) -> Result<(Arc<Robot>, Put), Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            loop {
                fleet.accepts_changes()?;
                let done = match fleet.find(&id) {
                    Some(robot) => fleet.replace(robot, settings, &condition).await?,
                    None => fleet.create(&id, settings, &condition).await?,
                };
                // Otherwise it was removed or created by somebody else meanwhile: look again.
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
        settings: Settings,
        condition: &Condition,
    ) -> Result<Option<(Arc<Robot>, Put)>, Failure> {
        let _creating = self.0.creating.lock().await;
        if self.find(id).is_some() {
            return Ok(None);
        }
        condition.check(None)?;
        if self.robots(None).len() >= self.0.max_robots {
            return Err(failure::limit_reached("robots", self.0.max_robots));
        }
        let record = Record { settings, task: None, stopped: false };
        self.keep(id, &record).await?;
        Ok(Some((self.insert(id.clone(), record), Put::Created)))
    }

    async fn replace(
        &self,
        robot: Arc<Robot>,
        settings: Settings,
        condition: &Condition,
    ) -> Result<Option<(Arc<Robot>, Put)>, Failure> {
        let _writing = robot.writing.lock().await;
        let snapshot = robot.snapshot();
        if snapshot.is_removed() {
            return Ok(None);
        }
        condition.check(Some(snapshot.etag()))?;
        let record = Record { settings, ..snapshot.record() };
        self.keep(robot.id(), &record).await?;
        if !robot.is_alive() {
            // Its task has died. Somebody describes it anew, so it may drive again; followers begin anew.
            robot.ring().close();
            return Ok(Some((self.insert(robot.id().clone(), record), Put::Replaced)));
        }
        robot.tell(Command::Replace(Box::new(settings))).await?;
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
            let (_writing, snapshot) = robot.change().await?;
            condition.check(Some(snapshot.etag()))?;
            let id = robot.id().clone();
            fleet.with_store(move |store| store.delete(&id)).await?;
            let told = robot.tell(Command::Remove).await;
            fleet.0.robots.write().unwrap_or_else(PoisonError::into_inner).remove(robot.id());
            // A task that has died cannot be told; the robot is gone all the same.
            told.or_else(|failure| if robot.is_alive() { Err(failure) } else { Ok(()) })
        })
        .await
    }

    /// Sets a robot's task.
    pub(crate) async fn put_task(
        &self,
        robot: Arc<Robot>,
        task: Task,
        condition: Condition,
    ) -> Result<Put, Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            let command = Command::SetTask(task.clone());
            let before = fleet.change_task(&robot, Some(task), command, &condition).await?;
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
            fleet.change_task(&robot, None, Command::CancelTask, &condition).await?;
            Ok(())
        })
        .await
    }

    /// Keeps and tells another task. Returns whether there was one before.
    async fn change_task(
        &self,
        robot: &Robot,
        task: Option<Task>,
        command: Command,
        condition: &Condition,
    ) -> Result<bool, Failure> {
        self.accepts_changes()?;
        let (_writing, snapshot) = robot.change().await?;
        condition.check(snapshot.task_etag())?;
        self.keep(robot.id(), &Record { task, ..snapshot.record() }).await?;
        robot.tell(command).await?;
        Ok(snapshot.task_etag().is_some())
    }

    /// Whether the server is shutting down.
    pub(crate) fn is_draining(&self) -> bool {
        self.0.draining.load(Ordering::SeqCst)
    }

    fn accepts_changes(&self) -> Result<(), Failure> {
        if self.is_draining() { Err(failure::draining()) } else { Ok(()) }
    }

    fn insert(&self, id: RobotId, record: Record) -> Arc<Robot> {
        let robot = Arc::new(Robot::spawn(id.clone(), record, self.0.lost_after, &self.0.feed));
        let mut robots = self.0.robots.write().unwrap_or_else(PoisonError::into_inner);
        robots.insert(id, Arc::clone(&robot));
        robot
    }

    async fn keep(&self, id: &RobotId, record: &Record) -> Result<(), Failure> {
        let (id, record) = (id.clone(), record.clone());
        self.with_store(move |store| store.put(&id, &record)).await
    }

    /// Calls the store on a thread where it may block.
    async fn with_store<T: Send + 'static>(
        &self,
        call: impl FnOnce(&dyn Store) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, Failure> {
        let store = Arc::clone(&self.0.store);
        match tokio::task::spawn_blocking(move || call(&*store)).await {
            Ok(result) => result.map_err(Failure::from),
            Err(error) => Err(broken(&error)),
        }
    }
}

/// Runs a change to its end even if the caller goes away: half a change would part the robot from the store.
async fn to_the_end<T: Send + 'static>(
    change: impl Future<Output = Result<T, Failure>> + Send + 'static,
) -> Result<T, Failure> {
    tokio::spawn(change).await.unwrap_or_else(|error| Err(broken(&error)))
}

fn broken(error: &tokio::task::JoinError) -> Failure {
    tracing::error!(%error, "a change broke off");
    failure::internal("the change broke off; the log says why")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::MemoryStore;

    #[tokio::test]
    async fn a_robot_whose_task_has_died_drives_again_once_it_is_described_anew() {
        let store = Arc::new(MemoryStore::default());
        let fleet = Fleet::open(&Config::default(), store, Feed::new()).await.unwrap();
        let dead = Arc::new(Robot::dead("r").await);
        fleet.0.robots.write().unwrap().insert(dead.id().clone(), Arc::clone(&dead));
        assert!(fleet.stop_all().await.is_err(), "nobody may think that it was told");
        let (robot, put) =
            fleet.put(dead.id().clone(), Settings::default(), Condition::default()).await.unwrap();
        assert_eq!(put, Put::Replaced);
        assert!(robot.is_alive());
        assert_eq!(fleet.stop_all().await, Ok(1));
        fleet.delete(robot, Condition::default()).await.unwrap();
        assert!(fleet.find(dead.id()).is_none());
    }

    #[tokio::test]
    async fn a_robot_whose_task_has_died_can_be_removed() {
        let store = Arc::new(MemoryStore::default());
        let fleet = Fleet::open(&Config::default(), store, Feed::new()).await.unwrap();
        let dead = Arc::new(Robot::dead("r").await);
        fleet.0.robots.write().unwrap().insert(dead.id().clone(), Arc::clone(&dead));
        fleet.delete(Arc::clone(&dead), Condition::default()).await.unwrap();
        assert!(fleet.find(dead.id()).is_none());
    }
}
