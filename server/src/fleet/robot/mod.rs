//! One robot: a tokio task that owns its controller, and the handle by which the rest of the server reaches it.

mod brake;
mod change;
mod clock;
mod command;
mod common;
mod happening;
mod log;
mod pilot;
mod refusal;
mod session;
mod silence;
mod snapshot;
mod stop_order;
mod vitals;
mod workers;

pub(crate) use brake::Brake;
pub(crate) use change::RobotChange;
pub(crate) use command::Command;
pub(crate) use common::Common;
pub(crate) use snapshot::Snapshot;
pub(crate) use stop_order::{Arrival, Arrivals, Overtaken, StopOrder};
pub(crate) use workers::Workers;

use crate::fleet::feed::Ring;
use crate::resource::failure::{self, Failure};
use crate::store::Record;
use command::Event;
use pilot::Pilot;
use std::sync::Arc;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{Mutex, MutexGuard, mpsc, oneshot, watch};
use umwelt_api::RobotId;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::step::{Reply, TaggedDrive};
use umwelt_core::controller::Saved;
use umwelt_core::exchange::Request;
use vitals::Vitals;

/// Requests that may wait for a robot's task: all that an agent has in flight on its connections, and some more.
const QUEUE: usize = 16;

/// The handle of a robot's task.
#[derive(Debug)]
pub(crate) struct Robot {
    id: RobotId,
    queue: mpsc::Sender<Event>,
    snapshot: watch::Receiver<Arc<Snapshot>>,
    ring: Arc<Ring>,
    brake: Arc<Brake>,
    vitals: Arc<Vitals>,
    /// Held by whoever changes what is stored about the robot, so that store and controller change in one order.
    pub(crate) writing: Mutex<()>,
}

impl Robot {
    /// Starts the task of a robot, which goes on from what was `saved` of it, under the brake of one with this id that
    /// there was before, or a new one.
    pub(crate) fn spawn(
        id: RobotId,
        record: Record,
        saved: Option<Saved>,
        brake: Option<Arc<Brake>>,
        common: Common,
    ) -> Self {
        let (workers, lost_after) = (common.workers.clone(), common.lost_after);
        let (robot, pilot, events) = Self::prepare(id, record, saved, brake, common);
        workers.spawn(Arc::clone(&robot.vitals), pilot::run(pilot, events));
        let (shown, queue) = (robot.snapshot.clone(), robot.queue.downgrade());
        tokio::spawn(silence::watch(shown, queue, lost_after));
        robot
    }

    /// A robot whose task has not been started yet.
    fn prepare(
        id: RobotId,
        record: Record,
        saved: Option<Saved>,
        brake: Option<Arc<Brake>>,
        common: Common,
    ) -> (Self, Pilot, mpsc::Receiver<Event>) {
        let (feed, ring) = (common.feed.clone(), common.feed.ring());
        let of_record = || Arc::new(Brake::new(id.clone(), record.stopped, feed.clone()));
        let brake = brake.unwrap_or_else(of_record);
        let vitals = Arc::new(Vitals::new(id.clone(), Arc::clone(&ring), feed));
        let (of_task, its_brake) = (Arc::clone(&ring), Arc::clone(&brake));
        let (pilot, snapshot) = Pilot::new(id.clone(), record, saved, common, of_task, its_brake);
        let (queue, events) = mpsc::channel(QUEUE);
        let robot = Self { id, queue, snapshot, ring, brake, vitals, writing: Mutex::default() };
        (robot, pilot, events)
    }

    /// Its id.
    pub(crate) fn id(&self) -> &RobotId {
        &self.id
    }

    /// As it is now. Never waits for the robot's task; one whose task has died is lost, one whose computation does not
    /// end has failed.
    pub(crate) fn snapshot(&self) -> Arc<Snapshot> {
        let snapshot = Arc::clone(&self.snapshot.borrow());
        let snapshot = if self.has_failed() {
            Arc::new(snapshot.failed())
        } else if !self.is_alive() {
            Arc::new(snapshot.without_task())
        } else {
            snapshot
        };
        let is_stopped = self.is_stopped();
        // What it was told shows before its task has looked; that it rests because the server ends is no stop.
        let shows = snapshot.is_stopped() == is_stopped;
        if shows { snapshot } else { Arc::new(snapshot.told(is_stopped)) }
    }

    /// Its drive, where `tag` is that of another: asked with every step.
    pub(crate) fn other_drive(&self, tag: u64) -> Option<TaggedDrive> {
        self.snapshot.borrow().other_drive(tag)
    }

    /// What is to be kept of it as it is now.
    pub(crate) fn record(&self) -> Record {
        self.snapshot.borrow().record(self.is_stopped())
    }

    /// What it was told of stopping; outlives its task.
    pub(crate) fn brake(&self) -> &Arc<Brake> {
        &self.brake
    }

    /// Whether it was told to rest until it is resumed.
    pub(crate) fn is_stopped(&self) -> bool {
        self.brake.order().is_stopped()
    }

    /// A stop has arrived: it acts on the next reply, whatever the robot's task does. Returns how it stands now.
    pub(crate) fn stop(&self, arrival: Arrival) -> StopOrder {
        let order = self.brake.stop(arrival, &self.ring);
        self.look();
        order
    }

    /// A resume that is kept takes effect, or was overtaken by a stop.
    pub(crate) fn resume(&self, arrival: Arrival) -> Result<(), Overtaken> {
        self.brake.resume(arrival, &self.ring)
    }

    /// Lets its task look at the brake soon, without waiting; with a full queue it looks anyway.
    fn look(&self) {
        let (done, _) = oneshot::channel();
        let _ = self.queue.try_send(Event::Command { command: Command::Look, done });
    }

    /// Whether its computation does not end.
    pub(crate) fn has_failed(&self) -> bool {
        self.vitals.has_failed()
    }

    /// Why it cannot answer, where it cannot: its task has died, or its computation does not end.
    pub(crate) fn unable(&self) -> Option<Failure> {
        if self.has_failed() {
            Some(self.stuck())
        } else {
            (!self.is_alive()).then(|| self.ended())
        }
    }

    /// Begins a change of what is kept of the robot and told to its task, as [`Robot::lock`]; one whose task does not
    /// answer cannot be told.
    pub(crate) async fn change(&self) -> Result<(MutexGuard<'_, ()>, Arc<Snapshot>), Failure> {
        let locked = self.lock().await?;
        self.is_not_stuck()?;
        Ok(locked)
    }

    /// Refuses where its computation does not end.
    pub(crate) fn is_not_stuck(&self) -> Result<(), Failure> {
        if self.has_failed() { Err(self.stuck()) } else { Ok(()) }
    }

    /// Sees to it that no one else changes what is kept of the robot until the guard is dropped. Returns the guard with
    /// the robot as it is now; a robot that was removed meanwhile cannot be changed.
    pub(crate) async fn lock(&self) -> Result<(MutexGuard<'_, ()>, Arc<Snapshot>), Failure> {
        let guard = self.writing.lock().await;
        let snapshot = self.snapshot();
        if snapshot.is_removed() {
            Err(failure::no_such_robot(&self.id))
        } else {
            Ok((guard, snapshot))
        }
    }

    /// What happens to it.
    pub(crate) fn ring(&self) -> &Arc<Ring> {
        &self.ring
    }

    /// Whether its task runs. It ends when the robot is removed; a panic in it is the other way.
    pub(crate) fn is_alive(&self) -> bool {
        !self.queue.is_closed()
    }

    /// Answers a step of the robot's agent. A robot with too many of them waiting refuses: an answer that
    /// comes after the next one is of no use.
    pub(crate) async fn step(&self, request: Request, epoch: u64) -> Result<Arc<Reply>, Failure> {
        self.is_not_stuck()?;
        let (reply, answer) = oneshot::channel();
        let request = Box::new(request);
        match self.queue.try_send(Event::Step { request, epoch, reply }) {
            Ok(()) => {}
            Err(TrySendError::Closed(_)) => return Err(self.ended()),
            Err(TrySendError::Full(_)) => {
                let message = format!("robot {} has {QUEUE} requests waiting", self.id);
                let remedy = "send one request per slot";
                return Err(Failure::new(Status::ResourceExhausted, message).with(Detail::new(
                    reason::QUEUE_FULL,
                    "",
                    QUEUE,
                    remedy,
                )));
            }
        }
        Ok(self.unless_stuck(answer).await??)
    }

    /// Tells the robot something and waits until it shows. A full queue makes it wait its turn.
    pub(crate) async fn tell(&self, command: Command) -> Result<(), Failure> {
        let (done, answer) = oneshot::channel();
        let event = Event::Command { command, done };
        self.unless_stuck(self.queue.send(event)).await?;
        self.unless_stuck(answer).await
    }

    /// What the robot's task does, unless it has ended or its computation does not end.
    async fn unless_stuck<T, E>(
        &self,
        answer: impl Future<Output = Result<T, E>>,
    ) -> Result<T, Failure> {
        tokio::select! {
            biased;
            answer = answer => answer.map_err(|_| self.ended()),
            () = self.vitals.failed() => Err(self.stuck()),
        }
    }

    /// Waits until the server may shut down without the robot.
    pub(crate) async fn drained(&self) {
        // A robot whose task has ended is not waited for.
        let mut shown = self.snapshot.clone();
        let drained = async { shown.wait_for(|snapshot| snapshot.is_drained()).await.map(drop) };
        let _ = self.unless_stuck(drained).await;
    }

    /// Why its task does not answer now.
    fn stuck(&self) -> Failure {
        let message = format!("the computation of robot {} does not end", self.id);
        let remedy =
            "a stop holds all the same; restart the server, and please report what the log says";
        Failure::new(Status::Unavailable, message).with(Detail::new(
            reason::ROBOT_FAILED,
            "robot",
            self.id.as_str(),
            remedy,
        ))
    }

    /// Why its task does not answer.
    pub(crate) fn ended(&self) -> Failure {
        if self.snapshot.borrow().is_removed() {
            return failure::no_such_robot(&self.id);
        }
        tracing::error!(robot = %self.id, "robot task died");
        failure::internal(format!("the task of robot {} has died", self.id)).with(Detail::new(
            reason::TASK_DIED,
            "robot",
            self.id.as_str(),
            "describe it anew: PUT /v1/robots/{robot}; please report what the log says",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::feed::Feed;
    use crate::library::priors::Priors;
    use crate::store::{Posterior, Told};
    use std::time::Duration;
    use umwelt_core::settings::Settings;
    use umwelt_core::task::Task;
    use umwelt_core::time::RobotTime;

    impl Robot {
        /// Lets its task compute.
        pub(crate) fn compute(&self, computation: impl FnOnce() + Send + 'static) {
            let command = Command::Compute(command::Computation(Box::new(computation)));
            let (done, _) = oneshot::channel();
            assert!(self.queue.try_send(Event::Command { command, done }).is_ok());
        }

        /// A robot that was heard from and whose task has then died, as of a panic.
        pub(crate) async fn dead(id: &str) -> Self {
            let (robot, pilot, events) =
                Self::prepare(id.parse().unwrap(), record(), None, None, common());
            let task = tokio::spawn(pilot::run(pilot, events));
            robot.step(request(), 7).await.unwrap();
            task.abort();
            let _ = task.await;
            robot
        }
    }

    fn record() -> Record {
        let settings = Settings::default();
        Record { told: Told::all(settings), task: None, stopped: false, revision: 1 }
    }

    fn common() -> Common {
        let (feed, priors) = (Feed::new(), Priors::default());
        let workers = Workers::start().unwrap();
        Common { lost_after: Duration::from_secs(2), feed, priors, workers }
    }

    fn request() -> Request {
        Request {
            sequence: 1,
            connection: 0,
            sent: RobotTime::new(1.0),
            observations: Default::default(),
            deliveries: Default::default(),
            playing: None,
            limits: Default::default(),
        }
    }

    /// A robot that rests because the server ends was not stopped: someone who looks then and resumes it after the
    /// restart would look for a stop that no one made.
    #[tokio::test]
    async fn a_robot_that_is_drained_does_not_show_as_stopped() {
        let robot = Robot::dead("r").await;
        let (_, snapshot) = tokio::sync::watch::channel(robot.snapshot().told(true).into());
        let robot = Robot { snapshot, ..robot };
        assert!(!robot.snapshot().is_stopped());
        robot.stop(Arrival(7));
        assert!(robot.snapshot().is_stopped());
        robot.resume(Arrival(8)).unwrap();
        assert!(!robot.snapshot().is_stopped());
    }

    /// Guards against: callers that wait for ever for a task that has gone, or see it drive on.
    #[tokio::test]
    async fn a_robot_whose_task_has_died_says_so_and_shows_as_lost() {
        let robot = Robot::dead("r").await;
        let died = |failure: Failure| format!("{failure:?}").contains(reason::TASK_DIED);
        assert!(died(robot.step(request(), 7).await.unwrap_err()));
        assert!(died(robot.tell(Command::Look).await.unwrap_err()));
        assert_eq!(robot.snapshot().state(), umwelt_api::robot::State::Lost);
        robot.drained().await;
    }
    /// Guards against: a change that is kept as something else than what the robot makes of it.
    #[tokio::test]
    async fn what_is_kept_of_a_change_is_what_the_robot_makes_of_it() {
        let robot = Robot::spawn("r".parse().unwrap(), record(), None, None, common());
        robot.step(request(), 7).await.unwrap();
        let drive = Settings { watchdog: 0.25, ..Settings::default() };
        let described = RobotChange::Told(Box::new(Told::all(drive)));
        let changes = [RobotChange::Task(Some(Task::thesis())), described, RobotChange::Task(None)];
        for (revision, change) in (2..).zip(changes) {
            let (kept, record) =
                (robot.snapshot().saved_after(&change), change.kept(robot.record(), revision));
            robot.tell(Command::Change { change: change.clone(), revision }).await.unwrap();
            assert_eq!(robot.snapshot().posterior(), Posterior { revision, saved: kept });
            assert_eq!(robot.record(), record, "{change:?}");
        }
    }
}
