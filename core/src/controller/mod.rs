//! One robot: observe, identify, predict, steer, limit by variance, command a horizon.
//!
//! [`Controller::step`] is the whole of it: a pure transition from state and request to state and horizon. The
//! state can be stored and restored; the same state and requests give the same horizons.

pub mod compensation;
mod heard;
mod news;
mod plan;
mod record;
mod saved;
pub mod settings;
pub mod task;
mod watching;

use crate::commands::Commands;
use crate::exchange::{Observation, Request};
use crate::geometry::elementary::least;
use crate::geometry::{Displacement, Point, Pose, WheelSpeeds};
use crate::horizon::{Horizon, MAX_WATCHDOG, SLOT};
use crate::identification::estimate::Environment;
use crate::identification::{Belief, ChannelBelief, Verdict, Window};
use crate::kinematics;
use crate::local::LocalLimits;
use crate::prediction::{Agents, ErrorModel, Pieces, Prediction};
use crate::watch::{Alarm, Watch};
use arrayvec::ArrayVec;
use compensation::{Compensation, Identified};
use heard::{Change, Heard};
pub use news::GROWTH;
use plan::{Phase, Phases, REST_SLOTS, Start};
use record::Record;
pub use saved::Saved;
use serde::{Deserialize, Serialize};
use settings::{Attribution, PredictorKind, Settings};
use task::{Limit, Progress, Stage, Task};

/// Version of the stored state; a state of another version is not taken up.
pub const STATE_VERSION: u32 = 3;

/// Consistent poses in a row that are believed again after one was set aside: a robot that was carried away.
pub const BELIEVED_AGAIN: u32 = 5;

/// A pose at most this old in s, beyond the loop delay, is fresh.
const FRESH: f64 = 0.15;

/// A gap between poses in s, beyond which a window of motion begins anew.
const MAX_GAP: f64 = 0.5;

/// A pause in s after which a phase is taken up again rather than gone on with.
const PAUSE: f64 = 1.0;

/// Times that differ by less than this part of a slot are the same slot boundary.
const SAME_SLOT: f64 = 1e-6;

/// Margin of a believable pose in m and rad, for what the known noise does not cover.
const MARGIN: (f64, f64) = (0.005, 0.1);

/// Something that happened in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A pose was set aside: the robot cannot have moved there.
    PoseSetAside {
        /// The pose.
        observation: Observation,
        /// Distance in m from where it was predicted.
        distance: f64,
    },
    /// Several consistent poses in a row are believed again.
    PosesBelievedAgain,
    /// The calibration is over; the task's time begins.
    CalibrationEnded,
    /// The robot was seen at rest at a waypoint.
    WaypointReached {
        /// Index of the waypoint.
        leg: usize,
    },
    /// The last waypoint was reached.
    Arrived,
    /// The watch found something.
    Found {
        /// What.
        alarm: Alarm,
        /// Whether the robot rests for it.
        rests: bool,
    },
    /// What the watch had found is over by itself.
    Over(Alarm),
}

/// The answer to one request.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// What the robot is to play.
    pub horizon: Horizon,
    /// What happened.
    pub events: Events,
}

/// What happens in one step.
pub type Events = ArrayVec<Event, 8>;

/// What is known of the robot's motion up to its last accepted pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Track {
    last: Observation,
    /// What the commands make the wheels do at that time, lag included.
    wheels: WheelSpeeds,
    window: Window,
    /// Smoothed time in s between poses.
    interval: f64,
}

/// Poses that are set aside for now: the last one and how many in a row agree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Doubt {
    last: Observation,
    count: u32,
}

/// The controller of one robot. Which decisions it takes otherwise than by what it has identified is its
/// [compensation](Compensation)'s to say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Controller<C = Identified> {
    version: u32,
    settings: Settings,
    /// Its state is not stored: a server's controller has none.
    #[serde(skip)]
    compensation: C,
    belief: Belief,
    commands: Commands,
    track: Option<Track>,
    doubt: Option<Doubt>,
    task: Option<Task>,
    phase: Phase,
    /// The phases of the plan in force, which is the newest horizon sent; empty where it holds no longer.
    phases: Phases,
    record: Record,
    stopped: bool,
    watch: Watch,
    /// What was believed while the robot was still seen to move as commanded: at least so long before the last look that
    /// found it so as a look looks back, and at that look or before.
    healthy: Option<[[ChannelBelief; 4]; 2]>,
    /// Robot time in s of the newer one; none for those of the beginning.
    healthy_at: Option<f64>,
    /// What limits the speed at the start of the newest horizon.
    limit: Option<Limit>,
    /// What the robot itself allows.
    #[serde(default)]
    heard: Heard,
}

impl Controller {
    /// A controller that has seen nothing yet.
    pub fn new(settings: Settings) -> Self {
        Self::with(settings, Identified)
    }
}

impl<C: Compensation> Controller<C> {
    /// A controller that has seen nothing yet and decides by `compensation`.
    pub fn with(settings: Settings, compensation: C) -> Self {
        Self {
            version: STATE_VERSION,
            compensation,
            belief: Belief::new(settings.method, &settings.prior, settings.drift),
            settings,
            commands: Commands::default(),
            track: None,
            doubt: None,
            task: None,
            phase: Phase::Idle,
            phases: Phases::new(),
            record: Record::default(),
            stopped: false,
            watch: Watch::default(),
            healthy: None,
            healthy_at: None,
            limit: None,
            heard: Heard::default(),
        }
    }

    /// Whether a stored state is of this version.
    pub fn is_current(&self) -> bool {
        self.version == STATE_VERSION
    }

    /// Answers one request: learns from its reports and poses, and plans the next horizon.
    pub fn step(&mut self, request: &Request) -> Output {
        let mut events = ArrayVec::new();
        let horizon = self.answer(request, &mut events).clone();
        Output { horizon, events }
    }

    /// [`Controller::step`] without copies of what is large: the horizon stays where it is remembered.
    pub fn answer(&mut self, request: &Request, events: &mut Events) -> &Horizon {
        self.learn(request);
        self.heed(request);
        for observation in &request.observations {
            self.observe(*observation, events);
        }
        self.watch_age(request.sent, events);
        self.command(request)
    }

    /// A request that was overtaken by a newer one: it teaches the link model and changes nothing else.
    /// Returns the newest horizon.
    pub fn late(&mut self, request: &Request) -> Option<Horizon> {
        for delivery in &request.deliveries {
            self.belief.link.update(delivery);
            self.compensation.learn(delivery);
        }
        self.newest().cloned()
    }

    /// The newest horizon sent.
    pub fn newest(&self) -> Option<&Horizon> {
        self.commands.newest()
    }

    fn learn(&mut self, request: &Request) {
        self.belief.link.request(request.sequence, request.observations.last());
        for delivery in &request.deliveries {
            self.belief.link.update(delivery);
            self.compensation.learn(delivery);
        }
        if let Some(playing) = request.playing {
            self.commands.report(playing, request.sent);
        }
    }

    /// Takes in what the robot itself allows. Where it came to rest on its own, the plan begins anew from there, with a turn
    /// toward its waypoint; nothing is learned from what it did meanwhile ([`Heard::was_away`]).
    fn heed(&mut self, request: &Request) {
        let Settings { drive, attribution, .. } = self.settings;
        let change = self.heard.take(request, &drive);
        if change == Change::Rests {
            self.commands.interrupt(request.sequence, attribution, &drive, request.sent);
        }
        if change != Change::None {
            self.phase = self.phase.resumed();
            self.phases.clear();
        }
        if self.heard.was_away(request.sent, f64::INFINITY) {
            self.pause_watch();
        }
    }

    /// Takes in one pose: believes it or sets it aside, closes windows of motion, follows the task.
    fn observe(&mut self, observation: Observation, events: &mut Events) {
        let Some(track) = self.track else {
            self.compensation.begin(observation);
            self.track = Some(Track::new(observation, WheelSpeeds::ZERO));
            return;
        };
        if observation.taken <= track.last.taken {
            return;
        }
        let (window, moved, wheels) = self.nominal(&track, observation.taken);
        let predicted = track.last.pose.then(moved);
        let span = observation.taken - track.last.taken;
        if !self.can_have_moved(predicted, observation.pose, span) {
            self.belief.poses_set_aside += 1;
            self.watch_set_aside(observation.taken, events);
            let again = self.doubt.filter(|doubt| {
                let span = observation.taken - doubt.last.taken;
                self.can_have_moved(doubt.last.pose, observation.pose, span)
            });
            let count = again.map_or(1, |doubt| doubt.count + 1);
            if count < BELIEVED_AGAIN {
                self.doubt = Some(Doubt { last: observation, count });
                let distance = predicted.point().distance(observation.pose.point());
                let _ = events.try_push(Event::PoseSetAside { observation, distance });
                return;
            }
            let _ = events.try_push(Event::PosesBelievedAgain);
            self.watch_anew();
            self.compensation.begin(observation);
            self.track =
                Some(Track { interval: track.interval, ..Track::new(observation, wheels) });
        } else {
            let window = self.close(window, &track, &observation);
            let interval = track.interval + 0.2 * (span.min(MAX_GAP) - track.interval);
            let Observation { pose, taken } = observation;
            let pose = self.compensation.believe(taken, pose, predicted, moved);
            self.track =
                Some(Track { last: Observation { pose, taken }, wheels, window, interval });
            self.watch_step(track.last, observation, predicted, moved, events);
        }
        self.doubt = None;
        self.commands.settle(observation.taken - self.settings.drive.dead_time);
        self.follow_task(&observation, events);
    }

    /// The motion that the commands alone make from the last pose to `until`: added to the window, as one
    /// displacement, and what the wheels do at its end.
    fn nominal(&self, track: &Track, until: f64) -> (Window, Displacement, WheelSpeeds) {
        let drive = &self.settings.drive;
        let (mut window, mut moved, mut wheels) = (track.window, None, track.wheels);
        self.walk(track.last.taken, until, |speeds, duration| {
            let (end, twist) = kinematics::travel(drive, wheels, speeds, duration);
            let piece = window.add(self.watch.floors().moving(twist), duration);
            moved = Some(moved.map_or(piece, |moved: Displacement| moved.then(piece)));
            wheels = end;
        });
        (window, moved.unwrap_or_default(), wheels)
    }

    /// The commands that act on the robot from `from` to `until`: dead time after they come into force.
    fn walk(&self, from: f64, until: f64, each: impl FnMut(WheelSpeeds, f64)) {
        let Settings { drive, attribution, .. } = &self.settings;
        self.commands.walk(
            *attribution,
            drive,
            from - drive.dead_time,
            until - drive.dead_time,
            each,
        );
    }

    /// How far from where it was predicted a robot can be after `span` s, in m and rad.
    fn reach(&self, span: f64) -> (f64, f64) {
        let Settings { drive, noise, .. } = &self.settings;
        let far = 2.0 * drive.max_linear * span + 6.0 * noise.position + MARGIN.0;
        let turned = 2.0 * drive.max_angular * span + 6.0 * noise.heading + MARGIN.1;
        (far, turned)
    }

    /// Whether a robot can be at `pose` where `expected` was predicted over `span` s.
    fn can_have_moved(&self, expected: Pose, pose: Pose, span: f64) -> bool {
        let (far, turned) = self.reach(span);
        expected.point().distance(pose.point()) <= far
            && expected.heading.minus(pose.heading).abs() <= turned
    }

    /// Closes the window with a pose where it is ripe; the window that goes on.
    fn close(&mut self, window: Window, track: &Track, end: &Observation) -> Window {
        let Settings { drive, noise, attribution, .. } = self.settings;
        let start = window.start.taken;
        if self.heard.was_away(start, end.taken) {
            return Window::new(*end);
        }
        if end.taken - track.last.taken > MAX_GAP {
            return Window::new(*end);
        }
        if attribution == Attribution::Played
            && !self.commands.is_known(&drive, start - drive.dead_time, end.taken - drive.dead_time)
        {
            return Window::new(*end);
        }
        match window.verdict(&drive, noise, end) {
            Verdict::Open => return window,
            Verdict::Rest => {}
            Verdict::Rejected => self.belief.windows_rejected += 1,
            // A robot that rests for the watch teaches nothing on its way there.
            Verdict::Closed(_) if self.watch.rests() => {}
            Verdict::Closed(samples) => {
                self.compensation.witness(&self.belief, &samples, start);
                self.belief.update(&samples, start, end.taken);
            }
        }
        Window::new(*end)
    }

    /// Follows the task as observed.
    fn follow_task(&mut self, observation: &Observation, events: &mut Events) {
        let Some(task) = &self.task else { return };
        let here = observation.pose.point();
        let phase = if self.phase == Phase::Settling {
            let is_settled = self.was_at_rest(observation.taken);
            is_settled.then(|| self.record.begin(task, here, events))
        } else {
            let target = self.record.target(task);
            let is_near = target.is_some_and(|target| here.distance(target) <= task.tolerance);
            let is_there = is_near && self.was_at_rest(observation.taken);
            self.record.observe(task, observation, is_there, events)
        };
        if let Some(phase) = phase {
            self.phase = phase;
            self.phases.clear();
        }
    }

    /// Whether zero was played for three slots before `time`, by the robot's reports where there are any.
    fn was_at_rest(&self, time: f64) -> bool {
        let drive = &self.settings.drive;
        (0..REST_SLOTS).all(|slot| {
            let then = time - drive.dead_time - f64::from(slot) * self.settings.slot;
            self.commands.at(Attribution::Played, drive, then) == WheelSpeeds::ZERO
        })
    }

    /// Plans the horizon that answers `request`.
    fn command(&mut self, request: &Request) -> &Horizon {
        let Settings { drive, slot, watchdog, attribution, .. } = self.settings;
        // The robot holds no longer, whatever it was described with: what was driven is to be known.
        let watchdog = least(watchdog, MAX_WATCHDOG);
        let loop_delay = self.compensation.loop_delay(&self.settings);
        let newest = self.commands.newest().map_or(f64::NEG_INFINITY, |newest| newest.start);
        let soonest = (request.sent + slot).max(newest);
        let Some(track) = self.track else {
            let horizon = self.commands.begin(request.sequence, soonest, slot, watchdog);
            horizon.speeds.push(WheelSpeeds::ZERO);
            return horizon;
        };
        let taken = track.last.taken;
        let begins = soonest.max(taken + loop_delay);
        let since_change = self.enter_phase(newest, begins);

        let model = self.compensation.model(&self.belief, track.last.pose);
        let (prediction, wheels) = self.predict(&track, &model, begins, request.sequence);
        let before = self.commands.at(attribution, &drive, begins - 1e-6);
        let age = request.sent - taken;
        let start = Start {
            time: begins,
            since_change,
            wheels,
            previous: kinematics::forward(&drive, before),
            phase: self.phase,
            fresh: age <= loop_delay + FRESH,
            stopped: self.stopped
                || self.watch.rests()
                || self.heard.is_held()
                || begins - taken > self.compensation.patience(&self.settings),
            rest: f64::from(REST_SLOTS) * slot + track.interval,
        };
        let horizon = self.commands.begin(request.sequence, begins, slot, watchdog);
        let (speeds, phases) = (&mut horizon.speeds, &mut self.phases);
        let task = self.task.as_ref();
        let slowed = self.heard.slowed(&drive).map(|drive| Settings { drive, ..self.settings });
        let settings = slowed.as_ref().unwrap_or(&self.settings);
        let compensation = &self.compensation;
        let rules = plan::Rules { settings, compensation, floors: self.watch.floors() };
        let limit = plan::plan(rules, &model, task, start, prediction, speeds, phases);
        self.limit = if self.watch.rests() {
            Some(Limit::Watch)
        } else if self.heard.is_held() || (slowed.is_some() && limit == Some(Limit::Drive)) {
            Some(Limit::Hold)
        } else {
            limit
        };
        horizon
    }

    /// The phase at the start of the new horizon: what the old plan had come to by then. Returns the time in s since
    /// the old plan's last change of command.
    fn enter_phase(&mut self, old_start: f64, start: f64) -> f64 {
        let slot = self.settings.slot;
        let phases = &self.phases;
        if phases.is_empty() {
            self.record.pass(self.phase, start);
            return slot;
        }
        // Poses need not come once per slot: a plan may begin within a slot of the old one, whose decision then stands
        // already, or after many, and with them perhaps several phases, after a stall.
        let slots = ((start - old_start) / slot).max(0.0);
        let index = (slots + SAME_SLOT) as usize;
        let whole = index as f64;
        let within = (slots - whole).max(0.0);
        let is_within = within > SAME_SLOT;
        let last = phases.len() - 1;
        let index = index.saturating_add(usize::from(is_within)).min(last);
        for (index, phase) in phases.iter().enumerate().take(index + 1) {
            self.record.pass(*phase, old_start + index as f64 * slot);
        }
        self.phase = phases[index];
        if start - old_start > slot * last as f64 + PAUSE {
            self.phase = self.phase.resumed();
        }
        if is_within && whole < last as f64 { within * slot } else { slot }
    }

    /// The pose at the start of the horizon, and what the wheels do then.
    fn predict(
        &self,
        track: &Track,
        model: &ErrorModel,
        start: f64,
        sequence: u64,
    ) -> (Prediction, WheelSpeeds) {
        let Settings { drive, noise, predictor, .. } = &self.settings;
        let pose = track.last.pose;
        let (mut prediction, mut pieces) = match *predictor {
            PredictorKind::Moments => (Prediction::moments(pose, *noise), Pieces::gathered()),
            PredictorKind::MonteCarlo { agents, cell, seed } => {
                let agents = Agents::new(pose, *noise, model, agents, cell, seed ^ sequence);
                (Prediction::MonteCarlo(agents), Pieces::apart())
            }
        };
        let mut wheels = track.wheels;
        // Commands act a dead time after they come into force, those of the horizon too.
        self.walk(track.last.taken, start + drive.dead_time, |speeds, duration| {
            let (end, twist) = kinematics::travel(drive, wheels, speeds, duration);
            if let Some(motion) = pieces.add(self.watch.floors().moving(twist), duration) {
                prediction.advance(model, motion);
            }
            wheels = end;
        });
        if let Some(motion) = pieces.rest() {
            prediction.advance(model, motion);
        }
        let taken = track.last.taken;
        let prediction = self.compensation.predict(&self.settings, taken, pose, start, prediction);
        (prediction, wheels)
    }

    /// Sets a task, which replaces the one there is; it begins at the next step. At least one waypoint.
    pub fn set_task(&mut self, task: Task) {
        self.phase = if task.waypoints.is_empty() { Phase::Idle } else { Phase::first(&task) };
        self.phases.clear();
        self.record = Record::default();
        self.watch.resume();
        self.limit = None;
        self.task = Some(task);
    }

    /// Drops the task; the robot ramps to rest.
    pub fn cancel_task(&mut self) {
        self.task = None;
        self.phase = Phase::Idle;
        self.phases.clear();
        self.record = Record::default();
        self.watch.resume();
        self.limit = None;
    }

    /// Rest until [`Controller::resume`]; the task is kept.
    pub fn stop(&mut self) {
        self.stopped = true;
    }

    /// Goes on after [`Controller::stop`], or after the watch has brought the robot to rest.
    pub fn resume(&mut self) {
        self.stopped = false;
        self.watch.resume();
    }

    /// Whether the robot has been told to stop.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Whether the robot itself holds: it rests whatever it is told.
    pub fn is_held(&self) -> bool {
        self.heard.is_held()
    }

    /// What the robot itself allows, as it said last.
    pub fn local_limits(&self) -> LocalLimits {
        self.heard.limits()
    }

    /// The robot's clock counts anew (a new epoch): times are forgotten, what was learned and the task stay.
    pub fn restart_clock(&mut self) {
        self.commands.clear();
        self.belief.link.restart_clock();
        self.track = None;
        self.doubt = None;
        self.phases.clear();
        self.phase = self.phase.resumed();
        self.record.restart_clock();
        self.watch.restart_clock();
        self.heard = Heard::default();
        (self.healthy, self.healthy_at, self.limit) = (None, None, None);
    }

    /// Back to the prior.
    pub fn reset_environment(&mut self) {
        self.belief.reset();
        self.watch.unlearn();
        self.healthy = None;
    }

    /// New settings. The task is kept; what was learned is kept unless method, prior or channels changed.
    pub fn replace_settings(&mut self, settings: Settings) {
        let old = &self.settings;
        let relearn =
            (old.method, old.prior, old.drift) != (settings.method, settings.prior, settings.drift);
        if relearn {
            self.belief = Belief::new(settings.method, &settings.prior, settings.drift);
        }
        if relearn || old.drive != settings.drive {
            self.watch.unlearn();
            self.healthy = None;
        }
        self.settings = settings;
        self.limit = None;
        self.phases.clear();
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The task.
    pub fn task(&self) -> Option<&Task> {
        self.task.as_ref()
    }

    /// The segment of the current leg, once the task has begun and until it is done.
    pub fn leg(&self) -> Option<(Point, Point)> {
        self.record.leg(self.task.as_ref()?)
    }

    /// How far the task has got.
    pub fn progress(&self) -> Progress {
        let legs = self.task.as_ref().map_or(0, |task| task.waypoints.len());
        let stage = if legs == 0 { Stage::Idle } else { self.phase.stage() };
        Progress {
            limited_by: self.limit,
            watch: self.watch.state().map(|(alarm, _)| alarm.condition()),
            ..self.record.progress(stage, legs)
        }
    }

    /// Whether the task is done: the stage of [`Controller::progress`] without the rest.
    pub fn has_arrived(&self) -> bool {
        self.task.is_some() && self.phase == Phase::Arrived
    }

    /// The identified environment.
    pub fn environment(&self) -> Environment {
        self.belief.environment()
    }

    /// What is believed, for those who measure it.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// What it decides by.
    pub fn compensation(&self) -> &C {
        &self.compensation
    }

    /// The last accepted pose.
    pub fn pose(&self) -> Option<Observation> {
        self.track.map(|track| track.last)
    }
}

impl Track {
    fn new(observation: Observation, wheels: WheelSpeeds) -> Self {
        Self { last: observation, wheels, window: Window::new(observation), interval: SLOT }
    }
}

#[cfg(test)]
mod tests;
