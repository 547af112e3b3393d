//! The plan: the whole task rolled forward on the predicted pose, one slot at a time, transitions included.

use super::compensation::{Compensation, Way};
use crate::geometry::{Displacement, Point, Pose, Twist, WheelSpeeds, length};
use crate::horizon::MAX_SLOTS;
use crate::kinematics;
use crate::prediction::{ErrorModel, Motion, Prediction};
use crate::settings::Settings;
use crate::steering;
use crate::task::{Limit, Stage, Task};
use crate::watch::Floors;
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Slots at rest before a waypoint counts as reached.
pub const REST_SLOTS: u32 = 3;

/// A turn smaller than this many rad is never worth making at the start of a leg: the curve takes it.
const WORTH_TURNING: f64 = 0.02;

/// A parabola that starts with a heading error strays from its chord by this part of error x distance.
const STRAY: f64 = 0.25;

/// Parts of the speed by which the variance rule slows a command down (delta alpha of the thesis, section 4.1.4).
const SLOWER: u32 = 10;

/// Beyond this heading error in rad a turn under way keeps its side: half a turn has no shorter one.
const KEEP_SIDE: f64 = 2.0;

/// Times that differ by less than this many s are the same moment.
const SAME_TIME: f64 = 1e-6;

/// Where in its task a robot is. Times are the robot's, so that a new plan may begin at any moment, not only where a
/// slot of the old one does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Phase {
    /// No task, or it was cancelled.
    #[default]
    Idle,
    /// Rotating and stopping for the `turn`th time, since `since`.
    Calibrating { turn: u32, since: Option<f64> },
    /// The calibration's straight part, ahead of `origin` and back; at its end since `since`.
    Straight { outbound: bool, origin: Pose, since: Option<f64> },
    /// At rest before the first leg, until the robot has been seen at rest: what it does then is known for certain.
    Settling,
    /// Turning toward waypoint `leg`, to the left (+1), to the right (-1) or not yet decided (0).
    Turning { leg: usize, side: i8 },
    /// Driving to waypoint `leg`.
    Driving { leg: usize },
    /// At waypoint `leg`, at rest since `since`.
    Stopping { leg: usize, since: Option<f64> },
    /// At rest at the last waypoint, and seen there.
    Arrived,
}

impl Phase {
    /// The first phase of a task.
    pub fn first(task: &Task) -> Self {
        match task.calibration {
            Some(_) => Self::Calibrating { turn: 0, since: None },
            None => Self::Settling,
        }
    }

    /// The waypoint that the robot is heading for, once its calibration is over.
    pub fn leg(self) -> Option<usize> {
        match self {
            Self::Turning { leg, .. } | Self::Driving { leg } | Self::Stopping { leg, .. } => {
                Some(leg)
            }
            _ => None,
        }
    }

    /// The same phase taken up again after a pause of unknown motion.
    pub fn resumed(self) -> Self {
        match self {
            Self::Driving { leg } | Self::Turning { leg, .. } => Self::Turning { leg, side: 0 },
            Self::Stopping { leg, .. } => Self::Stopping { leg, since: None },
            Self::Calibrating { turn, .. } => Self::Calibrating { turn, since: None },
            Self::Straight { outbound, origin, .. } => {
                Self::Straight { outbound, origin, since: None }
            }
            Self::Idle | Self::Settling | Self::Arrived => self,
        }
    }

    /// As it is shown.
    pub fn stage(self) -> Stage {
        match self {
            Self::Idle => Stage::Idle,
            Self::Calibrating { .. } | Self::Straight { .. } => Stage::Calibrating,
            Self::Turning { .. } => Stage::Turning,
            Self::Driving { .. } => Stage::Driving,
            Self::Settling | Self::Stopping { .. } => Stage::Stopping,
            Self::Arrived => Stage::Arrived,
        }
    }
}

/// What a plan starts from.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Robot time in s at which the first slot begins.
    pub time: f64,
    /// Time in s since the command in force began: what the first change has to keep the acceleration limit.
    pub since_change: f64,
    /// What the wheels really do then.
    pub wheels: WheelSpeeds,
    /// The command in force until then.
    pub previous: Twist,
    /// Where in the task the robot is then.
    pub phase: Phase,
    /// Whether the newest pose is fresh: without one an unsure robot does not even creep.
    pub fresh: bool,
    /// Whether the robot has been told to stop.
    pub stopped: bool,
    /// Time in s at rest after which the robot leaves a waypoint: long enough to be seen there.
    pub rest: f64,
}

/// What a plan keeps to.
pub struct Rules<'a, C> {
    /// What the controller was told.
    pub settings: &'a Settings,
    /// How it drives.
    pub compensation: &'a C,
    /// What was learned of the smallest speeds.
    pub floors: &'a Floors,
}

/// The phase at the beginning of each slot of a plan, and at the end of the last: at least two.
pub type Phases = ArrayVec<Phase, { MAX_SLOTS + 1 }>;

/// Rolls the task forward from the pose predicted at the start: wheel speeds per slot into `speeds`, the phases that they
/// lead through into `phases`.
/// Both are large and stay in place: a plan is made in every slot. Returns what limits the speed in the first one.
pub fn plan<C: Compensation>(
    rules: Rules<C>,
    model: &ErrorModel,
    task: Option<&Task>,
    start: Start,
    prediction: Prediction,
    speeds: &mut ArrayVec<WheelSpeeds, MAX_SLOTS>,
    phases: &mut Phases,
) -> Option<Limit> {
    speeds.clear();
    phases.clear();
    let predictions = [prediction.clone(), prediction];
    let Rules { settings, compensation, floors } = rules;
    let least = floors.raised(&settings.drive);
    let mut roll = Roll {
        settings,
        compensation,
        floors,
        least: Twist::new(least.min_linear, least.min_angular),
        model,
        task,
        state: start,
        predictions,
        now: 0,
        limit: None,
    };
    let mut limit = None;
    for slot in 0..settings.slots.clamp(1, MAX_SLOTS) {
        phases.push(roll.state.phase);
        speeds.push(roll.next(slot));
        if slot == 0 {
            limit = roll.limit;
        }
    }
    phases.push(roll.state.phase);
    limit
}

/// What the way to a point asks for.
enum Approach {
    /// The robot is there, or as near as it gets.
    Reached,
    /// The point lies too far off the heading to be driven to.
    OffHeading,
    /// Drive, and what limits the speed.
    Go(Twist, Limit),
}

/// One slot under one command.
struct Slot {
    command: Twist,
    speeds: WheelSpeeds,
    /// What the wheels really do at its end.
    wheels: WheelSpeeds,
}

struct Roll<'a, C> {
    settings: &'a Settings,
    compensation: &'a C,
    floors: &'a Floors,
    /// The smallest speeds, as described or raised.
    least: Twist,
    model: &'a ErrorModel,
    task: Option<&'a Task>,
    state: Start,
    /// The prediction at the beginning of the slot, at `now`, and the one at its end under the command tried last.
    predictions: [Prediction; 2],
    now: usize,
    /// What limits the speed of the slot.
    limit: Option<Limit>,
}

impl<C: Compensation> Roll<'_, C> {
    /// Decides one slot and goes on by it.
    fn next(&mut self, slot: usize) -> WheelSpeeds {
        self.limit = None;
        let desired = match self.task {
            Some(task) if !self.state.stopped && self.is_somewhere() => self.decide(task),
            _ => Twist::ZERO,
        };
        let Slot { command, speeds, wheels } = self.admit(desired, slot);
        self.now = 1 - self.now;
        self.state.wheels = wheels;
        self.state.previous = command;
        self.state.time += self.settings.slot;
        self.state.since_change = self.settings.slot;
        speeds
    }

    /// Whether the robot is predicted to be at any place: with a belief that knows no variance it may be infinitely far
    /// away, and rests rather than to turn toward what is no number.
    fn is_somewhere(&self) -> bool {
        let mean = self.predictions[self.now].mean();
        mean.x.is_finite() && mean.y.is_finite() && mean.heading.radians().is_finite()
    }

    /// The next slot under `command`, predicted to its end.
    fn attempt(&mut self, command: Twist) -> Slot {
        let (drive, duration) = (&self.settings.drive, self.settings.slot);
        let speeds = kinematics::inverse(drive, command);
        let (wheels, twist) = kinematics::travel(drive, self.state.wheels, speeds, duration);
        let twist = self.floors.moving(twist);
        let [one, other] = &mut self.predictions;
        let (before, after) = if self.now == 0 { (one, other) } else { (other, one) };
        after.become_after(before, self.model, Motion::new(twist, duration));
        Slot { command, speeds, wheels }
    }

    /// The slot of the fastest command along `desired` whose variance at its end is under the limits
    /// (thesis section 4.1.4), reachable from the previous one.
    fn admit(&mut self, desired: Twist, slot: usize) -> Slot {
        let (drive, previous) = (&self.settings.drive, self.state.previous);
        let since_change = self.state.since_change;
        let reached = |twist| drive.reach(previous, twist, since_change);
        let full = reached(drive.limited(desired));
        let fastest = self.attempt(full);
        if is_slower(full, desired) && self.limit.is_some() {
            self.limit = Some(Limit::Acceleration);
        }
        if full == Twist::ZERO || self.is_sure() {
            return fastest;
        }
        self.limit = self.limit.map(|_| Limit::Variance);
        let slowest = crawl(self.least, full);
        for part in 1..SLOWER {
            let slower = full.scaled(1.0 - f64::from(part) / f64::from(SLOWER));
            if is_slower(slower, slowest) {
                break;
            }
            let slower = self.attempt(reached(slower));
            if self.is_sure() {
                return slower;
            }
        }
        // An unsure robot creeps, it does not deadlock: within the expected loop delay a fresh pose will correct it.
        let soon = slot as f64 * self.settings.slot < self.settings.loop_delay;
        self.attempt(reached(if self.state.fresh && soon { slowest } else { Twist::ZERO }))
    }

    /// Whether the variances at the end of the slot tried last are under the limits.
    fn is_sure(&self) -> bool {
        let spread = self.predictions[1 - self.now].spread();
        let limits = &self.settings.variance;
        spread.position <= limits.position && spread.heading <= limits.heading
    }

    /// The twist that the task wants now; the phase goes on.
    fn decide(&mut self, task: &Task) -> Twist {
        // Each pass is a transition that costs no time; a task has a handful in a row at most.
        for _ in 0..8 {
            let before = self.state.phase;
            let desired = match before {
                Phase::Idle | Phase::Settling | Phase::Arrived => Some(Twist::ZERO),
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

    /// Whether the last command left the robot at rest.
    fn rests(&self) -> bool {
        self.state.previous == Twist::ZERO
    }

    /// The pose at which the robot would come to rest if the command were zero from now on: the actuator's lag
    /// carries it on by lag x speed.
    fn coasted(&self) -> Pose {
        let (drive, mean) = (&self.settings.drive, self.predictions[self.now].mean());
        if drive.lag == 0.0 {
            return mean;
        }
        let twist = kinematics::forward(drive, self.state.wheels);
        mean.then(kinematics::integrate(twist, drive.lag))
    }

    /// Whether `seconds` have passed since `since`.
    fn has_passed(&self, since: f64, seconds: f64) -> bool {
        self.state.time - since >= seconds - SAME_TIME
    }

    fn rotate(&mut self, task: &Task, turn: u32, since: Option<f64>) -> Option<Twist> {
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
        Some(Twist::new(0.0, side * calibration.angular))
    }

    fn straight(
        &mut self,
        task: &Task,
        outbound: bool,
        origin: Pose,
        since: Option<f64>,
    ) -> Option<Twist> {
        let length = task.calibration.map_or(0.0, |calibration| calibration.straight);
        let ahead = Displacement { forward: length, ..Displacement::default() };
        let target = if outbound { origin.then(ahead) } else { origin };
        if since.is_none()
            && let Approach::Go(twist, limit) =
                self.approach(None, target.point(), !outbound, task.tolerance)
        {
            self.limit = Some(limit);
            return Some(twist);
        }
        let since = since.unwrap_or(self.state.time);
        if self.rests() && self.has_passed(since, f64::from(REST_SLOTS) * self.settings.slot) {
            self.state.phase = if outbound {
                Phase::Straight { outbound: false, origin, since: None }
            } else {
                Phase::Settling
            };
            return None;
        }
        self.state.phase = Phase::Straight { outbound, origin, since: Some(since) };
        Some(Twist::ZERO)
    }

    fn turn(&mut self, task: &Task, leg: usize, side: i8) -> Option<Twist> {
        if self.state.previous.linear != 0.0 {
            return Some(Twist::ZERO);
        }
        let (drive, pose, target) = (&self.settings.drive, self.coasted(), task.waypoints[leg]);
        let (ahead, aside) = pose.toward(target);
        // Where the robot stands on the point, its direction is noise: nothing to turn to.
        let distance = length(ahead, aside);
        if distance <= task.tolerance {
            self.state.phase = Phase::Stopping { leg, since: None };
            return None;
        }
        let error = heading_error(ahead, aside, task.reverse);
        if side == 0 {
            // The curve may stray by the stop radius; more is worth a turn in place.
            let law = &self.settings.steering;
            let worth = law.stop_radius / (STRAY * distance);
            let worth = worth.clamp(WORTH_TURNING, law.turn_tolerance.max(WORTH_TURNING));
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
        // A motor that does not turn slowly cannot turn by little: what the curve can take is left to it.
        let is_coarse = self.floors.turn.least > 0.0;
        let left_over = if is_coarse { self.settings.steering.turn_tolerance } else { 0.0 };
        let least = (drive.min_angular * self.settings.slot / 2.0).max(overrun).max(left_over);
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
        self.state.phase = if error.abs() <= self.settings.steering.turn_tolerance {
            Phase::Driving { leg }
        } else {
            Phase::Turning { leg, side: 0 }
        };
        None
    }

    fn drive(&mut self, task: &Task, leg: usize) -> Option<Twist> {
        let reversing = task.reverse && {
            let (ahead, _) = self.coasted().toward(task.waypoints[leg]);
            ahead < 0.0
        };
        let from = leg.checked_sub(1).map(|before| task.waypoints[before]);
        match self.approach(from, task.waypoints[leg], reversing, task.tolerance) {
            Approach::Go(twist, limit) => {
                self.limit = Some(limit);
                Some(twist)
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

    fn rest(&mut self, task: &Task, leg: usize, since: Option<f64>) -> Option<Twist> {
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

    /// The way to `target`, forward or in reverse, from the pose to which the robot coasts; `from` is where the leg
    /// begins.
    fn approach(
        &self,
        from: Option<Point>,
        target: Point,
        reverse: bool,
        tolerance: f64,
    ) -> Approach {
        let (drive, law) = (&self.settings.drive, &self.settings.steering);
        let pose = self.coasted();
        let (ahead, aside) = pose.toward(target);
        let distance = length(ahead, aside);
        let onward = if reverse { -ahead } else { ahead };
        let error = heading_error(ahead, aside, reverse).abs();
        // Far off, or off by so much at so great a distance that the curve would leave the path: as after a silence
        // in the middle of a turn. Close to the point neither is worth a stop.
        let strays = error > 2.0 * law.turn_tolerance && STRAY * error * distance > tolerance;
        let off_heading = error > law.turn_beyond || strays;
        let passed = onward <= 0.0;
        let (overrun, _) = self.floors.overrun(drive, self.state.previous);
        if distance <= law.stop_radius + overrun
            || (distance <= tolerance && (passed || off_heading))
        {
            return Approach::Reached;
        }
        if passed || off_heading {
            return Approach::OffHeading;
        }
        let stoppable = steering::stopping_speed(
            distance - law.stop_radius / 2.0,
            drive.max_linear_acceleration,
            self.settings.slot,
        );
        let (previous, since_change) = (self.state.previous, self.state.since_change);
        let speed = stoppable.clamp(self.least.linear, drive.max_linear);
        let way = Way { pose, previous, from, to: target, reverse, speed, since_change };
        if let Some(twist) = self.compensation.steer(self.settings, &way) {
            return Approach::Go(twist, Limit::Waypoint);
        }
        let wanted = steering::curve(ahead, aside, law.alpha);
        let limited = drive.limited(wanted);
        let speed = limited.linear.abs().min(stoppable).max(self.least.linear);
        let limit = if speed > limited.linear.abs().min(stoppable) && !self.floors.is_none() {
            Limit::Watch
        } else if stoppable < limited.linear.abs() {
            Limit::Waypoint
        } else if limited.linear.abs() < wanted.linear.abs() {
            Limit::Drive
        } else {
            Limit::Alpha
        };
        // The curve belongs to the speed that is really reached.
        let forward = Twist::new(speed.copysign(wanted.linear), 0.0);
        let reached = drive.reach(previous, forward, since_change).linear;
        let bend = wanted.angular / wanted.linear;
        let angular = (bend * reached).clamp(-drive.max_angular, drive.max_angular);
        let limit = if reached.abs() < speed { Limit::Acceleration } else { limit };
        Approach::Go(Twist::new(reached, angular), limit)
    }
}

/// The turn in rad that points the robot, or its tail where it may reverse to what lies behind, at a point.
fn heading_error(ahead: f64, aside: f64, reverse: bool) -> f64 {
    let error = aside.atan2(ahead);
    if reverse && error.abs() > FRAC_PI_2 { (-aside).atan2(-ahead) } else { error }
}

/// The slowest command along `twist` at which the motors turn, whose `least` speeds are so large.
fn crawl(least: Twist, twist: Twist) -> Twist {
    let slow = if twist.linear.abs() > 0.0 {
        least.linear / twist.linear.abs()
    } else {
        least.angular / twist.angular.abs()
    };
    if slow < 1.0 { twist.scaled(slow) } else { twist }
}

fn is_slower(one: Twist, other: Twist) -> bool {
    one.linear.abs() < other.linear.abs()
        || (other.linear == 0.0 && one.angular.abs() < other.angular.abs())
}
