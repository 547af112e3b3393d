//! One robot: observe, identify, predict, steer, limit by variance, command a horizon.
//!
//! [`Controller::step`] is the whole of it: a pure transition from state and request to state and horizon. The
//! state can be saved and restored; the same state and requests give the same horizons.

mod acting;
mod checking;
pub mod compensation;
mod event;
mod follows;
mod fusing;
mod gathering;
mod heard;
mod news;
mod observing;
mod orders;
mod plan;
mod planning;
mod record;
mod saved;
mod squaring;
mod standing;
mod watching;

use crate::check::{Report, Trace};
use crate::commands::Commands;
use crate::exchange::{Observation, Request};
use crate::fusion::{Fusion, NoiseBelief};
use crate::geometry::{Displacement, Point, Pose, WheelSpeeds};
use crate::horizon::{Horizon, SLOT};
use crate::identification::estimate::Estimates;
use crate::identification::{Belief, ChannelBelief, SampleObserver, Window};
use crate::settings::Settings;
use crate::square;
use crate::task::{Limit, Progress, Task};
use crate::time::RobotTime;
use crate::watch::Watch;
pub use acting::MOST_CORRECTED;
use compensation::{
    Compensation, DelayModel, Identified, NominalDelay, PathFollower, PoseEstimator, QuadraticCurve,
};
pub use event::{Event, Events};
use follows::Follows;
use heard::{Change, Heard};
pub use news::GROWTH;
use plan::{Phase, Phases};
use record::Record;
pub use saved::Saved;
use std::borrow::Cow;
use std::sync::Arc;

/// Version of the stored form of [`Saved`]; one of another version is not taken up.
pub const STATE_VERSION: u32 = 3;

/// Consistent poses in a row that are accepted again after one was set aside: a robot that was carried away.
pub const ACCEPTED_AGAIN: u32 = 5;

/// The answer to one request.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// What the robot is to play.
    pub horizon: Horizon,
    /// What happened.
    pub events: Events,
}

/// What is known of the robot's motion up to its last accepted pose.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Track {
    /// Where it was then, and when.
    last: Observation,
    /// The last accepted pose as it was observed.
    seen: Observation,
    /// By the commands the robot has moved so far since.
    unseen: Displacement,
    /// What the commands make the wheels do at that time, lag included.
    wheels: WheelSpeeds,
    window: Window,
    /// Smoothed time in s between poses.
    interval: f64,
    /// The pose from which the robot was not seen to move since.
    still: Observation,
    /// When it began.
    began: RobotTime,
}

/// Poses that are set aside for now: the last one and how many in a row agree.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RejectedPoses {
    last: Observation,
    count: u32,
}

/// The controller of one robot: that of the thesis and of the server, or one whose [`Compensation`] decides otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller<E = Identified, D = NominalDelay, F = QuadraticCurve> {
    settings: Settings,
    /// The settings as they are over the link and with the drive as both are identified.
    acting: Settings,
    /// How late the drive follows; none where that is described.
    follows: Option<Follows>,
    /// When the first plan for the loop delay as it is known now begins; none before there is one.
    teaches_from: Option<RobotTime>,
    compensation: Compensation<E, D, F>,
    /// Whether the [watch](crate::watch) looks after the robot.
    is_watched: bool,
    belief: Belief,
    commands: Commands,
    track: Option<Track>,
    rejected: Option<RejectedPoses>,
    /// Where the robot is by all poses; none where they are taken as they are observed.
    fusion: Option<Fusion>,
    /// How noisy they are; none where that does not matter.
    noise: Option<Box<NoiseBelief>>,
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
    /// When the newer one was; none for those of the beginning.
    healthy_at: Option<RobotTime>,
    /// What limits the speed at the start of the newest horizon.
    limit: Option<Limit>,
    /// What the robot itself allows.
    heard: Heard,
    /// What was seen so far of a robot that is being checked.
    trace: Option<Box<Trace>>,
    /// What the last check came to.
    report: Option<Arc<Report>>,
    /// What was seen so far of a robot that drives a square.
    runs: Option<Box<square::Runs>>,
    /// What the last square came to.
    square_report: Option<Arc<square::Report>>,
}

impl Controller {
    /// A controller that has seen nothing yet.
    pub fn new(settings: Settings) -> Self {
        Self { is_watched: true, ..Self::with(settings, Compensation::STANDARD) }
    }
}

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// A controller that has seen nothing yet and decides by `compensation`, without the [watch](crate::watch): methods are
    /// compared as they were published.
    pub fn with(settings: Settings, compensation: Compensation<E, D, F>) -> Self {
        Self {
            compensation,
            is_watched: false,
            belief: Belief::new(settings.method, &settings.prior, settings.uses_drift()),
            settings,
            acting: settings,
            follows: Follows::new(&settings),
            teaches_from: Some(RobotTime::BEFORE_ALL),
            commands: Commands::default(),
            track: None,
            rejected: None,
            fusion: None,
            noise: NoiseBelief::asked(settings.method),
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
            trace: None,
            report: None,
            runs: None,
            square_report: None,
        }
    }

    /// Answers one request: learns from its reports and poses, and plans the next horizon.
    pub fn step(&mut self, request: &Request) -> Output {
        let mut events = Events::new();
        let horizon = self.answer(request, &mut events).clone();
        Output { horizon, events }
    }

    /// [`Controller::step`] without copies of what is large: the horizon stays where it is remembered.
    pub fn answer(&mut self, request: &Request, events: &mut Events) -> &Horizon {
        self.answer_observed(request, events, &mut ())
    }

    /// [`Controller::answer`], and `observer` sees what is learned.
    pub fn answer_observed(
        &mut self,
        request: &Request,
        events: &mut Events,
        observer: &mut impl SampleObserver,
    ) -> &Horizon {
        let request = &*self.dated(request);
        self.learn(request);
        self.apply_local_limits(request);
        if self.is_checking() {
            self.check(request, events);
        } else {
            self.heed_interruption();
            for observation in &request.observations {
                let last = self.track.map(|track| track.last.taken);
                self.observe(*observation, events, observer);
                self.follow_square(last, observation, events);
            }
        }
        self.watch_age(request.sent, events);
        self.command(request)
    }

    /// A request that was overtaken by a newer one: it teaches the link model and changes nothing else.
    /// Returns the newest horizon.
    pub fn late(&mut self, request: &Request) -> Option<Horizon> {
        let request = &*self.dated(request);
        // Its own reply comes late, too, and holds back those behind it: when its pose was taken is to be known.
        self.belief.link.request(request.sequence, request.observations.last());
        self.learn_deliveries(request);
        self.newest().cloned()
    }

    /// The newest horizon sent.
    pub fn newest(&self) -> Option<&Horizon> {
        self.commands.newest()
    }

    fn learn(&mut self, request: &Request) {
        self.belief.link.request(request.sequence, request.observations.last());
        self.learn_deliveries(request);
        if let Some(playing) = request.playing {
            self.commands.report(playing, request.sent);
        }
    }

    /// The request with its poses at the time at which they were taken, where they are stamped later.
    fn dated<'a>(&self, request: &'a Request) -> Cow<'a, Request> {
        let sensor_delay = self.settings.sensor_delay;
        if sensor_delay == 0.0 {
            return Cow::Borrowed(request);
        }
        let mut dated = request.clone();
        dated.observations.iter_mut().for_each(|it| it.taken -= sensor_delay);
        dated.deliveries.iter_mut().for_each(|it| it.loop_delay += sensor_delay);
        Cow::Owned(dated)
    }

    fn learn_deliveries(&mut self, request: &Request) {
        for delivery in &request.deliveries {
            self.belief.link.update(delivery);
            self.compensation.delay.on_delivery(delivery);
        }
        if !request.deliveries.is_empty() {
            self.act();
        }
    }

    /// Takes in what the robot itself allows. Where it came to rest on its own, the plan begins anew from there, with a turn
    /// toward its waypoint; nothing is learned from what it did meanwhile ([`Heard::was_away`]).
    fn apply_local_limits(&mut self, request: &Request) {
        let Settings { drive, attribution, .. } = self.settings;
        let change = self.heard.take(request, &drive);
        if change == Change::Rests {
            self.commands.interrupt(request.sequence, attribution, &drive, request.sent);
        }
        if change != Change::None {
            self.phase = self.phase.resumed();
            self.phases.clear();
            self.run_anew();
        }
        if self.heard.was_away(request.sent, RobotTime::NEVER) {
            self.pause_watch();
        }
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
        let progress = self.record.progress(self.phase.stage(), legs);
        Progress {
            limited_by: self.limit,
            watch: self.watch.state().map(|(alarm, _)| alarm.condition()),
            ..self.runs_driven(progress)
        }
    }

    /// Whether the task is done: the stage of [`Controller::progress`] without the rest.
    pub fn has_arrived(&self) -> bool {
        self.task.is_some() && self.phase == Phase::Arrived
    }

    /// What was identified.
    pub fn estimates(&self) -> Estimates {
        self.belief.estimates(self.watch.kept().rejects())
    }

    /// The belief, for those who measure it.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// What it decides by.
    pub fn compensation(&self) -> &Compensation<E, D, F> {
        &self.compensation
    }

    /// The last accepted pose.
    pub fn pose(&self) -> Option<Observation> {
        self.track.map(|track| track.last)
    }
}

impl Track {
    /// Begins with an observed pose, at `pose`.
    fn new(observation: Observation, pose: Pose, wheels: WheelSpeeds) -> Self {
        let window = Window::new(observation);
        let last = Observation { pose, ..observation };
        Self {
            last,
            seen: observation,
            unseen: Displacement::default(),
            wheels,
            window,
            interval: SLOT,
            still: last,
            began: observation.taken,
        }
    }
}

#[cfg(test)]
mod tests;
