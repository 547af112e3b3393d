//! How the controller checks a robot: poses are taken as they come, nothing is learned of the floor, and the end of the
//! wiggle is a report.

use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::event::{Event, Events};
use super::plan::Phase;
use super::{Controller, Track};
use crate::check::{Report, Trace, Wiggle};
use crate::exchange::{Observation, Request};
use crate::geometry::WheelSpeeds;
use crate::kinematics;
use crate::settings::{Attribution, Settings};
use crate::task::Task;
use std::sync::Arc;

/// Longest interval in s that counts as one between poses.
const LONGEST_INTERVAL: f64 = 0.5;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// What the last check came to; none before it has ended, after a restart, and under another task.
    pub fn report(&self) -> Option<&Arc<Report>> {
        self.report.as_ref()
    }

    /// Whether the robot is being checked.
    pub(super) fn is_checking(&self) -> bool {
        matches!(self.phase, Phase::Checking { .. })
    }

    /// Room for what is seen of a robot under `task`, where that is a check.
    pub(super) fn trace_of(settings: &Settings, task: Option<&Task>) -> Option<Box<Trace>> {
        let check = task?.check?;
        Some(Box::new(Trace::new(Wiggle::new(check, &settings.drive))))
    }

    /// The check begins anew: what was seen so far is of another motion.
    pub(super) fn check_anew(&mut self) {
        if self.is_checking() {
            if let Some(trace) = &mut self.trace {
                trace.clear();
            }
            self.phase = self.phase.resumed();
            self.phases.clear();
        }
    }

    /// Takes in a request of a robot that is being checked.
    pub(super) fn check(&mut self, request: &Request, events: &mut Events) {
        let was_interrupted = self.stopped || self.heard.is_held();
        let begins_anew = matches!(self.phase, Phase::Checking { part: 0, .. });
        let has_moved = self.trace.as_ref().is_some_and(|trace| trace.has_moved());
        if was_interrupted || (has_moved && begins_anew) {
            self.check_anew();
        }
        let newest = request.observations.last().map(|newest| newest.taken);
        if let Some(trace) = &mut self.trace {
            trace.request(request.sent, newest);
        }
        for observation in &request.observations {
            self.observe_unjudged(*observation);
        }
        let is_over = self.trace.as_ref().is_none_or(|trace| trace.is_over());
        if is_over && !was_interrupted {
            self.end_check(events);
        }
    }

    /// Takes in one pose, whatever it says.
    fn observe_unjudged(&mut self, observation: Observation) {
        let taken = observation.taken;
        let mut next = Track::new(observation, observation.pose, WheelSpeeds::ZERO);
        if let Some(track) = self.track {
            let last = track.last.taken;
            if taken <= last {
                return;
            }
            let (_, _, wheels) = self.nominal(&track, taken);
            let span = (taken - last).min(LONGEST_INTERVAL);
            let interval = track.interval + 0.2 * (span - track.interval);
            next = Track { wheels, interval, ..next };
            if let Some(trace) = &mut self.trace {
                let drive = &self.settings.drive;
                let mut time = last;
                self.commands.walk(Attribution::Played, drive, last, taken, |speeds, duration| {
                    let twist = kinematics::forward(drive, speeds);
                    trace.command(time, twist, duration, drive.track_width);
                    time += duration;
                });
            }
        }
        let was_at_rest = self.was_at_rest(taken);
        if let Some(trace) = &mut self.trace
            && (trace.last_taken().is_some() || was_at_rest)
        {
            trace.pose(observation);
        }
        self.compensation.estimator.reset(observation);
        self.begin_fusion(&observation);
        self.track = Some(next);
        self.rejected = None;
        self.forget_gathered();
        self.commands.settle(taken - self.acting.drive.dead_time);
    }

    fn end_check(&mut self, events: &mut Events) {
        let trace = self.trace.take();
        self.report = trace.map(|trace| Arc::new(Report::of(&trace, &self.settings)));
        self.phase = Phase::Arrived;
        self.phases.clear();
        self.watch.forget();
        let _ = events.try_push(Event::Arrived);
    }
}
