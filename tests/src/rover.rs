//! An agent that says exactly what a test wants, and agents as they are.

use crate::process::SOON;
use crate::wait;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinHandle;
use umwelt_agent::drive::Sim;
use umwelt_agent::{AgentError, Clock, Config, Report, Status, TraceRow, run, transport};
use umwelt_api::RobotId;
use umwelt_api::step::{Observation, Request};
use umwelt_core::geometry::{Pose, Twist};
use umwelt_core::kinematics;
use umwelt_core::link::{LinkModel, SENSOR_DELAY};
use umwelt_core::plant::PlantModel;

/// The robot called `name`.
///
/// # Panics
/// Where that is no id.
pub fn id(name: &str) -> RobotId {
    name.parse().expect("an id")
}

/// What an agent sends for a robot that stands at the origin, at robot time `sent`.
pub fn request(epoch: u64, sequence: u64, sent: f64) -> Request {
    let taken_s = sent - SENSOR_DELAY;
    Request {
        sequence,
        epoch,
        sent_s: sent,
        observations: vec![Observation { x_m: 0.0, y_m: 0.0, heading_rad: 0.0, taken_s }],
        deliveries: Vec::new(),
        playing: None,
        hold: false,
        max_speed_m_per_s: None,
        drive_tag: None,
    }
}

/// A simulated robot and its link.
#[derive(Clone, Debug, Default)]
pub struct Simulated {
    /// What it is.
    pub plant: PlantModel,
    /// Where it stands.
    pub start: Pose,
    /// What its agent adds to the real link, both ways.
    pub link: Option<LinkModel>,
    /// Seed of all that is random about it.
    pub seed: u64,
}

/// A running agent in this process, with a simulated robot; the server is reached over sockets.
#[derive(Debug)]
pub struct Agent {
    status: watch::Receiver<Status>,
    rows: Arc<Mutex<Vec<TraceRow>>>,
    end: Option<oneshot::Sender<()>>,
    run: JoinHandle<Result<Report, AgentError>>,
}

impl Agent {
    /// Starts the agent of `robot` against the server at `url`.
    ///
    /// # Panics
    /// Where the robot means nothing.
    pub fn start(url: &str, robot: &RobotId, simulated: Simulated) -> Self {
        let Simulated { plant, start, link, seed } = simulated;
        let (shown, status) = watch::channel(Status::default());
        let (end, ended) = oneshot::channel::<()>();
        let rows = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&rows);
        let config = Config {
            link,
            seed,
            status: Some(shown),
            trace: Some(Box::new(move |row| {
                sink.lock().unwrap_or_else(PoisonError::into_inner).push(*row);
            })),
            ..Config::new(robot.clone())
        };
        let connect = transport::http(url, robot.clone()).expect("a server's address");
        let sim = Sim::new(plant, start, seed).expect("a plant that means something");
        let shutdown = async move {
            // An agent whose handle is gone goes on.
            if ended.await.is_err() {
                std::future::pending::<()>().await;
            }
        };
        let run = tokio::spawn(run(config, connect, sim, Clock::start(), shutdown));
        Self { status, rows, end: Some(end), run }
    }

    /// Waits until what the agent shows `holds`, and returns it.
    ///
    /// # Panics
    /// Where it does not `within` the time, or the agent has ended.
    pub async fn until(
        &mut self,
        what: &str,
        within: Duration,
        holds: impl FnMut(&Status) -> bool,
    ) -> Status {
        let shown = wait::within(what, within, self.status.wait_for(holds)).await;
        *shown.unwrap_or_else(|_| panic!("the agent has ended before: {what}"))
    }

    /// What it shows now.
    pub fn status(&self) -> Status {
        *self.status.borrow()
    }

    /// Tells the agent to end; returns its report and its trace.
    ///
    /// # Panics
    /// Where it does not end, or ends with an error.
    pub async fn end(mut self) -> (Report, Vec<TraceRow>) {
        if let Some(end) = self.end.take() {
            // It may have ended by itself.
            let _ = end.send(());
        }
        let (result, rows) = self.ended().await;
        (result.expect("the agent ends as it should"), rows)
    }

    /// Waits until the agent ends by itself; returns how, and its trace.
    ///
    /// # Panics
    /// Where it does not end.
    pub async fn ended(self) -> (Result<Report, AgentError>, Vec<TraceRow>) {
        let result = wait::within("the end of the agent", SOON, self.run).await;
        let rows = std::mem::take(&mut *self.rows.lock().unwrap_or_else(PoisonError::into_inner));
        (result.expect("the agent does not panic"), rows)
    }
}

/// The motion that is commanded, for a robot with the default drive.
pub fn applied(status: &Status) -> Twist {
    kinematics::forward(&kinematics::Drive::default(), status.applied)
}

/// Whether the robot drives at more than half of its speed.
pub fn drives(status: &Status) -> bool {
    let drive = kinematics::Drive::default();
    applied(status).linear > drive.max_linear / 2.0
}

/// Whether the robot is told to rest.
pub fn rests(status: &Status) -> bool {
    applied(status) == Twist::ZERO
}
