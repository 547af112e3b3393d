//! Waits for what happens and lets it happen.

use crate::clock::Clock;
use crate::drive::Drive;
use crate::epoch;
use crate::report::{AgentError, Ended, Report, Status, TraceRow, TraceSink};
use crate::robot::Robot;
use crate::told::Told;
use crate::transport::{Answer, Connect, Connections};
use std::fmt;
use std::ops::ControlFlow;
use std::pin::{Pin, pin};
use tokio::sync::watch;
use tokio::time::sleep_until;
use tracing::{Instrument, info, info_span};
use umwelt_client::api::RobotId;
use umwelt_core::geometry::WheelSpeeds;
use umwelt_core::horizon::SLOT;
use umwelt_core::link::{Link, LinkModel};

/// Everything that a run is told.
pub struct Config {
    /// The robot.
    pub robot: RobotId,
    /// What it was told of its drive beside what the server says; a difference ends the run.
    pub drive: Told,
    /// Random number of this run, at most 2^53 - 1. Two runs with the same one are one run to the server, so it is
    /// not derived from a seed.
    pub epoch: u64,
    /// A link whose delays are added to the real one's, both ways. Its sensor delay is the drive's business.
    pub link: Option<LinkModel>,
    /// Seed of that link.
    pub seed: u64,
    /// Time in s after which the run ends by itself.
    pub duration: Option<f64>,
    /// Where to show the robot at each moment.
    pub status: Option<watch::Sender<Status>>,
    /// Where to put the trace.
    pub trace: Option<TraceSink>,
}

impl Config {
    /// A run for `robot` with a random epoch, the drive that the server has, and nothing else.
    pub fn new(robot: RobotId) -> Self {
        Self {
            robot,
            drive: Told::default(),
            epoch: epoch::random(),
            link: None,
            seed: 0,
            duration: None,
            status: None,
            trace: None,
        }
    }
}

impl fmt::Debug for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robot, drive, epoch, link, seed, duration, .. } = self;
        f.debug_struct("Config")
            .field("robot", robot)
            .field("drive", drive)
            .field("epoch", epoch)
            .field("link", link)
            .field("seed", seed)
            .field("duration", duration)
            .finish_non_exhaustive()
    }
}

/// Drives the robot until `shutdown` or another end, and leaves it at rest.
///
/// Dropping the returned future instead leaves a real robot to its motors' own time-out.
///
/// # Errors
/// Where the run cannot go on: another agent took over, the server never knew the robot, the drive failed.
pub async fn run<D: Drive>(
    config: Config,
    connect: Connect,
    mut drive: D,
    clock: Clock,
    shutdown: impl Future<Output = ()> + Send,
) -> Result<Report, AgentError> {
    let Config { robot: id, epoch, link, seed, duration, status, trace, .. } = config;
    let link = link.map(|model| Link::new(model, seed)).transpose()?;
    let span = info_span!("robot", %id);
    let now = clock.now();
    drive.begin(now);
    let agent = Agent {
        clock,
        robot: Robot::new(id, config.drive, D::IS_HARDWARE, link, epoch, now),
        drive,
        connections: Connections::new(connect),
        until: duration.map_or(f64::INFINITY, |duration| now + duration),
        status,
        trace,
        shown: TraceRow { time: f64::NEG_INFINITY, pose: None, applied: WheelSpeeds::ZERO },
    };
    agent.run(pin!(shutdown)).instrument(span).await
}

/// What a wait ends with.
enum Event<I> {
    /// The time has come for something.
    Due,
    /// A request got its answer.
    Answer(Answer),
    /// Something came from the drive.
    Input(I),
    /// The run is to end.
    Shutdown,
}

struct Agent<D: Drive> {
    clock: Clock,
    robot: Robot,
    drive: D,
    connections: Connections,
    until: f64,
    status: Option<watch::Sender<Status>>,
    trace: Option<TraceSink>,
    /// The last row of the trace.
    shown: TraceRow,
}

impl<D: Drive> Agent<D> {
    async fn run(
        mut self,
        mut shutdown: Pin<&mut (impl Future<Output = ()> + Send)>,
    ) -> Result<Report, AgentError> {
        self.apply(self.clock.now(), Event::Due);
        let ended = loop {
            if let Some(ended) = self.robot.ended() {
                break ended.clone();
            }
            let event = self.select(shutdown.as_mut()).await;
            self.apply(self.clock.now(), event);
        };
        let now = self.clock.now();
        let finished = self.drive.finish(now).await;
        let ended = ended?;
        finished?;
        let state = self.robot.state();
        let report = Report {
            ended,
            time: now,
            requests: state.requests,
            replies: state.replies,
            connections: self.connections.opened(),
        };
        info!(requests = report.requests, replies = report.replies, "agent ended, robot at rest");
        Ok(report)
    }

    /// Waits, and changes nothing.
    async fn select(
        &mut self,
        shutdown: Pin<&mut (impl Future<Output = ()> + Send)>,
    ) -> Event<D::Input> {
        let due = self.next();
        tokio::select! {
            biased;
            () = shutdown, if !self.robot.is_ending() => Event::Shutdown,
            answer = self.connections.answer() => Event::Answer(answer),
            input = self.drive.input() => Event::Input(input),
            () = sleep_until(self.clock.instant(due)) => Event::Due,
        }
    }

    fn next(&self) -> f64 {
        let end = if self.robot.is_ending() { f64::INFINITY } else { self.until };
        self.robot.next(self.clock.now()).min(self.drive.next()).min(end)
    }

    /// Changes what there is to change, and never waits.
    fn apply(&mut self, now: f64, event: Event<D::Input>) {
        match event {
            Event::Due => {}
            Event::Answer(answer) => self.robot.answer(now, answer),
            Event::Input(input) => {
                if let ControlFlow::Break(()) = self.drive.take(now, input) {
                    self.robot.end(Ok(Ended::NoMorePoses));
                }
            }
            Event::Shutdown => self.robot.end(Ok(Ended::Shutdown)),
        }
        if now >= self.until {
            self.robot.end(Ok(Ended::Duration));
        }
        while let Some(observation) = self.drive.observe(now) {
            self.robot.observe(observation);
        }
        self.robot.restrain(now, self.drive.limits());
        let applied = self.robot.advance(now);
        if let Some(drive) = self.robot.described() {
            self.drive.describe(&drive);
        }
        if let Err(error) = self.drive.apply(now, applied) {
            self.robot.end(Err(error.into()));
        }
        self.connections.close_before(self.robot.oldest_connection());
        while let Some(post) = self.robot.post(now) {
            self.connections.post(post);
        }
        self.show(now, applied);
    }

    fn show(&mut self, now: f64, applied: WheelSpeeds) {
        let row = TraceRow { time: now, pose: self.drive.true_pose(), applied };
        if let Some(trace) = &mut self.trace
            && (applied != self.shown.applied || now >= self.shown.time + SLOT)
        {
            trace(&row);
            self.shown = row;
        }
        if let Some(status) = &self.status {
            let state = self.robot.state();
            status.send_replace(Status {
                time: now,
                pose: row.pose,
                observed: state.observed,
                applied,
                loop_delay: state.loop_delay,
                connected: self.robot.is_connected(),
                stage: state.stage,
                stopped: state.stopped,
                held: self.robot.is_held(),
            });
        }
    }
}
