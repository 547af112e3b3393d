//! What changes a controller beside requests: tasks, stop and resume, settings.

use super::Controller;
use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::follows::Follows;
use super::heard::Heard;
use super::plan::Phase;
use super::record::Record;
use crate::fusion::NoiseBelief;
use crate::identification::Belief;
use crate::kinematics::Drive;
use crate::local::LocalLimits;
use crate::settings::{Method, Settings};
use crate::task::Task;
use crate::time::RobotTime;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// Sets a task, which replaces the one there is; it begins at the next step.
    pub fn set_task(&mut self, task: Task) {
        self.phase = Phase::first(&task);
        (self.trace, self.report) = (Self::trace_of(&self.settings, Some(&task)), None);
        (self.runs, self.square_report) = (Self::runs_of(&self.settings, Some(&task)), None);
        self.phases.clear();
        self.record = Record::default();
        self.watch.resume();
        self.limit = None;
        self.task = Some(task);
        self.act();
    }

    /// Drops the task; the robot ramps to rest.
    pub fn cancel_task(&mut self) {
        self.task = None;
        (self.trace, self.report) = (None, None);
        (self.runs, self.square_report) = (None, None);
        self.phase = Phase::Idle;
        self.phases.clear();
        self.record = Record::default();
        self.watch.resume();
        self.limit = None;
        self.act();
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

    /// Whether the robot is stopped until it is resumed.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Whether the robot itself holds: it rests whatever is commanded.
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
        (self.rejected, self.fusion) = (None, None);
        self.phases.clear();
        self.phase = self.phase.resumed();
        self.record.restart_clock();
        self.watch.restart_clock();
        self.heard = Heard::default();
        self.forget_gathered();
        self.teaches_from = Some(RobotTime::BEFORE_ALL);
        self.check_anew();
        if let Some(runs) = &mut self.runs {
            runs.restart_clock();
        }
        self.run_anew();
        (self.healthy, self.healthy_at, self.limit) = (None, None, None);
    }

    /// Back to the prior: on another floor, over another link. What the drive is like stays.
    pub fn reset_belief(&mut self) {
        self.belief.reset();
        if let Some(follows) = self.follows.take() {
            self.follows = Some(follows.on_another_floor(&self.settings));
        }
        self.act();
        self.watch.unlearn();
        self.healthy = None;
    }

    /// New settings. The task is kept; what was learned is kept unless method, prior or channels changed.
    pub fn replace_settings(&mut self, settings: Settings) {
        let old = &self.settings;
        let relearn =
            (old.method, old.prior, old.drift) != (settings.method, settings.prior, settings.drift);
        if relearn {
            self.belief = Belief::new(settings.method, &settings.prior, settings.uses_drift());
        }
        let shape = |drive: &Drive| (drive.wheel_radius, drive.track_width);
        if settings.method == Method::Adaptive && shape(&old.drive) != shape(&settings.drive) {
            // Samples are of commands as described; what they said of the drive stays.
            self.belief.reset_channels();
        }
        if relearn || old.drive != settings.drive {
            self.watch.unlearn();
            self.healthy = None;
        }
        if old.method != settings.method {
            (self.noise, self.fusion) = (NoiseBelief::asked(settings.method), None);
        }
        let follows = Follows::redescribed(self.follows.take(), old, &settings);
        self.follows = follows.or_else(|| Follows::new(&settings));
        self.settings = settings;
        self.act();
        if self.trace.is_some() {
            self.trace = Self::trace_of(&self.settings, self.task.as_ref());
        }
        self.check_anew();
        self.square_anew();
        self.limit = None;
        self.phases.clear();
    }
}
