//! What a robot's tokio task owns: its controller, its session, and what it shows.
//!
//! [`run`] waits, [`Pilot::apply`] changes state; neither does the other's work.

use super::Common;
use super::session::{Refusal, Session, Verdict};
use super::snapshot::{Assigned, Described, Snapshot};
use crate::feed::Ring;
use crate::store::Record;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::{Handle, RuntimeFlavor};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::Instant;
use umwelt_api::RobotId;
use umwelt_api::event::Kind;
use umwelt_api::robot::State;
use umwelt_api::step::{Horizon, Reply};
use umwelt_core::controller::settings::{PredictorKind, Settings};
use umwelt_core::controller::task::{Progress, Task};
use umwelt_core::controller::{self, Controller, Saved};
use umwelt_core::exchange::Request;
use umwelt_core::geometry::WheelSpeeds;
use umwelt_core::horizon;

/// Poses and horizons are published at most this often: ten a second look smooth.
const MOTION_EVERY: Duration = Duration::from_millis(100);

/// The environment, and progress within a leg, are published at most this often: they change slowly.
const LEARNED_EVERY: Duration = Duration::from_secs(1);

/// The answer to a step.
pub(crate) type StepResult = Result<Arc<Reply>, Refusal>;

/// What may happen to a robot.
#[derive(Debug)]
pub(crate) enum Event {
    /// Its agent sent a step.
    Step { request: Box<Request>, epoch: u64, reply: oneshot::Sender<StepResult> },
    /// Somebody told it something; `done` once it shows.
    Command { command: Command, done: oneshot::Sender<()> },
    /// It has been silent for too long.
    Silence,
}

/// What a robot may be told.
#[derive(Debug)]
pub(crate) enum Command {
    /// New settings; `prior` is the name of the prior in them.
    Replace { settings: Box<Settings>, prior: Option<String>, revision: u64 },
    /// A task in place of the one before, or none any more.
    ChangeTask { task: Option<Task>, revision: u64 },
    /// Rest until resumed.
    Stop,
    /// Go on.
    Resume,
    /// Forget what was learned.
    ResetEnvironment,
    /// Rest: the server shuts down.
    Drain,
    /// End.
    Remove,
}

/// One robot.
pub(super) struct Pilot {
    id: RobotId,
    controller: Controller,
    session: Session,
    /// The state as it is shown, kept up to date by [`Pilot::show`].
    shown: Snapshot,
    snapshot: watch::Sender<Arc<Snapshot>>,
    common: Common,
    draining: bool,
    ring: Arc<Ring>,
    motion: Pace,
    learned: Pace,
}

/// Lets through at most one per interval.
#[derive(Debug)]
struct Pace {
    every: Duration,
    last: Option<Instant>,
}

impl Pace {
    fn new(every: Duration) -> Self {
        Self { every, last: None }
    }

    fn is_due(&mut self, now: Instant) -> bool {
        let is_due = self.last.is_none_or(|last| now.duration_since(last) >= self.every);
        if is_due {
            self.last = Some(now);
        }
        is_due
    }
}

/// Lets events happen to the robot until it is removed or nobody holds its queue any more.
pub(super) async fn run(mut pilot: Pilot, mut queue: mpsc::Receiver<Event>) {
    loop {
        let (silence, is_slow) = (pilot.silence(), pilot.is_slow());
        let event = tokio::select! {
            biased;
            event = queue.recv() => match event {
                Some(event) => event,
                None => return,
            },
            () = until(silence) => Event::Silence,
        };
        let apply = || pilot.apply(event, Instant::now());
        let flow = if is_slow { aside(apply) } else { apply() };
        if flow.is_break() {
            return;
        }
    }
}

/// Does what may take tens of milliseconds without holding up the tasks that share the thread.
fn aside<T>(work: impl FnOnce() -> T) -> T {
    match Handle::current().runtime_flavor() {
        RuntimeFlavor::MultiThread => tokio::task::block_in_place(work),
        // There is one thread, and nothing to step aside to.
        _ => work(),
    }
}

async fn until(time: Option<Instant>) {
    match time {
        Some(time) => tokio::time::sleep_until(time).await,
        None => std::future::pending().await,
    }
}

impl Pilot {
    pub(super) fn new(
        id: RobotId,
        record: Record,
        saved: Option<Saved>,
        common: Common,
        ring: Arc<Ring>,
    ) -> (Self, watch::Receiver<Arc<Snapshot>>) {
        let Record { settings, prior, task, stopped, revision } = record;
        let assigned = task.clone().map(Assigned::new);
        let controller = controller(&id, settings, task, stopped, saved);
        let described = Described::new(settings, prior, &common.priors);
        let shown = Snapshot::of(&controller, described, assigned, revision);
        let (snapshot, receiver) = watch::channel(Arc::new(shown.clone()));
        let pilot = Self {
            id,
            controller,
            session: Session::default(),
            shown,
            snapshot,
            common,
            draining: false,
            ring,
            motion: Pace::new(MOTION_EVERY),
            learned: Pace::new(LEARNED_EVERY),
        };
        pilot.publish(Kind::Registered);
        (pilot, receiver)
    }

    /// When the robot counts as lost if nothing comes before.
    fn silence(&self) -> Option<Instant> {
        let is_connected = self.shown.state == State::Connected;
        self.shown.seen.filter(|_| is_connected).map(|seen| seen + self.common.lost_after)
    }

    /// Whether a step may take tens of milliseconds: 10 000 agents of the Monte-Carlo predictor take 90 ms.
    fn is_slow(&self) -> bool {
        matches!(self.controller.settings().predictor, PredictorKind::MonteCarlo { .. })
    }

    fn apply(&mut self, event: Event, now: Instant) -> ControlFlow<()> {
        match event {
            Event::Step { request, epoch, reply } => {
                let result = self.step(&request, epoch, now);
                self.show();
                // Whoever asked may have given up.
                let _ = reply.send(result);
            }
            Event::Command { command, done } => {
                let flow = self.obey(command);
                self.show();
                let _ = done.send(());
                return flow;
            }
            Event::Silence => {
                self.shown.state = State::Lost;
                self.show();
                self.publish(Kind::Link { state: State::Lost });
            }
        }
        ControlFlow::Continue(())
    }

    fn step(&mut self, request: &Request, epoch: u64, now: Instant) -> StepResult {
        let verdict = self.session.judge(epoch, request)?;
        self.hear(now);
        let horizon = match verdict {
            Verdict::Repeat(reply) => return Ok(reply),
            Verdict::Late => self.late(request),
            Verdict::Newest => self.control(request, now),
            Verdict::First | Verdict::Takeover => {
                if verdict == Verdict::Takeover {
                    self.controller.restart_clock();
                }
                self.publish(Kind::Epoch { epoch });
                self.control(request, now)
            }
        };
        let stopped = self.controller.is_stopped();
        let reply = Reply { horizon, stopped, stage: self.controller.progress().stage.into() };
        let reply = Arc::new(reply);
        self.session.answered(epoch, request, Arc::clone(&reply));
        Ok(reply)
    }

    fn hear(&mut self, now: Instant) {
        self.shown.seen = Some(now);
        if self.shown.state != State::Connected {
            self.shown.state = State::Connected;
            self.publish(Kind::Link { state: State::Connected });
        }
    }

    /// The newest horizon for a request that was overtaken.
    fn late(&mut self, request: &Request) -> Horizon {
        let newest = self.controller.late(request);
        // What overtook it was answered, so there is a horizon; none would be said as rest, and be stale.
        let newest = newest.unwrap_or_else(|| at_rest(request, self.controller.settings()));
        Horizon::from(&horizon::Horizon { answers: request.sequence, ..newest })
    }

    /// A new horizon, and what happened on the way to it.
    fn control(&mut self, request: &Request, now: Instant) -> Horizon {
        let (before, seen) = (self.controller.progress(), self.controller.pose());
        let was_held = self.controller.is_held();
        let output = self.controller.step(request);
        let is_held = self.controller.is_held();
        if is_held != was_held {
            self.publish(if is_held { Kind::Held } else { Kind::Released });
        }
        self.shown.drained |= self.draining;
        for event in output.events {
            self.publish(kind(&event, &self.controller.progress()));
        }
        let horizon = Horizon::from(&output.horizon);
        let progress = self.controller.progress();
        let is_learned_due = self.learned.is_due(now);
        let has_turned = (before.stage, before.leg) != (progress.stage, progress.leg);
        if has_turned || (is_learned_due && before != progress) {
            self.publish(Kind::Task(progress.into()));
        }
        if is_learned_due {
            let environment = self.shown.described.environment(&self.controller.environment());
            self.publish(Kind::Environment(Box::new(environment)));
        }
        if self.motion.is_due(now) {
            let pose = self.controller.pose();
            if let Some(pose) = pose.filter(|_| pose != seen) {
                self.publish(Kind::Pose(pose.into()));
            }
            self.publish(Kind::Horizon(horizon.clone()));
        }
        horizon
    }

    fn obey(&mut self, command: Command) -> ControlFlow<()> {
        match command {
            Command::Replace { settings, prior, revision } => {
                self.controller.replace_settings(*settings);
                self.shown.described = Described::new(*settings, prior, &self.common.priors);
                self.shown.revision = revision;
                self.publish(Kind::Registered);
            }
            Command::ChangeTask { task, revision } => {
                self.shown.assigned = task.clone().map(Assigned::new);
                self.shown.revision = revision;
                match task {
                    Some(task) => self.controller.set_task(task),
                    None => self.controller.cancel_task(),
                }
                self.publish(Kind::Task(self.controller.progress().into()));
            }
            Command::Stop => self.stop(),
            Command::Resume => {
                if self.controller.is_stopped() && !self.draining {
                    self.controller.resume();
                    self.publish(Kind::Resumed);
                }
            }
            Command::ResetEnvironment => self.controller.reset_environment(),
            Command::Drain => {
                self.draining = true;
                self.stop();
            }
            Command::Remove => {
                self.shown.removed = true;
                self.publish(Kind::Removed);
                self.ring.close();
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    fn stop(&mut self) {
        if !self.controller.is_stopped() {
            self.controller.stop();
            self.publish(Kind::Stopped);
        }
    }

    /// Shows the robot as it is now.
    fn show(&mut self) {
        let shown = &mut self.shown;
        shown.progress = self.controller.progress();
        shown.stopped = self.controller.is_stopped();
        shown.limits = self.controller.local_limits();
        shown.held = self.controller.is_held();
        shown.epoch = self.session.epoch();
        // A takeover forgets the pose with the clock; the last one known stays on show.
        shown.pose = self.controller.pose().or(shown.pose);
        shown.saved = self.controller.saved();
        self.snapshot.send_replace(Arc::new(shown.clone()));
    }

    fn publish(&self, kind: Kind) {
        self.common.feed.publish(&self.ring, &self.id, kind);
    }
}

/// The controller of a robot that goes on from what was `saved` of it; without that, or where that is of something
/// else, one that begins anew.
fn controller(
    id: &RobotId,
    settings: Settings,
    task: Option<Task>,
    stopped: bool,
    saved: Option<Saved>,
) -> Controller {
    if let Some(saved) = saved {
        match Controller::restore(settings, task.clone(), stopped, saved) {
            Some(controller) => return controller,
            None => {
                tracing::warn!(robot = %id, "what it learned is of other settings: it learns anew")
            }
        }
    }
    let mut controller = Controller::new(settings);
    if let Some(task) = task {
        controller.set_task(task);
    }
    if stopped {
        controller.stop();
    }
    controller
}

fn at_rest(request: &Request, settings: &Settings) -> horizon::Horizon {
    horizon::Horizon {
        sequence: request.sequence,
        answers: request.sequence,
        start: request.sent,
        slot: settings.slot,
        watchdog: settings.watchdog,
        speeds: std::iter::once(WheelSpeeds::ZERO).collect(),
    }
}

/// What the wire says of an event of the controller.
fn kind(event: &controller::Event, progress: &Progress) -> Kind {
    match *event {
        controller::Event::PoseSetAside { observation, .. } => {
            Kind::PoseSetAside(observation.into())
        }
        controller::Event::PosesBelievedAgain => Kind::PoseBelievedAgain,
        controller::Event::CalibrationEnded => Kind::CalibrationEnded,
        controller::Event::WaypointReached { leg } => Kind::WaypointReached { leg },
        controller::Event::Arrived => {
            Kind::Arrived { elapsed_s: progress.elapsed, max_deviation_m: progress.max_deviation }
        }
    }
}
