//! What a robot shows of itself: replaced as a whole after each change, read by anybody at any time.

use super::change::RobotChange;
use crate::library::priors::Priors;
use crate::resource::etag;
use crate::store::{Posterior, Record, Told};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;
use umwelt_api::RobotId;
use umwelt_api::environment::{self, Environment};
use umwelt_api::prior::Source;
use umwelt_api::robot::{Description, Pose, Robot, Spec, State};
use umwelt_api::robot_check;
use umwelt_api::square;
use umwelt_api::step::TaggedDrive;
use umwelt_api::task;
use umwelt_api::watch::Watch;
use umwelt_core::check::Report;
use umwelt_core::controller::{Controller, MOST_CORRECTED, Saved};
use umwelt_core::exchange::Observation;
use umwelt_core::local::LocalLimits;
use umwelt_core::settings::{Method, Settings};
use umwelt_core::square::Report as SquareReport;
use umwelt_core::task::{Progress, Task};
use umwelt_core::watch::Alarm;

/// A robot's settings with their version.
#[derive(Clone, Debug)]
pub(super) struct Described {
    pub(super) settings: Settings,
    /// Name of the prior in them.
    pub(super) prior: Option<Arc<str>>,
    /// Where it comes from; that never changes while a robot uses it.
    pub(super) source: Source,
    /// What of them was said.
    said: Arc<Description>,
    /// The drive in them, as robots get it.
    drive: TaggedDrive,
    pub(super) etag: Arc<str>,
}

impl Described {
    pub(super) fn new(told: Told, priors: &Priors) -> Self {
        let Told { settings, prior, said } = told;
        let (prior, source) = (prior.as_deref().map(Arc::from), priors.source(prior.as_deref()));
        let etag = etag::of(&(Spec::from_core(&settings, prior.as_deref()), &said));
        let drive = settings.drive.into();
        let is_corrected = settings.method == Method::Adaptive;
        let corrected_up_to = is_corrected.then_some(MOST_CORRECTED);
        // What is not corrected has the tag that it always had.
        let tag = match corrected_up_to {
            Some(factor) => etag::tag(&(drive, factor)),
            None => etag::tag(&drive),
        };
        let drive = TaggedDrive { tag, drive, corrected_up_to };
        Self { settings, prior, source, said: said.into(), drive, etag }
    }

    /// What it was told.
    fn told(&self) -> Told {
        let prior = self.prior.as_deref().map(str::to_owned);
        Told { settings: self.settings, prior, said: (*self.said).clone() }
    }

    /// What is identified, as the wire has it.
    pub(super) fn environment(&self, saved: &Saved) -> Environment {
        let estimate = saved.estimates();
        let believed = saved.drive_estimate();
        let drive = environment::Drive::new(believed.as_ref(), &self.settings);
        let noise = environment::Noise::new(saved.noise(), &self.settings);
        let name = self.prior.as_deref().and_then(|name| name.parse().ok());
        let (source, method) = (self.source.clone(), estimate.method.into());
        Environment::new(&estimate, drive, noise, environment::Prior::of(name, source, method))
    }
}

/// A robot's task with its version.
#[derive(Clone, Debug)]
pub(super) struct Assigned {
    pub(super) task: Arc<Task>,
    pub(super) etag: Arc<str>,
}

impl Assigned {
    pub(super) fn new(task: Task) -> Self {
        Self { etag: etag::of(&task::Spec::from(&task)), task: task.into() }
    }
}

/// A robot at one moment.
#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    pub(super) described: Described,
    pub(super) assigned: Option<Assigned>,
    pub(super) progress: Progress,
    pub(super) state: State,
    /// What the last check came to.
    pub(super) report: Option<Arc<Report>>,
    /// What the last square came to.
    pub(super) square: Option<Arc<SquareReport>>,
    /// When the last step came.
    pub(super) seen: Option<Instant>,
    pub(super) stopped: bool,
    /// What the robot itself allows, and whether that is nothing.
    pub(super) limits: LocalLimits,
    pub(super) held: bool,
    pub(super) pose: Option<Observation>,
    /// When that pose was taken, by the time of the request that brought it.
    pub(super) pose_taken: Option<Instant>,
    /// What the watch finds, whether the robot rests for it, and since when.
    watch: Option<(Alarm, bool, Option<Instant>)>,
    pub(super) epoch: Option<u64>,
    /// What outlives a restart. Estimates are made from it by those who want to see them, not at every step.
    pub(super) saved: Saved,
    /// The revision of the record under which that is so.
    pub(super) revision: u64,
    /// Whether a stopping horizon has been fetched since the server began to shut down.
    pub(super) drained: bool,
    /// Whether the robot was removed.
    pub(super) removed: bool,
}

impl Snapshot {
    pub(super) fn of(
        controller: &Controller,
        described: Described,
        task: Option<Assigned>,
        revision: u64,
    ) -> Self {
        Self {
            described,
            assigned: task,
            progress: controller.progress(),
            report: controller.report().cloned(),
            square: controller.square_report().cloned(),
            state: State::Never,
            seen: None,
            stopped: controller.is_stopped(),
            limits: controller.local_limits(),
            held: controller.is_held(),
            pose: controller.pose(),
            pose_taken: None,
            // Since when is not known: it was found before this server started.
            watch: controller.watch_state().map(|(alarm, rests)| (alarm, rests, None)),
            epoch: None,
            saved: controller.saved(),
            revision,
            drained: false,
            removed: false,
        }
    }

    /// When the robot counts as lost if nothing comes before; none where it is not heard from now.
    pub(super) fn falls_silent(&self, lost_after: Duration) -> Option<Instant> {
        self.seen.filter(|_| self.state == State::Connected).map(|seen| seen + lost_after)
    }

    /// The same where its computation does not end.
    pub(super) fn failed(&self) -> Self {
        Self { state: State::Failed, ..self.clone() }
    }

    /// The same where it was told to stop, or to go on, and its task has not looked yet.
    pub(super) fn told(&self, stopped: bool) -> Self {
        Self { stopped, ..self.clone() }
    }

    /// Whether the robot rests, or is to go on.
    pub(super) fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// The same where the robot's task has died: no one hears the robot any more.
    pub(super) fn without_task(&self) -> Self {
        let state = if self.state == State::Connected { State::Lost } else { self.state };
        Self { state, ..self.clone() }
    }

    /// Shows what the robot is or does after `change`, which is kept under `revision`.
    pub(super) fn change(&mut self, change: RobotChange, revision: u64, priors: &Priors) {
        match change {
            RobotChange::Told(told) => self.described = Described::new(*told, priors),
            RobotChange::Task(task) => self.assigned = task.map(Assigned::new),
        }
        self.revision = revision;
    }

    /// Shows what the watch finds.
    pub(super) fn watch(&mut self, found: Option<(Alarm, bool)>) {
        self.watch = found.map(|(alarm, rests)| {
            let before = self.watch.filter(|(known, known_rests, _)| {
                (known.condition(), *known_rests) == (alarm.condition(), rests)
            });
            (alarm, rests, before.map_or_else(|| Some(Instant::now()), |(_, _, since)| since))
        });
    }

    /// Version of what was said about the robot.
    pub(crate) fn etag(&self) -> &str {
        &self.described.etag
    }

    /// Version of the task.
    pub(crate) fn task_etag(&self) -> Option<&str> {
        self.assigned.as_ref().map(|assigned| &*assigned.etag)
    }

    /// Whether this very task is the robot's already.
    pub(crate) fn has_task(&self, task: &Task) -> bool {
        self.assigned.as_ref().is_some_and(|assigned| *assigned.task == *task)
    }

    /// Whether the robot is heard from.
    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Whether the robot was removed.
    pub(crate) fn is_removed(&self) -> bool {
        self.removed
    }

    /// Whether the server may shut down without the robot.
    pub(crate) fn is_drained(&self) -> bool {
        self.drained || self.state != State::Connected
    }

    /// What is to be kept of it, where it is to be `stopped` after a restart or not.
    pub(crate) fn record(&self, stopped: bool) -> Record {
        let task = self.assigned.as_ref().map(|assigned| (*assigned.task).clone());
        Record { told: self.described.told(), task, stopped, revision: self.revision }
    }

    /// What was said about it.
    pub(crate) fn said(&self) -> &Description {
        &self.described.said
    }

    /// What its controller was told.
    pub(crate) fn settings(&self) -> &Settings {
        &self.described.settings
    }

    /// Its drive, where `tag` is that of another.
    pub(crate) fn other_drive(&self, tag: u64) -> Option<TaggedDrive> {
        Some(self.described.drive).filter(|drive| drive.tag != tag)
    }

    /// Name of the prior in the settings.
    pub(crate) fn prior(&self) -> Option<&str> {
        self.described.prior.as_deref()
    }

    /// What outlives a restart.
    pub(crate) fn posterior(&self) -> Posterior {
        Posterior { revision: self.revision, saved: self.saved.clone() }
    }

    /// Whether a restart would find the same in `other` as in this one.
    pub(crate) fn is_learned_as(&self, other: &Self) -> bool {
        self.revision == other.revision && self.saved == other.saved
    }

    /// Whether it has learned or done something of weight since `kept`.
    pub(crate) fn is_news_after(&self, kept: &Self) -> bool {
        self.revision != kept.revision || self.saved.is_news_after(&kept.saved)
    }

    /// Whether the watch holds it until it is resumed.
    pub(crate) fn is_held_by_watch(&self) -> bool {
        self.saved.is_held_by_watch()
    }

    /// Whether the watch holds it for something else than `kept` says, or no longer.
    pub(crate) fn is_held_otherwise(&self, kept: &Self) -> bool {
        self.saved.is_held_otherwise(&kept.saved)
    }

    /// What would outlive a restart after `change`.
    pub(crate) fn saved_after(&self, change: &RobotChange) -> Saved {
        let settings = self.described.settings;
        let task = self.assigned.as_ref().map(|assigned| (*assigned.task).clone());
        let controller = Controller::restore(settings, task, self.stopped, self.saved.clone());
        let mut controller = controller.unwrap_or_else(|| Controller::new(settings));
        change.apply(&mut controller);
        controller.saved()
    }

    /// As the wire has it.
    pub(crate) fn robot(&self, id: &RobotId, now: Instant) -> Robot {
        Robot {
            robot: id.clone(),
            spec: Spec::from_core(&self.described.settings, self.prior()),
            described: self.said().clone(),
            state: self.state,
            last_seen_s_ago: self.seen.map(|seen| now.duration_since(seen).as_secs_f64()),
            stopped: self.stopped,
            held: self.held,
            max_speed_m_per_s: self.limits.max_speed,
            pose: self.pose.map(Pose::from),
            pose_age_s: self.pose_taken.map(|taken| now.duration_since(taken).as_secs_f64()),
            watch: self.watch.map(|(alarm, rests, since)| {
                let ago = since.map(|since| now.duration_since(since).as_secs_f64());
                Watch::new(&alarm, rests, ago)
            }),
            task: self.assigned.is_some().then(|| self.progress.into()),
            epoch: self.epoch,
            loop_delay_median_s: self.saved.belief().link.estimate().median,
            etag: self.described.etag.to_string(),
        }
    }

    /// The task as the wire has it.
    pub(crate) fn task(&self, id: &RobotId) -> Option<task::Task> {
        self.assigned.as_ref().map(|assigned| task::Task {
            robot: id.clone(),
            spec: (&*assigned.task).into(),
            progress: self.progress.into(),
            etag: assigned.etag.to_string(),
            check: self.report.as_deref().map(robot_check::Report::from),
            square: self.square.as_deref().map(square::Report::from),
        })
    }

    /// What is identified, as the wire has it.
    pub(crate) fn environment(&self) -> Environment {
        self.described.environment(&self.saved)
    }
}
