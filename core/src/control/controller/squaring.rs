//! How the controller follows a square: where its runs end, and what they come to.

use super::Controller;
use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::event::{Event, Events};
use super::plan::Phase;
use crate::exchange::Observation;
use crate::kinematics;
use crate::settings::{Attribution, Settings};
use crate::square::{Course, Ending, Report, Runs, Seen};
use crate::task::{Progress, Stage, Task};
use crate::time::RobotTime;
use std::sync::Arc;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// What the last square came to; none before it has ended, after a restart, and under another task.
    pub fn square_report(&self) -> Option<&Arc<Report>> {
        self.square_report.as_ref()
    }

    /// Room for what is seen of a robot under `task`, where that is a square.
    pub(super) fn runs_of(settings: &Settings, task: Option<&Task>) -> Option<Box<Runs>> {
        let square = task?.square?;
        Some(Box::new(Runs::new(Course::new(square, &settings.drive), &settings.drive)))
    }

    fn is_squaring(&self) -> bool {
        matches!(self.phase, Phase::Squaring { .. })
    }

    /// The square begins anew, with another drive.
    pub(super) fn square_anew(&mut self) {
        if self.is_squaring() {
            self.runs = Self::runs_of(&self.settings, self.task.as_ref());
            self.go_on_with(Phase::run_of_square(0));
        }
    }

    /// The run under way begins anew: a stop or a hold is no part of a square.
    pub(super) fn run_anew(&mut self) {
        if self.is_squaring()
            && let Some(runs) = &mut self.runs
        {
            runs.begin_anew();
            let run = runs.driven();
            self.go_on_with(Phase::run_of_square(run));
        }
    }

    /// A run that the robot is to rest in begins anew.
    pub(super) fn heed_interruption(&mut self) {
        if self.stopped || self.heard.is_held() || self.watch.rests() {
            self.run_anew();
        }
    }

    /// Takes in a pose, where it was accepted and the robot drives a square; the pose before it was taken at `last`.
    pub(super) fn follow_square(
        &mut self,
        last: Option<RobotTime>,
        observation: &Observation,
        events: &mut Events,
    ) {
        let accepted = self.track.map(|track| track.last.taken) == Some(observation.taken);
        if !self.is_squaring() || !accepted || last.is_some_and(|last| last >= observation.taken) {
            return;
        }
        let Some(runs) = &mut self.runs else { return };
        let (drive, floors) = (&self.settings.drive, self.watch.floors());
        if let Some(last) = last {
            let mut time = last;
            let (from, until) = (last, observation.taken);
            self.commands.walk(Attribution::Played, drive, from, until, |speeds, duration| {
                let twist = floors.moving(kinematics::forward(drive, speeds));
                runs.command(time, twist, duration);
                time += duration;
            });
        }
        let run = Course::new(runs.square(), &self.acting.drive);
        match runs.pose(*observation, run.settling()) {
            Seen::OnTheWay => {}
            Seen::Returned | Seen::Disturbed => {
                let run = runs.driven();
                self.go_on_with(Phase::run_of_square(run));
            }
            Seen::Over(ending) => self.end_square(ending, events),
        }
    }

    fn go_on_with(&mut self, phase: Phase) {
        self.phase = phase;
        self.phases.clear();
    }

    fn end_square(&mut self, ending: Ending, events: &mut Events) {
        let runs = self.runs.take();
        let report = runs.map(|runs| Arc::new(runs.report(ending, &self.settings.drive)));
        self.square_report = report;
        self.go_on_with(Phase::Arrived);
        let _ = events.try_push(Event::Arrived);
    }

    /// `progress` with the runs of a square, where the task is one.
    pub(super) fn runs_driven(&self, progress: Progress) -> Progress {
        let Some(square) = self.task.as_ref().and_then(|task| task.square) else { return progress };
        let legs = 2 * square.runs as usize;
        let (driven, elapsed) = match (&self.runs, &self.square_report) {
            (Some(runs), _) => (runs.driven() as usize, runs.span()),
            (None, Some(report)) => (legs, report.span),
            (None, None) => (0, 0.0),
        };
        let leg = if progress.stage == Stage::Arrived { legs } else { driven };
        Progress { leg, legs, elapsed, ..progress }
    }
}
