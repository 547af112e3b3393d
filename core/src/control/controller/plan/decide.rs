//! What each phase of a task wants of the robot, and when the next one begins.

use super::super::compensation::PathFollower;
use super::approach::{Approach, STRAY};
use super::phase::Phase;
use super::roll::Roll;
use crate::check::{Part, Wiggle};
use crate::geometry::Twist;
use crate::steering;
use crate::task::{Limit, Task};
use crate::time::RobotTime;
use std::f64::consts::TAU;

/// A turn smaller than this many rad is never worth making at the start of a leg: the curve takes it.
const WORTH_TURNING: f64 = 0.02;

/// Beyond this heading error in rad a turn under way keeps its side: half a turn has no shorter one.
const KEEP_SIDE: f64 = 2.0;

/// Part of the smallest speed up to which a robot of unequal wheels turns in place.
const IN_PLACE: f64 = 0.1;

/// Times that differ by less than this many s are the same moment.
const SAME_TIME: f64 = 1e-6;

impl<F: PathFollower> Roll<'_, F> {
    /// The twist that the task wants now; the phase goes on.
    pub(super) fn decide(&mut self, task: &Task) -> Twist {
        // Each pass is a transition that costs no time; a task has a handful in a row at most.
        for _ in 0..8 {
            let before = self.state.phase;
            let desired = match before {
                Phase::Idle | Phase::Settling | Phase::Arrived => Some(Twist::ZERO),
                Phase::Checking { part, since } => self.wiggle(task, part, since),
                Phase::Squaring { run, part, at, done } => self.square(task, (run, part), at, done),
                Phase::Ramping { level, since } => self.ramp(task, level, since),
                Phase::Calibrating { turn, since } => self.rotate(task, turn, since),
                Phase::Straight { outbound, origin, since } => {
                    self.straight(task, outbound, origin, since)
                }
                Phase::Turning { leg, side } => self.turn(task, leg, side),
                Phase::Driving { leg } => self.drive(task, leg),
                Phase::Stopping { leg, since } => self.rest(task, leg, since),
            };
            if let Some(desired) = desired {
                return desired;
            }
        }
        Twist::ZERO
    }

    /// Whether `seconds` have passed since `since`.
    pub(super) fn has_passed(&self, since: RobotTime, seconds: f64) -> bool {
        self.state.time - since >= seconds - SAME_TIME
    }

    /// The part of a check's wiggle; at rest after the last.
    fn wiggle(&mut self, task: &Task, part: u32, since: Option<RobotTime>) -> Option<Twist> {
        let wiggle = task.check.map(|check| Wiggle::new(check, &self.settings.drive));
        let Some(Part { twist, duration }) = wiggle.and_then(|wiggle| wiggle.part(part)) else {
            return Some(Twist::ZERO);
        };
        let has_begun = twist != Twist::ZERO || self.rests();
        let since = since.or_else(|| has_begun.then_some(self.state.time));
        if since.is_some_and(|since| self.has_passed(since, duration)) {
            self.state.phase = Phase::Checking { part: part + 1, since: None };
            return None;
        }
        self.state.phase = Phase::Checking { part, since };
        Some(twist)
    }

    fn rotate(&mut self, task: &Task, turn: u32, since: Option<RobotTime>) -> Option<Twist> {
        let calibration = task.calibration.filter(|calibration| turn < calibration.rotations);
        let Some(calibration) = calibration else {
            let goes_straight = task.calibration.is_some_and(|it| it.straight > 0.0);
            self.state.phase = if goes_straight {
                let origin = self.predictions[self.now].mean();
                Phase::Straight { outbound: true, origin, since: None }
            } else {
                Phase::Settling
            };
            return None;
        };
        if turn == 0 && since.is_none() && self.is_worth_a_ramp() {
            self.state.phase = Phase::Ramping { level: 0, since: None };
            return None;
        }
        let since = since.unwrap_or(self.state.time);
        if self.has_passed(since, calibration.rotate + calibration.pause) {
            self.state.phase = Phase::Calibrating { turn: turn + 1, since: None };
            return None;
        }
        self.state.phase = Phase::Calibrating { turn, since: Some(since) };
        if self.has_passed(since, calibration.rotate) {
            return Some(Twist::ZERO);
        }
        let side = if turn.is_multiple_of(2) { 1.0 } else { -1.0 };
        Some(Twist::new(0.0, side * self.turning_speed(calibration.angular)))
    }

    fn turn(&mut self, task: &Task, leg: usize, side: i8) -> Option<Twist> {
        let target = task.waypoints[leg];
        let (drive, sight) = (&self.settings.drive, self.sight(target));
        // Of unequal wheels more and more is known: what was a turn in place no longer is to the last digit.
        let in_place = if drive.unequal == 0.0 { 0.0 } else { IN_PLACE * drive.min_linear };
        if self.state.previous.linear.abs() > in_place {
            return Some(Twist::ZERO);
        }
        // Where the robot stands on the point, its direction is noise: nothing to turn to.
        if sight.distance <= task.tolerance {
            self.state.phase = Phase::Stopping { leg, since: None };
            return None;
        }
        let error = sight.turn(self.may_reverse(task, target));
        let good_enough = self.good_enough(task, target);
        if side == 0 {
            // The curve may stray by the stop radius; more is worth a turn in place.
            let law = &self.settings.steering;
            let worth = law.stop_radius / (STRAY * sight.range);
            let worth = worth.clamp(WORTH_TURNING, law.turn_tolerance.max(WORTH_TURNING));
            let worth = worth.max(good_enough);
            if error.abs() <= worth {
                self.state.phase = Phase::Driving { leg };
                return None;
            }
            let side = if error > 0.0 { 1 } else { -1 };
            self.state.phase = Phase::Turning { leg, side };
            return None;
        }
        let direction = f64::from(side);
        let mut remaining = error * direction;
        if remaining < -KEEP_SIDE {
            remaining += TAU;
        }
        let (_, overrun) = self.floors.overrun(drive, self.state.previous);
        // A motor that does not turn slowly cannot turn by little: what the curve can take is left to it, or, where it is
        // known from which speed on it turns, what that makes of a slot.
        let is_coarse = self.floors.turn.least > 0.0;
        let left_over = match (is_coarse, self.state.is_band_known) {
            (false, _) => 0.0,
            (true, true) => self.least.angular * self.settings.slot,
            (true, false) => self.settings.steering.turn_tolerance,
        };
        let least = (drive.min_angular * self.settings.slot / 2.0).max(overrun).max(left_over);
        let least = least.max(good_enough / 2.0);
        if remaining > least {
            let stoppable = steering::stopping_speed(
                remaining,
                drive.max_angular_acceleration,
                self.settings.slot,
            );
            let speed = stoppable.clamp(self.least.angular, drive.max_angular);
            let is_free = speed >= drive.max_angular;
            let limit = if is_free { Limit::Drive } else { Limit::Waypoint };
            self.limit = Some(if speed > stoppable && !self.floors.is_none() {
                Limit::Watch
            } else {
                limit
            });
            return Some(Twist::new(0.0, direction * speed));
        }
        if !self.rests() {
            return Some(Twist::ZERO);
        }
        let near_enough = self.settings.steering.turn_tolerance.max(good_enough);
        self.state.phase = if error.abs() <= near_enough {
            Phase::Driving { leg }
        } else {
            Phase::Turning { leg, side: 0 }
        };
        None
    }

    fn drive(&mut self, task: &Task, leg: usize) -> Option<Twist> {
        let target = task.waypoints[leg];
        let reversing = self.reverses(task, target);
        let from = leg.checked_sub(1).map(|before| task.waypoints[before]);
        match self.approach(from, target, reversing, task.tolerance) {
            Approach::Go(twist, limit) => {
                let arc = self.arc(task, target, reversing);
                self.limit = Some(if arc.is_some() { Limit::Waypoint } else { limit });
                Some(arc.unwrap_or(twist))
            }
            Approach::OffHeading => {
                self.state.phase = Phase::Turning { leg, side: 0 };
                None
            }
            Approach::Reached => {
                self.state.phase = Phase::Stopping { leg, since: None };
                None
            }
        }
    }

    fn rest(&mut self, task: &Task, leg: usize, since: Option<RobotTime>) -> Option<Twist> {
        if !self.rests() {
            self.state.phase = Phase::Stopping { leg, since: None };
            return Some(Twist::ZERO);
        }
        let since = since.unwrap_or(self.state.time);
        if self.has_passed(since, self.state.rest) {
            let away = self.coasted().point().distance(task.waypoints[leg]) > task.tolerance;
            let is_last = leg + 1 == task.waypoints.len();
            if away || !is_last {
                let leg = if away { leg } else { leg + 1 };
                self.state.phase = Phase::Turning { leg, side: 0 };
                return None;
            }
        }
        self.state.phase = Phase::Stopping { leg, since: Some(since) };
        Some(Twist::ZERO)
    }
}
