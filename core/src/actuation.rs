//! What the robot does with horizons: newest wins, play by robot time, expire, ramp to rest.
//!
//! One implementation for the agent on the robot and for the simulation. It needs no link: without fresh
//! horizons it stops by itself.

use crate::geometry::elementary::{least, most};
use crate::geometry::{Twist, WheelSpeeds};
use crate::horizon::{Horizon, RAMP_STEP, SLOT};
use crate::kinematics::{self, Drive};
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

/// Most horizons that are held, the playing one included: at the nominal loop delay of 0.23 s and one per slot, eight
/// wait where pose and reply take no time at all.
const HELD: usize = 16;

/// Longest time in s that a horizon may wait for its start: the longest loop delay that a server can be told, and some
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
}

/// What the robot is playing: reported with every request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Playing {
    /// Sequence of the horizon.
    pub horizon: u64,
    /// Robot time in s since when.
    pub since: f64,
}

/// The robot's player of horizons.
///
/// Commands of one plan already keep the acceleration limits. Where the robot has to change plans on a
/// jump, as when it resumes after a silence, the change is spread within the limits.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Actuation {
    drive: Drive,
    /// Places for horizons, which are large and stay where they are.
    places: Vec<Horizon>,
    /// The places of those held, ascending in sequence and in start; the first may be playing, the others wait.
    held: ArrayVec<usize, HELD>,
    newest: Option<u64>,
    playing: Option<Playing>,
    output: Twist,
    /// The wheel speeds of `output`.
    applied: WheelSpeeds,
    /// Acceleration time in s that is not used up yet, at most one slot.
    credit: f64,
    time: f64,
    settled: bool,
    /// Until when nothing changes but the time; none where that has to be looked up.
    #[serde(skip)]
    unchanged_until: Option<f64>,
}

impl Actuation {
    /// A robot at rest at robot time `time`.
    pub fn new(drive: Drive, time: f64) -> Self {
        Self {
            drive,
            places: vec![Horizon::EMPTY; HELD],
            held: ArrayVec::new(),
            newest: None,
            playing: None,
            output: Twist::ZERO,
            applied: WheelSpeeds::ZERO,
            credit: SLOT,
            time,
            settled: true,
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
        if horizon.start > self.time + MAX_LEAD || !horizon.is_meaningful() {
            return Acceptance::Unbelievable;
        }
        self.newest = Some(horizon.sequence);
        // What plays goes on until the new one begins.
        self.unchanged_until = self.unchanged_until.map(|until| least(until, horizon.start));
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

    /// A new epoch: sequences of horizons start again; what is playing goes on until it is replaced or expires.
    pub fn restart_sequences(&mut self) {
        self.newest = None;
    }

    /// The wheel speeds to apply from robot time `now` on, until [`Actuation::next_change`].
    ///
    /// Times never go back; an earlier `now` counts as the last one.
    pub fn advance(&mut self, now: f64) -> WheelSpeeds {
        let now = most(self.time, now);
        self.credit = least(SLOT, self.credit + now - self.time);
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
                kinematics::forward(&self.drive, horizon.at(now, &self.drive))
            }
            _ => Twist::ZERO,
        };
        self.output = self.slew(demand);
        self.applied = kinematics::inverse(&self.drive, self.output);
        self.unchanged_until = self.settled.then(|| self.change_after(now));
        self.applied
    }

    /// Moves the output toward `demand` as far as the unused acceleration time allows.
    fn slew(&mut self, demand: Twist) -> Twist {
        let needed = self.drive.change_time(self.output, demand);
        // The tolerance covers rounding in plans that use the limit to the full.
        self.settled = needed <= self.credit + 1e-6;
        if self.settled {
            self.credit = most(0.0, self.credit - needed);
            return demand;
        }
        let share = self.credit / needed;
        self.credit = 0.0;
        self.drive.part_way(self.output, demand, share)
    }

    /// The next robot time in s after the last `advance` at which the wheel speeds may change.
    pub fn next_change(&self) -> f64 {
        self.unchanged_until.unwrap_or_else(|| self.change_after(self.time))
    }

    fn change_after(&self, now: f64) -> f64 {
        let mut next = f64::INFINITY;
        if let Some(first) = self.horizon(0) {
            next = first.next_change(now, &self.drive);
        }
        if let Some(second) = self.horizon(1) {
            next = least(next, second.start);
        }
        if self.settled { next } else { next.min(now + RAMP_STEP) }
    }

    /// What is being played, since when; none before the first horizon begins.
    pub fn playing(&self) -> Option<Playing> {
        self.playing
    }

    /// The twist applied since the last `advance`.
    pub fn output(&self) -> Twist {
        self.output
    }

    /// Whether the robot is at rest and nothing it holds will move it.
    pub fn is_at_rest(&self) -> bool {
        self.output == Twist::ZERO && self.next_change().is_infinite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::horizon::{MAX_DURATION, MAX_SLOTS, MAX_WATCHDOG};
    use proptest::prelude::*;

    fn horizon(sequence: u64, start: f64, speeds: &[f64]) -> Horizon {
        let drive = Drive::default();
        Horizon {
            sequence,
            answers: sequence,
            start,
            slot: SLOT,
            watchdog: 0.3,
            speeds: speeds
                .iter()
                .map(|&v| kinematics::inverse(&drive, Twist::new(v, 0.0)))
                .collect(),
        }
    }

    fn linear(actuation: &mut Actuation, now: f64) -> f64 {
        actuation.advance(now);
        actuation.output().linear
    }

    #[test]
    fn a_horizon_waits_for_its_start() {
        let mut actuation = Actuation::new(Drive::default(), 0.0);
        actuation.accept(&horizon(1, 1.0, &[0.02]));
        assert_eq!(linear(&mut actuation, 0.5), 0.0);
        assert_eq!(actuation.playing(), None);
        assert_eq!(actuation.next_change(), 1.0);
        assert!((linear(&mut actuation, 1.0) - 0.02).abs() < 1e-12);
        assert_eq!(actuation.playing(), Some(Playing { horizon: 1, since: 1.0 }));
    }

    #[test]
    fn newest_wins_whatever_the_order() {
        let mut actuation = Actuation::new(Drive::default(), 0.0);
        assert_eq!(actuation.accept(&horizon(5, 0.1, &[0.02; 9])), Acceptance::Newest);
        assert_eq!(actuation.accept(&horizon(4, 0.1, &[0.01; 9])), Acceptance::Stale);
        assert_eq!(actuation.accept(&horizon(5, 0.1, &[0.01; 9])), Acceptance::Stale);
        assert!((linear(&mut actuation, 0.2) - 0.02).abs() < 1e-12);
    }

    #[test]
    fn the_old_horizon_plays_until_the_new_one_begins() {
        let mut actuation = Actuation::new(Drive::default(), 0.0);
        actuation.accept(&horizon(1, 0.0, &[0.01; 20]));
        actuation.advance(0.0);
        actuation.accept(&horizon(2, 0.1, &[0.02; 20]));
        assert!((linear(&mut actuation, 0.09) - 0.01).abs() < 1e-12);
        assert!((linear(&mut actuation, 0.10) - 0.02).abs() < 1e-12);
    }

    #[test]
    fn a_single_slot_that_comes_late_plays_on_arrival_until_it_expires() {
        let mut actuation = Actuation::new(Drive::default(), 0.0);
        actuation.advance(1.2);
        actuation.accept(&horizon(1, 1.0, &[0.02]));
        assert!((linear(&mut actuation, 1.2) - 0.02).abs() < 1e-12);
        assert_eq!(linear(&mut actuation, 1.5), 0.0);
        let mut late = Actuation::new(Drive::default(), 0.0);
        late.accept(&horizon(1, 1.0, &[0.02]));
        assert_eq!(linear(&mut late, 1.4), 0.0);
    }

    #[test]
    fn a_stop_on_the_robot_needs_no_link() {
        let mut actuation = Actuation::new(Drive::default(), 0.0);
        actuation.accept(&horizon(1, 0.0, &[0.02; 20]));
        actuation.advance(0.1);
        actuation.stop();
        actuation.advance(0.11);
        assert!(actuation.is_at_rest());
    }

    /// A plan that uses the limit to the full passes unchanged; a jump is spread within the limit.
    #[test]
    fn plans_pass_and_jumps_are_spread() {
        let drive = Drive::default();
        let step = drive.max_linear_acceleration * SLOT;
        let plan: Vec<f64> = (0..10).map(|i| 0.023 + step * f64::from(i)).collect();
        let mut actuation = Actuation::new(drive, 0.0);
        actuation.accept(&horizon(1, 0.0, &plan));
        for (i, &v) in plan.iter().enumerate() {
            let now = i as f64 * SLOT;
            assert!((linear(&mut actuation, now) - v).abs() < 1e-9, "slot {i}");
        }
        let mut jump = Actuation::new(drive, 0.0);
        jump.accept(&horizon(1, 0.0, &[0.13; 60]));
        let (mut now, mut before) = (0.0, 0.0);
        while before < 0.13 - 1e-9 {
            let v = linear(&mut jump, now);
            let allowed = step + drive.min_linear;
            assert!(v - before <= allowed + 1e-9);
            assert!(v <= drive.min_linear + drive.max_linear_acceleration * (now + SLOT) + 1e-9);
            before = v;
            now = jump.next_change();
            assert!(now < 1.0);
        }
    }

    /// The bug to fear: poses without delay, so that more horizons wait than are held, and none ever begins.
    #[test]
    fn however_early_replies_come_each_slot_plays_a_newer_horizon() {
        for lead in [0.01, 0.23, 1.0, 2.0] {
            let mut actuation = Actuation::new(Drive::default(), 0.0);
            let mut played = 0;
            for slot in 0..200_u64 {
                let now = slot as f64 * SLOT;
                actuation.accept(&horizon(slot + 1, now + lead, &[0.02; 20]));
                actuation.advance(now);
                let playing = actuation.playing().map_or(0, |playing| playing.horizon);
                assert!(playing >= played, "lead {lead}");
                played = playing;
            }
            let newest_begun = 200 - (lead / SLOT) as u64;
            // A horizon of twenty slots bridges what was thinned out.
            assert!(played + 10 >= newest_begun, "lead {lead}: {played}");
        }
    }

    /// A ramp to rest takes the time that the limit asks for, down to the smallest speed too.
    #[test]
    fn a_stop_at_any_speed_keeps_the_limit() {
        let drive = Drive::default();
        let mut actuation = Actuation::new(drive, 0.0);
        actuation.accept(&horizon(1, 0.0, &[0.13; 60]));
        let mut now = 0.0;
        while actuation.output().linear < 0.13 {
            actuation.advance(now);
            now = actuation.next_change().min(now + SLOT);
        }
        now += SLOT;
        actuation.advance(now);
        actuation.stop();
        let (began, mut used) = (now, 0.0_f64);
        while !actuation.is_at_rest() {
            let before = actuation.output();
            now += RAMP_STEP;
            actuation.advance(now);
            used = (used - RAMP_STEP).max(0.0) + drive.change_time(before, actuation.output());
            assert!(used <= SLOT + 1e-5, "{used} s of change at {} s", now - began);
        }
        let limit = (0.13 - drive.min_linear) / drive.max_linear_acceleration;
        assert!(now - began >= limit - SLOT - 1e-9 && now - began <= limit + RAMP_STEP);
    }

    /// Whatever a server says once, a robot that then hears nothing more comes to rest in good time.
    #[test]
    fn no_single_horizon_drives_a_robot_for_long() {
        let drive = Drive::default();
        let longest = MAX_LEAD + MAX_DURATION + MAX_WATCHDOG + 0.13 / drive.max_linear_acceleration;
        for start in [-1e9, -3.0, 0.0, 2.0, 2.09, 2.1, 60.0, 1e9, f64::INFINITY, f64::NAN] {
            for slot in [1e-12, 0.001, SLOT, 1.0, 1e6, 1e300, 0.0, -1.0, f64::INFINITY, f64::NAN] {
                for watchdog in [0.05, 0.3, 5.0, 1e9, -1.0, f64::INFINITY, f64::NAN] {
                    let mut actuation = Actuation::new(drive, 0.0);
                    let told = horizon(1, start, &[0.13; MAX_SLOTS]);
                    actuation.accept(&Horizon { slot, watchdog, ..told });
                    let (mut now, mut moved) = (0.0, 0.0);
                    while now < longest + 1.0 {
                        actuation.advance(now);
                        assert!(actuation.output().linear <= 0.13 + 1e-12);
                        if actuation.output() != Twist::ZERO {
                            moved = now;
                        }
                        now += RAMP_STEP;
                    }
                    let said =
                        format!("{moved} s with start {start}, slot {slot}, watchdog {watchdog}");
                    assert!(moved <= longest + RAMP_STEP && actuation.is_at_rest(), "{said}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_believed_leaves_what_plays_as_it_is() {
        let mut actuation = Actuation::new(Drive::default(), 0.0);
        assert_eq!(actuation.accept(&horizon(1, 0.0, &[0.02; 20])), Acceptance::Newest);
        let far = horizon(2, 1000.0, &[0.13; 20]);
        assert_eq!(actuation.accept(&far), Acceptance::Unbelievable);
        let mut nonsense = horizon(3, 0.1, &[0.13; 20]);
        nonsense.speeds[7].left = f64::NAN;
        assert_eq!(actuation.accept(&nonsense), Acceptance::Unbelievable);
        assert!((linear(&mut actuation, 0.2) - 0.02).abs() < 1e-12);
        assert_eq!(actuation.accept(&horizon(2, 0.21, &[0.01; 20])), Acceptance::Newest);
        assert!((linear(&mut actuation, 0.3) - 0.01).abs() < 1e-12);
    }

    proptest! {
        /// Whatever arrives in whatever order: speeds stay within those demanded, the newest sequence wins,
        /// and the robot stops by itself.
        #[test]
        fn any_traffic_ends_at_rest(arrivals in prop::collection::vec((0u64..20, 0.0..1.0f64, 0.0..0.13f64, 1usize..20), 1..40)) {
            let mut actuation = Actuation::new(Drive::default(), 0.0);
            let mut now = 0.0;
            for (sequence, start, v, slots) in arrivals {
                now += 0.02;
                actuation.accept(&horizon(sequence, start, &vec![v; slots]));
                prop_assert!(linear(&mut actuation, now) <= 0.13 + 1e-12);
            }
            let mut steps = 0;
            while !actuation.is_at_rest() {
                actuation.advance(actuation.next_change());
                steps += 1;
                prop_assert!(steps < 1000);
            }
            prop_assert!(actuation.time < 1.0 + 20.0 * SLOT + 0.3 + 2.0);
        }
    }
}
