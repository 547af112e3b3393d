//! What a robot's tokio task owns: its controller, its session, and what it shows.
//!
//! [`run`] waits, [`Pilot::apply`] changes state; neither does the other's work.

use super::brake::Brake;
use super::change::RobotChange;
use super::clock::RobotClock;
#[cfg(test)]
use super::command::Computation;
use super::command::{Command, Event, StepResult};
use super::common::Common;
use super::happening::kind;
use super::log;
use super::session::{Session, Verdict};
use super::snapshot::{Assigned, Described, Snapshot};
use super::stop_order::Arrival;
use super::workers::{aside, end_of_turn};
use crate::fleet::feed::{Ring, What};
use crate::store::Record;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use umwelt_api::RobotId;
use umwelt_api::event::Kind;
use umwelt_api::robot::State;
use umwelt_api::step::{Horizon, Reply};
use umwelt_core::controller::{Controller, Saved};
use umwelt_core::exchange::Request;
use umwelt_core::geometry::WheelSpeeds;
use umwelt_core::horizon;
use umwelt_core::settings::{PredictorKind, Settings};
use umwelt_core::task::Task;

/// Poses and horizons are published at most this often: ten a second look smooth.
const MOTION_EVERY: Duration = Duration::from_millis(100);

/// The environment, and progress within a leg, are published at most this often: they change slowly.
const LEARNED_EVERY: Duration = Duration::from_secs(1);

/// One robot.
pub(super) struct Pilot {
    id: RobotId,
    controller: Controller,
    session: Session,
    clock: RobotClock,
    brake: Arc<Brake>,
    /// The last resume that the controller has heard of.
    resumed: Arrival,
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

/// Lets events happen to the robot until it is removed or no one holds its queue any more: one each time that its turn
/// comes, so that a robot with much to do does not hold up the others.
pub(super) async fn run(mut pilot: Pilot, mut queue: mpsc::Receiver<Event>) {
    while let Some(event) = queue.recv().await {
        let is_slow = pilot.is_slow();
        let apply = || pilot.apply(event, Instant::now());
        let flow = if is_slow { aside(apply) } else { apply() };
        if flow.is_break() {
            return;
        }
        end_of_turn().await;
    }
}

impl Pilot {
    pub(super) fn new(
        id: RobotId,
        record: Record,
        saved: Option<Saved>,
        common: Common,
        ring: Arc<Ring>,
        brake: Arc<Brake>,
    ) -> (Self, watch::Receiver<Arc<Snapshot>>) {
        let Record { told, task, revision, .. } = record;
        let order = brake.order();
        let assigned = task.clone().map(Assigned::new);
        let controller = controller(&id, told.settings, task, order.is_stopped(), saved);
        let described = Described::new(told, &common.priors);
        let shown = Snapshot::of(&controller, described, assigned, revision);
        let (snapshot, receiver) = watch::channel(Arc::new(shown.clone()));
        let pilot = Self {
            id,
            controller,
            session: Session::default(),
            clock: RobotClock::default(),
            brake,
            resumed: order.resumed(),
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

    /// Whether a step may take tens of milliseconds: 10 000 agents of the Monte-Carlo predictor take 90 ms.
    fn is_slow(&self) -> bool {
        matches!(self.controller.settings().predictor, PredictorKind::MonteCarlo { .. })
    }

    fn apply(&mut self, event: Event, now: Instant) -> ControlFlow<()> {
        self.follow_brake();
        match event {
            Event::Step { request, epoch, reply } => {
                let result = self.step(&request, epoch, now);
                self.show();
                // Whoever asked may have given up.
                let _ = reply.send(result);
            }
            Event::Command { command, done } => {
                let flow = self.handle_command(command);
                self.follow_brake();
                self.show();
                let _ = done.send(());
                return flow;
            }
            Event::Silence => {
                let is_lost = self.shown.falls_silent(self.common.lost_after) <= Some(now);
                let is_lost = is_lost && self.shown.state == State::Connected;
                if is_lost {
                    self.shown.state = State::Lost;
                }
                self.show();
                if is_lost {
                    self.say(Kind::Link { state: State::Lost });
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Takes in what was said of stopping and going on since it looked last.
    fn follow_brake(&mut self) {
        let order = self.brake.order();
        if order.resumed() > self.resumed && !self.draining {
            self.resumed = order.resumed();
            // The brake says what it changes; that the watch lets the robot go is said here.
            if self.controller.watch_state().is_some() && !self.controller.is_stopped() {
                self.publish(Kind::Resumed);
            }
            self.controller.resume();
        }
        if order.is_stopped() || self.draining {
            self.controller.stop();
        }
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
                    log::taken_over(&self.id, epoch);
                }
                self.clock = RobotClock::beginning(request.sent);
                self.publish(Kind::Epoch { epoch });
                self.control(request, now)
            }
        };
        let stopped = self.controller.is_stopped();
        let stage = self.controller.progress().stage.into();
        let reply = Arc::new(Reply { horizon, stopped, stage, drive: None });
        self.session.answered(epoch, request, Arc::clone(&reply));
        Ok(reply)
    }

    fn hear(&mut self, now: Instant) {
        self.shown.seen = Some(now);
        if self.shown.state != State::Connected {
            self.shown.state = State::Connected;
            self.say(Kind::Link { state: State::Connected });
        }
    }

    /// The newest horizon for a request that was overtaken.
    fn late(&mut self, request: &Request) -> Horizon {
        let newest = self.controller.late(request);
        // What overtook it was answered, so there is a horizon; none would be said as rest, and be stale.
        let rest = || at_rest(&self.clock.request(request), self.controller.settings());
        let newest = newest.unwrap_or_else(rest);
        self.clock.horizon(&horizon::Horizon { answers: request.sequence, ..newest })
    }

    /// A new horizon, and what happened on the way to it.
    fn control(&mut self, request: &Request, now: Instant) -> Horizon {
        let (before, seen) = (self.controller.progress(), self.controller.pose());
        let was_held = self.controller.is_held();
        let request = self.clock.request(request);
        let output = self.controller.step(&request);
        let is_held = self.controller.is_held();
        if is_held != was_held {
            self.say(if is_held { Kind::Held } else { Kind::Released });
        }
        self.shown.drained |= self.draining;
        for event in output.events {
            self.say(kind(&event, &self.controller.progress(), self.clock));
        }
        if let Some(pose) = self.controller.pose().filter(|pose| Some(*pose) != seen) {
            let age = Duration::try_from_secs_f64(request.sent - pose.taken).unwrap_or_default();
            self.shown.pose_taken = now.checked_sub(age);
        }
        let horizon = self.clock.horizon(&output.horizon);
        let progress = self.controller.progress();
        let is_learned_due = self.learned.is_due(now);
        let has_turned = (before.stage, before.leg) != (progress.stage, progress.leg);
        if has_turned || (is_learned_due && before != progress) {
            self.publish(Kind::Task(progress.into()));
        }
        if is_learned_due {
            self.publish(self.environment());
        }
        if self.motion.is_due(now) {
            let pose = self.controller.pose();
            if let Some(pose) = pose.filter(|_| pose != seen) {
                self.publish(Kind::Pose(self.clock.observation(pose).into()));
            }
            self.publish(Kind::Horizon(horizon.clone()));
        }
        horizon
    }

    fn handle_command(&mut self, command: Command) -> ControlFlow<()> {
        match command {
            Command::Change { change, revision } => {
                change.apply(&mut self.controller);
                let said = match &change {
                    RobotChange::Told(_) => Kind::Registered,
                    RobotChange::Task(_) => Kind::Task(self.controller.progress().into()),
                };
                self.shown.change(change, revision, &self.common.priors);
                self.publish(said);
            }
            // Before each event and after it, it looks.
            Command::Look => {}
            Command::ResetEnvironment => self.controller.reset_belief(),
            Command::Drain => {
                self.draining = true;
                if !self.controller.is_stopped() {
                    self.publish(Kind::Stopped);
                }
            }
            #[cfg(test)]
            Command::Compute(Computation(compute)) => compute(),
            Command::Remove => {
                self.shown.removed = true;
                self.publish(Kind::Removed);
                self.ring.close();
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    /// Shows the robot as it is now.
    fn show(&mut self) {
        let shown = &mut self.shown;
        shown.progress = self.controller.progress();
        let report = self.controller.report();
        if let Some(report) = report.filter(|_| shown.report.is_none()) {
            log::checked(&self.id, report);
        }
        shown.report = report.cloned();
        let square = self.controller.square_report();
        if let Some(square) = square.filter(|_| shown.square.is_none()) {
            log::calibrated(&self.id, square);
        }
        shown.square = square.cloned();
        shown.watch(self.controller.watch_state());
        shown.stopped = self.controller.is_stopped();
        shown.limits = self.controller.local_limits();
        shown.held = self.controller.is_held();
        shown.epoch = self.session.epoch();
        // A takeover forgets the pose with the clock; the last one known stays on show.
        let pose = self.controller.pose().map(|pose| self.clock.observation(pose));
        shown.pose = pose.or(shown.pose);
        shown.saved = self.controller.saved();
        self.snapshot.send_replace(Arc::new(shown.clone()));
    }

    /// Publishes a change of the robot's own, and says it in the log.
    fn say(&self, kind: Kind) {
        log::change(&self.id, &kind);
        self.publish(kind);
    }

    fn publish(&self, what: impl Into<What>) {
        self.common.feed.publish(&self.ring, &self.id, what);
    }

    /// What is identified now, made from the belief when someone wants to see it.
    fn environment(&self) -> What {
        let (described, saved) = (self.shown.described.clone(), self.controller.saved());
        What::Asked(Box::new(move || Kind::Environment(Box::new(described.environment(&saved)))))
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
                tracing::warn!(robot = %id, "robot learns anew: what it learned is of other settings")
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
