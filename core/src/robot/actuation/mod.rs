//! What the robot does with horizons: newest wins, play by robot time, expire, ramp to rest.
//!
//! One implementation for the agent on the robot and for the simulation. It needs no link: without fresh
//! horizons it stops by itself.

mod slew;

pub use slew::Slew;

use crate::geometry::{Twist, WheelSpeeds};
use crate::horizon::{Horizon, RAMP_STEP, SLOT};
use crate::kinematics::{self, Drive};
use crate::local::LocalLimits;
use crate::time::RobotTime;
use alloc::vec;
use alloc::vec::Vec;
use arrayvec::ArrayVec;

/// Most horizons that are held, the playing one included: at the nominal loop delay of 0.23 s and one per slot, eight
/// wait where pose and reply take no time at all.
const HELD: usize = 16;

/// Longest time in s that a horizon may wait for its start: the longest loop delay that a description may have, and some
/// slots. What begins later was planned for nothing that the robot could know by then.
const MAX_LEAD: f64 = 2.0 + 3.0 * SLOT;

/// Times that differ by less than this many s may be the same slot boundary.
const SAME_TIME: f64 = 1e-6;

/// Whether a horizon will be played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acceptance {
    /// It is the newest so far.
    Newest,
    /// A newer one is here already (or this very one): nothing changes.
    Stale,
    /// It begins too far ahead, or its numbers mean nothing: nothing changes.
    Unbelievable,
    /// The robot itself holds: it plays none, not even later.
    Held,
}

/// What the robot is playing: reported with every request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playing {
    /// Sequence of the horizon.
    pub horizon: u64,
    /// Since when.
    pub since: RobotTime,
}

/// The robot's player of horizons.
///
/// Commands of one plan already keep the acceleration limits. Where the robot has to change plans on a
/// jump, as when it resumes after a silence, the change is spread within the limits.
#[derive(Clone, Debug)]
pub struct Actuation {
    drive: Drive,
    /// What the robot itself allows, whatever horizons say.
    limits: LocalLimits,
    /// Places for horizons, which are large and stay where they are.
    places: Vec<Horizon>,
    /// The places of those held, ascending in sequence and in start; the first may be playing, the others wait.
    held: ArrayVec<usize, HELD>,
    newest: Option<u64>,
    playing: Option<Playing>,
    slew: Slew,
    /// The wheel speeds that come of it.
    applied: WheelSpeeds,
    time: RobotTime,
    /// Until when nothing changes but the time; none where that has to be looked up.
    unchanged_until: Option<RobotTime>,
}

impl Actuation {
    /// A robot at rest at `time`.
    pub fn new(drive: Drive, time: RobotTime) -> Self {
        Self {
            drive,
            limits: LocalLimits::NONE,
            places: vec![Horizon::EMPTY; HELD],
            held: ArrayVec::new(),
            newest: None,
            playing: None,
            slew: Slew::new(Twist::ZERO),
            applied: WheelSpeeds::ZERO,
            time,
            unchanged_until: None,
        }
    }

    /// Takes in a horizon that arrives now. Late, repeated, reordered and unbelievable ones change nothing; one that is
    /// longer than a robot may go by is [cut](Horizon::cut).
    pub fn accept(&mut self, horizon: &Horizon) -> Acceptance {
        if self.newest.is_some_and(|newest| horizon.sequence <= newest) || horizon.speeds.is_empty()
        {
            return Acceptance::Stale;
        }
        if self.limits.is_hold(&self.drive) {
            return Acceptance::Held;
        }
        if horizon.start > self.time + MAX_LEAD || !horizon.is_meaningful() {
            return Acceptance::Unbelievable;
        }
        self.newest = Some(horizon.sequence);
        // What plays goes on until the new one begins.
        self.unchanged_until = self.unchanged_until.map(|until| until.earlier(horizon.start));
        // A waiting horizon that would begin no earlier than this newer one is never played.
        while self.held.last().is_some_and(|&last| self.places[last].start >= horizon.start) {
            self.held.pop();
        }
        if self.held.is_full() {
            self.held.remove(self.least_missed());
        }
        let taken = self.held.iter().fold(0_u32, |taken, &place| taken | 1 << place);
        let place = taken.trailing_ones() as usize;
        self.places[place].clone_from(horizon);
        self.places[place].cut();
        self.held.push(place);
        Acceptance::Newest
    }

    /// The `index`th horizon held.
    fn horizon(&self, index: usize) -> Option<&Horizon> {
        self.held.get(index).map(|&place| &self.places[place])
    }

    /// The waiting horizon that is missed least: the one before it plays on for the shortest time in its stead.
    /// Neither the first, which may be playing, nor the last.
    fn least_missed(&self) -> usize {
        let start = |i: usize| self.places[self.held[i]].start;
        let gap = |i: usize| start(i + 1) - start(i - 1);
        let waiting = 1..self.held.len() - 1;
        waiting.rev().min_by(|&a, &b| gap(a).total_cmp(&gap(b))).unwrap_or(1)
    }

    /// Forgets all horizons and ramps to rest: the answer to a stop on the robot itself.
    pub fn stop(&mut self) {
        self.held.clear();
        self.unchanged_until = None;
        self.playing = None;
    }

    /// The robot itself allows this from now on; `asked` is the sequence of the newest request that it has sent.
    ///
    /// A hold ramps to rest at once and forgets all horizons. It ends with a horizon that was asked for after it: what was
    /// planned before is no plan for a robot that stands where it has come to rest.
    pub fn restrain(&mut self, limits: LocalLimits, asked: u64) {
        let was_held = self.limits.is_hold(&self.drive);
        self.limits = limits;
        self.unchanged_until = None;
        if limits.is_hold(&self.drive) {
            self.stop();
        } else if was_held {
            self.newest = self.newest.max(Some(asked));
        }
    }

    /// The robot moves by another `drive` from now on; its wheels turn as they did.
    pub fn describe(&mut self, drive: Drive) {
        self.drive = drive;
        self.slew.becomes(kinematics::forward(&drive, self.applied));
        self.unchanged_until = None;
    }

    /// A new epoch: sequences of horizons start again; what is playing goes on until it is replaced or expires.
    pub fn restart_sequences(&mut self) {
        self.newest = None;
    }

    /// The wheel speeds to apply from `now` on, until [`Actuation::next_change`].
    ///
    /// Times never go back; an earlier `now` counts as the last one.
    pub fn advance(&mut self, now: RobotTime) -> WheelSpeeds {
        let now = self.time.later(now);
        self.slew.wait(self.time, now);
        self.time = now;
        if self.unchanged_until.is_some_and(|until| now < until - SAME_TIME) {
            return self.applied;
        }
        while self.horizon(1).is_some_and(|next| next.start <= now + 1e-9) {
            self.held.remove(0);
        }
        let demand = match self.held.first().map(|&place| &self.places[place]) {
            Some(horizon) if horizon.start <= now + 1e-9 => {
                if self.playing.is_none_or(|playing| playing.horizon != horizon.sequence) {
                    self.playing = Some(Playing { horizon: horizon.sequence, since: now });
                }
                self.limits.limited(kinematics::forward(&self.drive, horizon.at(now, &self.drive)))
            }
            _ => Twist::ZERO,
        };
        self.applied = kinematics::inverse(&self.drive, self.slew.toward(&self.drive, demand));
        self.unchanged_until = self.slew.is_settled().then(|| self.change_after(now));
        self.applied
    }

    /// The next instant after the last `advance` at which the wheel speeds may change.
    pub fn next_change(&self) -> RobotTime {
        self.unchanged_until.unwrap_or_else(|| self.change_after(self.time))
    }

    fn change_after(&self, now: RobotTime) -> RobotTime {
        let mut next = RobotTime::NEVER;
        if let Some(first) = self.horizon(0) {
            next = first.next_change(now, &self.drive);
        }
        if let Some(second) = self.horizon(1) {
            next = next.earlier(second.start);
        }
        if self.slew.is_settled() { next } else { next.earlier(now + RAMP_STEP) }
    }

    /// What is being played, since when; none before the first horizon begins.
    pub fn playing(&self) -> Option<Playing> {
        self.playing
    }

    /// The twist applied since the last `advance`.
    pub fn output(&self) -> Twist {
        self.slew.output()
    }

    /// Whether the robot is at rest and nothing it holds will move it.
    pub fn is_at_rest(&self) -> bool {
        self.slew.output() == Twist::ZERO && self.next_change().is_never()
    }
}

#[cfg(test)]
mod tests;
