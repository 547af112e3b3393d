//! One robot: a tokio task that owns its controller, and the handle by which the rest of the server reaches it.

mod pilot;
mod session;
mod snapshot;

pub(crate) use pilot::Command;
pub(crate) use session::Refusal;
pub(crate) use snapshot::Snapshot;

use crate::failure::{self, Failure};
use crate::feed::{Feed, Ring};
use crate::priors::Priors;
use crate::store::Record;
use pilot::{Event, Pilot};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{Mutex, MutexGuard, mpsc, oneshot, watch};
use umwelt_api::RobotId;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::step::Reply;
use umwelt_core::controller::Saved;
use umwelt_core::exchange::Request;

/// Requests that may wait for a robot's task: all that an agent has in flight on its connections, and some more.
const QUEUE: usize = 16;

/// What the robots of a server have in common; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Common {
    /// Silence after which one counts as lost.
    pub(crate) lost_after: Duration,
    /// Where they say what happens.
    pub(crate) feed: Feed,
    /// What the names of their priors mean.
    pub(crate) priors: Priors,
}

/// The handle of a robot's task.
#[derive(Debug)]
pub(crate) struct Robot {
    id: RobotId,
    queue: mpsc::Sender<Event>,
    snapshot: watch::Receiver<Arc<Snapshot>>,
    ring: Arc<Ring>,
    /// Held by whoever changes what is stored about the robot, so that store and controller change in one order.
    pub(crate) writing: Mutex<()>,
}

impl Robot {
    /// Starts the task of a robot, which goes on from what was `saved` of it.
    pub(crate) fn spawn(id: RobotId, record: Record, saved: Option<Saved>, common: Common) -> Self {
        let ring = common.feed.ring();
        let (pilot, snapshot) = Pilot::new(id.clone(), record, saved, common, Arc::clone(&ring));
        let (queue, events) = mpsc::channel(QUEUE);
        tokio::spawn(pilot::run(pilot, events));
        Self { id, queue, snapshot, ring, writing: Mutex::default() }
    }

    /// Its id.
    pub(crate) fn id(&self) -> &RobotId {
        &self.id
    }

    /// As it is now. Never waits for the robot's task; one whose task has died is lost.
    pub(crate) fn snapshot(&self) -> Arc<Snapshot> {
        let snapshot = Arc::clone(&self.snapshot.borrow());
        if self.is_alive() { snapshot } else { Arc::new(snapshot.without_task()) }
    }

    /// Begins a change of what is kept of the robot: nobody else changes it until the guard is dropped. Returns the
    /// guard with the robot as it is now; a robot that was removed meanwhile cannot be changed.
    pub(crate) async fn change(&self) -> Result<(MutexGuard<'_, ()>, Arc<Snapshot>), Failure> {
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
        Ok(answer.await.map_err(|_| self.ended())??)
    }

    /// Tells the robot something and waits until it shows. A full queue makes it wait its turn.
    pub(crate) async fn tell(&self, command: Command) -> Result<(), Failure> {
        let (done, answer) = oneshot::channel();
        let event = Event::Command { command, done };
        self.queue.send(event).await.map_err(|_| self.ended())?;
        answer.await.map_err(|_| self.ended())
    }

    /// Waits until the server may shut down without the robot.
    pub(crate) async fn drained(&self) {
        // A robot whose task has ended is not waited for.
        let _ = self.snapshot.clone().wait_for(|snapshot| snapshot.is_drained()).await;
    }

    /// Why its task does not answer.
    fn ended(&self) -> Failure {
        if self.snapshot.borrow().is_removed() {
            return failure::no_such_robot(&self.id);
        }
        tracing::error!(robot = %self.id, "the robot's task has died");
        failure::internal(format!("the task of robot {} has died", self.id)).with(Detail::new(
            reason::TASK_DIED,
            "robot",
            self.id.as_str(),
            "describe it anew: PUT /v1/robots/{robot}; please report what the log says",
        ))
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Superseded { epoch } => {
                let remedy =
                    "another agent drives this robot now: stop one of them; a restart takes over";
                Self::new(Status::Aborted, "another agent has taken the robot over")
                    .with(Detail::new(reason::EPOCH_SUPERSEDED, "epoch", epoch, remedy))
            }
            Refusal::ClockWentBack { sent, newest } => {
                let message = format!("the robot's clock went back from {newest} s to {sent} s");
                let remedy = "begin a new epoch when the clock restarts";
                Self::new(Status::FailedPrecondition, message).with(Detail::new(
                    reason::CLOCK_WENT_BACK,
                    "sent_s",
                    sent,
                    remedy,
                ))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_core::controller::settings::Settings;
    use umwelt_core::exchange::Request;

    impl Robot {
        /// A robot that was heard from and whose task has then died, as of a panic.
        pub(crate) async fn dead(id: &str) -> Self {
            let record = Record {
                settings: Settings::default(),
                prior: None,
                task: None,
                stopped: false,
                revision: 1,
            };
            let (feed, priors) = (Feed::new(), Priors::default());
            let common = Common { lost_after: Duration::from_secs(2), feed, priors };
            let ring = common.feed.ring();
            let id: RobotId = id.parse().unwrap();
            let (pilot, snapshot) = Pilot::new(id.clone(), record, None, common, Arc::clone(&ring));
            let (queue, events) = mpsc::channel(QUEUE);
            let task = tokio::spawn(pilot::run(pilot, events));
            let robot = Self { id, queue, snapshot, ring, writing: Mutex::default() };
            robot.step(request(), 7).await.unwrap();
            task.abort();
            let _ = task.await;
            robot
        }
    }

    fn request() -> Request {
        Request {
            sequence: 1,
            connection: 0,
            sent: 1.0,
            observations: Default::default(),
            deliveries: Default::default(),
            playing: None,
            limits: Default::default(),
        }
    }

    /// The bug to fear: callers that wait for ever for a task that has gone, or see it drive on.
    #[tokio::test]
    async fn a_robot_whose_task_has_died_says_so_and_shows_as_lost() {
        let robot = Robot::dead("r").await;
        let died = |failure: Failure| format!("{failure:?}").contains(reason::TASK_DIED);
        assert!(died(robot.step(request(), 7).await.unwrap_err()));
        assert!(died(robot.tell(Command::Stop).await.unwrap_err()));
        assert_eq!(robot.snapshot().state(), umwelt_api::robot::State::Lost);
        robot.drained().await;
    }
}
