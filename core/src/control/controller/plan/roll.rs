//! The roll-out: slot after slot under the fastest command that the limits allow.

use super::super::compensation::PathFollower;
use super::phase::Phase;
use crate::geometry::{Pose, Twist, WheelSpeeds};
use crate::kinematics::{self, MotionModel};
use crate::prediction::{ErrorModel, Motion, Prediction};
use crate::settings::Settings;
use crate::task::{Limit, Task};
use crate::time::RobotTime;
use crate::watch::Floors;

/// Parts of the speed by which the variance rule slows a command down (delta alpha of the thesis, section 4.1.4).
const SLOWER: u32 = 10;

/// What a plan starts from.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// When the first slot begins.
    pub time: RobotTime,
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
    /// Whether the robot is stopped until it is resumed.
    pub stopped: bool,
    /// Time in s at rest after which the robot leaves a waypoint: long enough to be seen there.
    pub rest: f64,
    /// Time in s after which the drive follows a command.
    pub settles: f64,
    /// Time in s by which a motion may begin before the first pose of it and end after the last.
    pub between: f64,
    /// Speed in rad/s up to which the wheels may stand; 0 where that is not identified.
    pub may_stand: f64,
    /// Whether the smallest turn is that of an identified dead band.
    pub is_band_known: bool,
}

/// One slot under one command.
struct Slot {
    command: Twist,
    speeds: WheelSpeeds,
    /// What the wheels really do at its end.
    wheels: WheelSpeeds,
}

/// A plan under way: everything as it is at the beginning of a slot.
pub(super) struct Roll<'a, F> {
    pub(super) settings: &'a Settings,
    pub(super) follower: &'a F,
    pub(super) floors: &'a Floors,
    /// The smallest speeds, as described or raised.
    pub(super) least: Twist,
    pub(super) model: &'a ErrorModel,
    pub(super) task: Option<&'a Task>,
    pub(super) state: Start,
    /// The prediction at the beginning of the slot, at `now`, and the one at its end under the command tried last.
    pub(super) predictions: [Prediction; 2],
    pub(super) now: usize,
    /// What limits the speed of the slot.
    pub(super) limit: Option<Limit>,
}

impl<F: PathFollower> Roll<'_, F> {
    /// Decides one slot and goes on by it.
    pub(super) fn next(&mut self, slot: usize) -> WheelSpeeds {
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
        let is_open = self.state.phase.is_open_loop();
        if full == Twist::ZERO || is_open || self.is_sure() {
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

    /// Whether the last command left the robot at rest.
    pub(super) fn rests(&self) -> bool {
        self.state.previous == Twist::ZERO
    }

    /// The pose at which the robot would come to rest if the command were zero from now on: the actuator's lag
    /// carries it on by lag x speed.
    pub(super) fn coasted(&self) -> Pose {
        let (drive, mean) = (&self.settings.drive, self.predictions[self.now].mean());
        if drive.lag == 0.0 {
            return mean;
        }
        let twist = kinematics::forward(drive, self.state.wheels);
        // Wheels that are still too slow to turn carry it nowhere.
        let previous = self.state.previous;
        let half = drive.track_width / 2.0;
        let speed = |twist: Twist| twist.linear.abs() + half * twist.angular.abs();
        let speeds_up = previous != Twist::ZERO && speed(twist) <= speed(previous);
        if speeds_up && self.floors.moving(previous) == Twist::ZERO {
            return mean;
        }
        mean.then(drive.of_middle(kinematics::integrate(twist, drive.lag)))
    }
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
