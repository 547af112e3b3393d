//! The horizon: the timed wheel speeds of one reply, in the robot's own clock.

use crate::geometry::WheelSpeeds;
use crate::geometry::elementary::{least, most};
use crate::kinematics::{self, Drive};
use crate::time::RobotTime;
use arrayvec::ArrayVec;

/// Length of one control cycle in s (thesis table 1).
pub const SLOT: f64 = 0.030;

/// Most slots of one horizon: 2 s of 30 ms, beyond which no prediction is worth playing.
pub const MAX_SLOTS: usize = 67;

/// Longest time in s that a robot goes by one horizon, whatever its slots say: [`MAX_SLOTS`] ordinary ones.
pub const MAX_DURATION: f64 = MAX_SLOTS as f64 * SLOT;

/// Longest time in s for which a robot holds the last entry past the end of a horizon, whatever the horizon says: a robot
/// without a link drives blind for no more than this. Only 0, for ever, is more; no real robot takes that.
pub const MAX_WATCHDOG: f64 = 1.0;

/// Default time in s for which the robot holds the last entry past the end of its horizon.
pub const WATCHDOG: f64 = 0.3;

/// Length in s of one step of the ramp to rest.
pub const RAMP_STEP: f64 = 0.010;

/// Times that differ by less than this many slots are the same slot boundary (rounding of sums of 30 ms).
const BOUNDARY: f64 = 1e-6;

/// Wheel speeds for consecutive slots from `start` on, in robot time.
///
/// Past its end the robot holds the last entry for `watchdog` s (0 holds for ever), then ramps to rest:
/// the same function of time on the robot, in simulation and in the server's account of what was driven.
#[derive(Debug, PartialEq)]
pub struct Horizon {
    /// Number of this horizon, strictly increasing within an epoch: newest wins.
    pub sequence: u64,
    /// Sequence of the request that it answers.
    pub answers: u64,
    /// When the first entry begins.
    pub start: RobotTime,
    /// Length of each entry in s.
    pub slot: f64,
    /// Time in s for which the last entry is held past the end; 0 holds for ever.
    pub watchdog: f64,
    /// Wheel speeds per slot, at least one.
    pub speeds: ArrayVec<WheelSpeeds, MAX_SLOTS>,
}

impl Clone for Horizon {
    fn clone(&self) -> Self {
        Self { speeds: self.speeds.clone(), ..*self }
    }

    /// Copies the entries that there are, not the room for the most that there can be.
    fn clone_from(&mut self, source: &Self) {
        let Self { sequence, answers, start, slot, watchdog, speeds } = self;
        (*sequence, *answers) = (source.sequence, source.answers);
        (*start, *slot, *watchdog) = (source.start, source.slot, source.watchdog);
        speeds.clone_from(&source.speeds);
    }
}

impl Horizon {
    /// A horizon without speeds: a place for others.
    pub const EMPTY: Self = Self {
        sequence: 0,
        answers: 0,
        start: RobotTime::ZERO,
        slot: SLOT,
        watchdog: WATCHDOG,
        speeds: ArrayVec::new_const(),
    };

    /// When the last entry ends.
    pub fn end(&self) -> RobotTime {
        self.start + self.slot * self.speeds.len() as f64
    }

    /// After this the robot ramps to rest: end + watchdog, never where the watchdog is 0.
    pub fn valid_until(&self) -> RobotTime {
        if self.watchdog > 0.0 { self.end() + self.watchdog } else { RobotTime::NEVER }
    }

    /// Cuts what is longer than a robot may go by one horizon: entries past [`MAX_DURATION`], a watchdog above
    /// [`MAX_WATCHDOG`]. Whether there was anything to cut.
    pub fn cut(&mut self) -> bool {
        // The tolerance covers rounding where the slots use the longest time to the full.
        let most = most(MAX_DURATION / self.slot * (1.0 + BOUNDARY), 1.0) as usize;
        let is_long = self.slot > MAX_DURATION || self.speeds.len() > most;
        let is_held = self.watchdog > MAX_WATCHDOG;
        if is_long {
            self.slot = least(self.slot, MAX_DURATION);
            self.speeds.truncate(most);
        }
        if is_held {
            self.watchdog = MAX_WATCHDOG;
        }
        is_long || is_held
    }

    /// Whether its numbers mean anything: all finite, a slot that takes time, a watchdog that is none or some.
    pub fn is_meaningful(&self) -> bool {
        let is_finite = |speeds: &WheelSpeeds| speeds.left.is_finite() && speeds.right.is_finite();
        self.start.is_finite()
            && self.slot.is_finite()
            && self.slot > 0.0
            && self.watchdog.is_finite()
            && self.watchdog >= 0.0
            && self.speeds.iter().all(is_finite)
    }

    /// Wheel speeds at `time`: the entry for it, the last one past the end, the ramp past `valid_until`.
    /// Before the start: rest, for a horizon that has not begun demands nothing.
    ///
    /// ```
    /// use umwelt_core::{geometry::WheelSpeeds, horizon::Horizon, kinematics::Drive, time::RobotTime};
    /// let (one, two) = (WheelSpeeds { left: 1.0, right: 1.0 }, WheelSpeeds { left: 2.0, right: 2.0 });
    /// let horizon = Horizon { sequence: 1, answers: 1, start: RobotTime::new(5.0), slot: 0.03, watchdog: 0.3,
    ///                         speeds: [one, two].into_iter().collect() };
    /// let drive = Drive::default();
    /// assert_eq!(horizon.at(horizon.start + 0.01, &drive), one);
    /// assert_eq!(horizon.at(horizon.start + 0.2, &drive), two); // held
    /// assert_eq!(horizon.at(horizon.start + 1.5, &drive), WheelSpeeds::ZERO); // stopped by itself
    /// ```
    pub fn at(&self, time: RobotTime, drive: &Drive) -> WheelSpeeds {
        self.piece(time, drive).0
    }

    /// The next instant after `time` at which [`Horizon::at`] changes; never at rest or held for ever.
    pub fn next_change(&self, time: RobotTime, drive: &Drive) -> RobotTime {
        self.piece(time, drive).1
    }

    /// [`Horizon::at`] and [`Horizon::next_change`] at once. The change always lies after `time`, however few digits
    /// a large clock leaves for it: whoever goes from change to change comes to the end.
    #[inline]
    pub fn piece(&self, time: RobotTime, drive: &Drive) -> (WheelSpeeds, RobotTime) {
        let Some(index) = self.index(time) else { return (WheelSpeeds::ZERO, self.start) };
        let piece = self.piece_at(index, drive);
        if piece.1 > time { piece } else { self.piece_after(index, time, drive) }
    }

    /// Which piece holds at `time`: the entries, then the steps of the ramp, which go on into rest. None before the start.
    #[inline]
    fn index(&self, time: RobotTime) -> Option<usize> {
        let past = time - self.start + BOUNDARY * self.slot;
        if past < 0.0 {
            return None;
        }
        let index = (past / self.slot) as usize;
        let last = self.speeds.len().saturating_sub(1);
        // The last entry goes on past its slot.
        Some(if index < last { index } else { last + self.ramp_step(time) })
    }

    /// Which step of the ramp holds at `time`, counted from 1; 0 before the ramp.
    fn ramp_step(&self, time: RobotTime) -> usize {
        let past = time - self.valid_until() + BOUNDARY * self.slot;
        if past < 0.0 {
            return 0;
        }
        // More steps than this no ramp has; a time beyond them all is one at rest.
        ((past / RAMP_STEP) as usize).min(u32::MAX as usize) + 1
    }

    /// The speeds of a piece and when it ends.
    #[inline]
    fn piece_at(&self, index: usize, drive: &Drive) -> (WheelSpeeds, RobotTime) {
        if index + 1 < self.speeds.len() {
            return (self.speeds[index], self.start + (index + 1) as f64 * self.slot);
        }
        self.last_piece(index - self.speeds.len().saturating_sub(1), drive)
    }

    /// The last entry, or a step of the ramp.
    fn last_piece(&self, step: usize, drive: &Drive) -> (WheelSpeeds, RobotTime) {
        let (valid_until, last) = (self.valid_until(), self.speeds.last().copied());
        let last = last.unwrap_or(WheelSpeeds::ZERO);
        if step == 0 {
            return (last, valid_until);
        }
        let ramp = drive.stopping_time(kinematics::forward(drive, last));
        let gone = step as f64 * RAMP_STEP;
        let speeds = if gone >= ramp { WheelSpeeds::ZERO } else { last.scaled(1.0 - gone / ramp) };
        (speeds, if gone >= ramp + RAMP_STEP { RobotTime::NEVER } else { valid_until + gone })
    }

    /// The first piece behind the one at `index` that ends after `time`: where a clock is so large that a boundary
    /// rounds to before itself, the next piece has begun.
    #[cold]
    fn piece_after(
        &self,
        index: usize,
        time: RobotTime,
        drive: &Drive,
    ) -> (WheelSpeeds, RobotTime) {
        let mut next = index + 1;
        loop {
            // The ramp ends in a piece that lasts for ever, so this comes to an end.
            let piece = self.piece_at(next, drive);
            if piece.1 > time || piece.1.is_never() {
                return piece;
            }
            next += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use proptest::prelude::*;

    fn horizon(slots: usize, watchdog: f64) -> Horizon {
        let drive = Drive::default();
        let speeds = (0..slots)
            .map(|i| kinematics::inverse(&drive, Twist::new(0.05 + 0.002 * i as f64, 0.1)))
            .collect();
        Horizon {
            sequence: 3,
            answers: 7,
            start: RobotTime::new(12.34),
            slot: SLOT,
            watchdog,
            speeds,
        }
    }

    #[test]
    fn what_is_longer_than_a_robot_may_go_by_is_cut_and_nothing_else_is() {
        let cut = |slots: usize, slot: f64, watchdog: f64| {
            let mut h = Horizon { slot, ..horizon(slots, watchdog) };
            let was_cut = h.cut();
            (was_cut, h.speeds.len(), h.slot, h.watchdog)
        };
        for ordinary in [(1, SLOT, 0.3), (20, SLOT, 0.05), (MAX_SLOTS, SLOT, 1.0), (40, 0.05, 0.0)]
        {
            let (slots, slot, watchdog) = ordinary;
            assert_eq!(cut(slots, slot, watchdog), (false, slots, slot, watchdog));
        }
        assert_eq!(cut(20, SLOT, 5.0), (true, 20, SLOT, 1.0));
        assert_eq!(cut(67, 1.0, 0.3), (true, 2, 1.0, 0.3));
        assert_eq!(cut(67, 1e6, 1e6), (true, 1, MAX_DURATION, 1.0));
        assert_eq!(cut(67, 0.031, 0.3), (true, 64, 0.031, 0.3));
    }

    #[test]
    fn every_entry_is_played_in_its_own_slot() {
        let (h, drive) = (horizon(20, 0.3), Drive::default());
        for i in 0..20 {
            let begin = h.start + i as f64 * h.slot;
            assert_eq!(h.at(begin, &drive), h.speeds[i]);
            assert_eq!(h.at(begin + 0.029, &drive), h.speeds[i]);
        }
    }

    #[test]
    fn a_watchdog_of_zero_holds_for_ever() {
        let (h, drive) = (horizon(1, 0.0), Drive::default());
        assert_eq!(h.at(RobotTime::new(1e6), &drive), h.speeds[0]);
        assert_eq!(h.next_change(h.end() + 1.0, &drive), RobotTime::NEVER);
    }

    proptest! {
        /// Walking from change to change sees every value that sampling sees, and comes to rest.
        #[test]
        fn changes_are_complete_and_end(slots in 1usize..30, offset in 0.0..0.5f64) {
            let (h, drive) = (horizon(slots, 0.3), Drive::default());
            let mut time = h.start + offset;
            let mut steps = 0;
            loop {
                let next = h.next_change(time, &drive);
                let now = h.at(time, &drive);
                if next.is_never() {
                    prop_assert_eq!(now, WheelSpeeds::ZERO);
                    break;
                }
                prop_assert!(next > time);
                for share in [0.1, 0.5, 0.9] {
                    prop_assert_eq!(h.at(time + share * (next - time), &drive), now);
                }
                time = next;
                steps += 1;
                prop_assert!(steps < 200);
            }
            let stop = drive.stopping_time(kinematics::forward(&drive, h.speeds[slots - 1]));
            prop_assert!(time <= h.valid_until().later(h.start + offset) + stop + 2.0 * RAMP_STEP);
        }

        /// Guards against: a boundary that rounds to a moment that is not later, at which a caller that walks from change
        /// to change stays for ever. Clocks over the whole range of the contract.
        #[test]
        fn every_change_lies_ahead_whatever_the_clock_reads(
            start in -1e9..1e9f64, slots in 1usize..=MAX_SLOTS, ahead in 0.0..5.0f64, watchdog in 0.01..5.0f64,
        ) {
            let drive = Drive::default();
            let start = RobotTime::new(start);
            let h = Horizon { start, ..horizon(slots, watchdog) };
            let mut time = start + ahead;
            for _ in 0..slots + 100 {
                let next = h.next_change(time, &drive);
                prop_assert!(next > time, "{next} is not after {time}");
                if next.is_never() {
                    prop_assert_eq!(h.at(time, &drive), WheelSpeeds::ZERO);
                    return Ok(());
                }
                time = next;
            }
            prop_assert!(false, "no end in sight at {time}");
        }

        /// The ramp never asks for more than the acceleration limit.
        #[test]
        fn the_ramp_keeps_the_acceleration_limit(v in -0.13..0.13f64, w in -1.2..1.2f64) {
            let drive = Drive::default();
            let mut h = horizon(1, 0.3);
            h.speeds[0] = kinematics::inverse(&drive, drive.limited(Twist::new(v, w)));
            let mut before = kinematics::forward(&drive, h.speeds[0]);
            let mut time = h.valid_until();
            while time < h.valid_until() + 1.0 {
                let after = kinematics::forward(&drive, h.at(time, &drive));
                prop_assert!((after.linear - before.linear).abs() <= drive.max_linear_acceleration * RAMP_STEP + 1e-9);
                prop_assert!((after.angular - before.angular).abs() <= drive.max_angular_acceleration * RAMP_STEP + 1e-9);
                before = after;
                time += RAMP_STEP;
            }
            prop_assert_eq!(before, Twist::ZERO);
        }
    }
}
