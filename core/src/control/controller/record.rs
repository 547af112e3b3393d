//! How far a task has got, as observed: waypoints reached, deviation from the leg, time.

use super::event::{Event, Events};
use super::plan::Phase;
use crate::exchange::Observation;
use crate::geometry::Point;
use crate::horizon::SLOT;
use crate::task::{Progress, Stage, Task};
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// The record of one task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Waypoints at which the robot was seen at rest.
    reached: usize,
    /// Where the task began, once it did.
    origin: Option<Point>,
    /// Since when the task counts.
    began: Option<RobotTime>,
    /// When the plan in force left the waypoint that is to be reached next.
    left: Option<RobotTime>,
    deviation: f64,
    max_deviation: f64,
    elapsed: f64,
}

impl Record {
    /// The waypoint that is to be reached next.
    pub fn target(&self, task: &Task) -> Option<Point> {
        task.waypoints.get(self.reached).copied()
    }

    /// The segment of the current leg, once the task has begun and until it is done.
    pub fn leg(&self, task: &Task) -> Option<(Point, Point)> {
        let (origin, target) = (self.origin?, self.target(task)?);
        Some((if self.reached == 0 { origin } else { task.waypoints[self.reached - 1] }, target))
    }

    /// The task begins: the robot was seen at rest at `here`. Returns its first phase.
    pub fn begin(&mut self, task: &Task, here: Point, events: &mut Events) -> Phase {
        self.origin = Some(here);
        let _ = events.try_push(Event::CalibrationEnded);
        let is_there =
            self.target(task).is_some_and(|first| here.distance(first) <= task.tolerance);
        let done = is_there.then(|| self.reach(task, events)).flatten();
        done.unwrap_or(Phase::Turning { leg: self.reached, side: 0 })
    }

    /// The robot was seen at rest at the waypoint to be reached next; what that means if it was the last.
    fn reach(&mut self, task: &Task, events: &mut Events) -> Option<Phase> {
        let _ = events.try_push(Event::WaypointReached { leg: self.reached });
        self.reached += 1;
        self.left = None;
        let is_done = self.reached == task.waypoints.len();
        is_done.then(|| {
            let _ = events.try_push(Event::Arrived);
            Phase::Arrived
        })
    }

    /// The plan in force passes through `phase` at `time`.
    pub fn pass(&mut self, phase: Phase, time: RobotTime) {
        let Some(leg) = phase.leg() else { return };
        if self.began.is_none() {
            self.began = Some(time - self.elapsed);
        }
        if leg > self.reached && self.left.is_none() {
            self.left = Some(time);
        }
    }

    /// Takes in an accepted pose; `is_there` says whether it is one at rest at the waypoint to be reached next.
    /// Returns the phase to go on with where the plan's own no longer holds: the task is done, or a waypoint was
    /// left without the robot having been seen there.
    pub fn observe(
        &mut self,
        task: &Task,
        observation: &Observation,
        is_there: bool,
        events: &mut Events,
    ) -> Option<Phase> {
        let (Some(began), Some((from, to))) = (self.began, self.leg(task)) else { return None };
        if observation.taken < began {
            return None;
        }
        self.deviation = observation.pose.point().distance_to_segment(from, to);
        self.max_deviation = self.max_deviation.max(self.deviation);
        self.elapsed = observation.taken - began;
        if is_there {
            return self.reach(task, events);
        } else if self.left.is_some_and(|left| observation.taken > left + SLOT) {
            self.left = None;
            return Some(Phase::Turning { leg: self.reached, side: 0 });
        }
        None
    }

    /// Distance in m of the last accepted pose from the leg, once the task has begun.
    pub fn deviation(&self) -> Option<f64> {
        self.began.map(|_| self.deviation)
    }

    /// Forgets times of the robot's clock; what has elapsed counts on once the new one is known.
    pub fn restart_clock(&mut self) {
        self.began = None;
        self.left = None;
    }

    /// Waypoints at which the robot was seen at rest.
    pub fn reached(&self) -> usize {
        self.reached
    }

    /// Time in s since the task began.
    pub fn elapsed(&self) -> f64 {
        self.elapsed
    }

    /// As it is shown.
    pub fn progress(&self, stage: Stage, legs: usize) -> Progress {
        let Self { reached, deviation, max_deviation, elapsed, .. } = *self;
        Progress {
            stage,
            leg: reached,
            legs,
            deviation,
            max_deviation,
            elapsed,
            ..Progress::default()
        }
    }
}
