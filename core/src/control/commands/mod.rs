//! The commands in flight: which wheel speeds are in force at a time, as sent and as reported played.

use crate::actuation::Playing;
use crate::geometry::WheelSpeeds;
use crate::horizon::{Horizon, MAX_SLOTS, RAMP_STEP, SLOT};
use crate::kinematics::{self, Drive};
use crate::settings::Attribution;
use crate::time::RobotTime;
use std::collections::VecDeque;

/// Most horizons remembered: three seconds at one per slot, more than any of them stays in force.
const REMEMBERED: usize = 100;

/// Most reports remembered of what was played.
const REPORTS: usize = 100;

/// No change between two plans takes longer than this many s: full speed forward to full reverse.
const LONGEST_SPREAD: f64 = 1.0;

/// Most steps of a ramp that a walk follows: 30 s of ramp. A robot that takes longer to rest, and has not been seen
/// meanwhile, may be anywhere.
const RAMP_STEPS: usize = 3_000;

/// Most pieces of one walk: every entry of every horizon, every report twice, and a ramp. What is left then counts as
/// rest: a step has an end whatever was asked for.
const MOST_PIECES: usize = REMEMBERED * MAX_SLOTS + 2 * REPORTS + RAMP_STEPS;

/// A horizon that begins within this many s has begun.
const SOON: f64 = 1e-9;

/// A stretch of time for which the robot reported what it played.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Played {
    playing: Playing,
    /// When the last report said so.
    reported: RobotTime,
}

/// The horizons sent to one robot and its reports of what it plays, oldest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Commands {
    sent: Sent,
    played: VecDeque<Played>,
}

impl Default for Commands {
    /// None yet, and room for all that are ever remembered: nothing is allocated later.
    fn default() -> Self {
        Self { sent: Sent::default(), played: VecDeque::with_capacity(REPORTS) }
    }
}

/// Horizons as sent, oldest first, in a ring: they are large and stay where they are.
#[derive(Clone, Debug, PartialEq)]
struct Sent {
    places: Vec<Horizon>,
    /// The place of the oldest.
    first: usize,
    /// How many had begun when the last pose was taken: walks begin there, and look no further back.
    settled: usize,
}

impl Default for Sent {
    fn default() -> Self {
        Self { places: Vec::with_capacity(REMEMBERED), first: 0, settled: 0 }
    }
}

impl Sent {
    /// A place for the next one: that of the oldest, once there are many.
    fn next(&mut self) -> &mut Horizon {
        if self.places.len() < REMEMBERED {
            self.places.push(Horizon::EMPTY);
            let last = self.places.len() - 1;
            return &mut self.places[last];
        }
        let place = self.first;
        self.first = (place + 1) % REMEMBERED;
        self.settled = self.settled.saturating_sub(1);
        &mut self.places[place]
    }

    #[inline]
    fn get(&self, index: usize) -> Option<&Horizon> {
        let (at, count) = (self.first + index, self.places.len());
        (index < count).then(|| &self.places[if at < count { at } else { at - count }])
    }

    fn newest_first(&self) -> impl Iterator<Item = &Horizon> {
        let (newer, older) = self.places.split_at(self.first);
        newer.iter().rev().chain(older.iter().rev())
    }
}

impl Commands {
    /// Begins a horizon that is being sent, still without speeds; starts never go back.
    ///
    /// It is filled in place, that of the one forgotten for it: a horizon is large, and one is sent in every slot.
    pub fn begin(
        &mut self,
        sequence: u64,
        start: RobotTime,
        slot: f64,
        watchdog: f64,
    ) -> &mut Horizon {
        let horizon = self.sent.next();
        (horizon.sequence, horizon.answers) = (sequence, sequence);
        (horizon.start, horizon.slot, horizon.watchdog) = (start, slot, watchdog);
        horizon.speeds.clear();
        horizon
    }

    /// The robot rests on its own from `time` on: it ramps down from what is in force, and what was sent to begin later
    /// never does. `sequence` is that of the request that says so.
    pub fn interrupt(
        &mut self,
        sequence: u64,
        attribution: Attribution,
        drive: &Drive,
        time: RobotTime,
    ) {
        let last = self.at(attribution, drive, time);
        for horizon in &mut self.sent.places {
            horizon.start = horizon.start.earlier(time);
        }
        self.begin(sequence, time, RAMP_STEP, RAMP_STEP).speeds.push(last);
    }

    /// Takes in the robot's report at time `reported` of what it plays.
    pub fn report(&mut self, playing: Playing, reported: RobotTime) {
        match self.played.back_mut() {
            Some(last) if playing.since < last.playing.since => return,
            Some(last) if last.playing.horizon == playing.horizon => {
                last.reported = last.reported.later(reported);
                return;
            }
            _ => {}
        }
        if self.played.len() >= REPORTS {
            self.played.pop_front();
        }
        self.played.push_back(Played { playing, reported });
    }

    /// The newest horizon sent.
    pub fn newest(&self) -> Option<&Horizon> {
        self.sent.get(self.sent.places.len().checked_sub(1)?)
    }

    /// Whether what was played from `from` to `to` is known: horizons remembered, no hole in the reports, and no
    /// jump between two plans that the robot had to spread within its acceleration limits.
    pub fn is_known(&self, drive: &Drive, from: RobotTime, to: RobotTime) -> bool {
        let played = |i: usize, time: RobotTime| {
            let horizon = self.horizon(self.played[i].playing.horizon);
            let speeds = horizon.map_or(WheelSpeeds::ZERO, |horizon| horizon.at(time, drive));
            kinematics::forward(drive, speeds)
        };
        let since = |i: usize| self.played[i].playing.since;
        let mut recent =
            (1..self.played.len()).rev().take_while(|&i| since(i) > from - LONGEST_SPREAD);
        let jumps = recent.any(|i| {
            let since = since(i);
            let spread = drive.change_time(played(i - 1, since - SLOT / 2.0), played(i, since));
            since < to && since + spread > from && spread > 2.0 * SLOT
        });
        if jumps {
            return false;
        }
        self.is_followed(from, to, 2.0 * SLOT)
    }

    /// Whether it is known which horizons were played from `from` to `to`: all of them remembered, and no `hole` in s between
    /// the last report of one and the begin of the next. How a jump between two of them was spread is another question.
    pub fn is_followed(&self, from: RobotTime, to: RobotTime, hole: f64) -> bool {
        let Some(first) = self.played.iter().rposition(|played| played.playing.since <= from)
        else {
            return false;
        };
        let mut known_until = RobotTime::BEFORE_ALL;
        for played in self.played.iter().skip(first) {
            if known_until > RobotTime::BEFORE_ALL && played.playing.since > known_until + hole {
                return false;
            }
            known_until = played.reported;
            if self.horizon(played.playing.horizon).is_none() {
                return false;
            }
            if known_until >= to {
                return true;
            }
        }
        false
    }

    /// Whether the robot ever reported what it plays.
    pub fn is_reported(&self) -> bool {
        !self.played.is_empty()
    }

    /// Whether what was played at `time` was reported within `hole` s of it.
    pub fn is_covered(&self, time: RobotTime, hole: f64) -> bool {
        let report = self.played.iter().rev().find(|played| played.playing.since <= time + SOON);
        report.is_some_and(|report| {
            time <= report.reported + hole && self.horizon(report.playing.horizon).is_some()
        })
    }

    fn horizon(&self, sequence: u64) -> Option<&Horizon> {
        // Asked for among the newest, as a rule.
        self.sent.newest_first().find(|horizon| horizon.sequence == sequence)
    }

    /// How many horizons have begun at `time`, as sent.
    fn sent_at(&self, time: RobotTime) -> usize {
        let ahead = self.sent.newest_first().take_while(|horizon| horizon.start > time + SOON);
        self.sent.places.len() - ahead.count()
    }

    /// The same, quicker at times at which walks begin.
    fn sent_near(&self, time: RobotTime) -> usize {
        let has_begun =
            |at: usize| self.sent.get(at).is_some_and(|horizon| horizon.start <= time + SOON);
        let mut begun = self.sent.settled;
        if begun > 0 && !has_begun(begun - 1) {
            return self.sent_at(time);
        }
        while has_begun(begun) {
            begun += 1;
        }
        begun
    }

    /// The last pose was taken at `time`: walks will begin there.
    pub fn settle(&mut self, time: RobotTime) {
        self.sent.settled = self.sent_near(time);
    }

    /// The last of the first `begun` horizons, and when the next one takes its place.
    fn sent_in_force(&self, begun: usize) -> (Option<&Horizon>, RobotTime) {
        let until = self.sent.get(begun).map_or(RobotTime::NEVER, |next| next.start);
        (self.last_of(begun), until)
    }

    /// The last of the first `begun` horizons.
    fn last_of(&self, begun: usize) -> Option<&Horizon> {
        self.sent.get(begun.checked_sub(1)?)
    }

    /// The horizon in force at `time`, and when another one takes its place.
    fn in_force(&self, attribution: Attribution, time: RobotTime) -> (Option<&Horizon>, RobotTime) {
        let soon = time + SOON;
        let sent = || self.sent_in_force(self.sent_at(time));
        if attribution == Attribution::Sent {
            return sent();
        }
        let Some(at) = self.played.iter().rposition(|played| played.playing.since <= soon) else {
            let until = self.played.front().map_or(RobotTime::NEVER, |played| played.playing.since);
            return if self.played.is_empty() { sent() } else { (None, until) };
        };
        let played = self.played[at];
        if let Some(next) = self.played.get(at + 1) {
            return (self.horizon(played.playing.horizon), next.playing.since);
        }
        if soon < played.reported {
            return (self.horizon(played.playing.horizon), played.reported);
        }
        // Past the last report the best guess is that the newest replies come in time.
        let (horizon, until) = sent();
        match horizon {
            Some(horizon) if horizon.sequence > played.playing.horizon => (Some(horizon), until),
            _ => (self.horizon(played.playing.horizon), until),
        }
    }

    /// The wheel speeds in force at `time`.
    pub fn at(&self, attribution: Attribution, drive: &Drive, time: RobotTime) -> WheelSpeeds {
        let (horizon, _) = self.in_force(attribution, time);
        horizon.map_or(WheelSpeeds::ZERO, |horizon| horizon.at(time, drive))
    }

    /// Calls `each` with the wheel speeds in force and their duration in s, from `from` to `to` without a gap.
    ///
    /// Each piece ends after it begins: with the horizon, with its entry, with what the robot reported, or with the walk.
    /// There are no more than `MOST_PIECES`.
    pub fn walk(
        &self,
        attribution: Attribution,
        drive: &Drive,
        from: RobotTime,
        to: RobotTime,
        mut each: impl FnMut(WheelSpeeds, f64),
    ) {
        let mut time = from;
        // As sent, nothing is looked up twice: in force is the one that was, or the one after it.
        let mut begun = self.sent_near(from);
        let (mut in_force, mut next) = (self.last_of(begun), self.sent.get(begun));
        for _ in 0..MOST_PIECES {
            if time >= to - 1e-9 {
                return;
            }
            let (horizon, until) = if attribution == Attribution::Sent {
                while let Some(horizon) = next
                    && horizon.start <= time + SOON
                {
                    begun += 1;
                    (in_force, next) = (next, self.sent.get(begun));
                }
                (in_force, next.map_or(RobotTime::NEVER, |next| next.start))
            } else {
                self.in_force(attribution, time)
            };
            let (speeds, change) = match horizon {
                // As a rule the next one takes its place before it comes to its second slot.
                Some(horizon) if until <= horizon.start + horizon.slot => {
                    (horizon.speeds.first().copied().unwrap_or(WheelSpeeds::ZERO), until)
                }
                Some(horizon) => horizon.piece(time, drive),
                None => (WheelSpeeds::ZERO, RobotTime::NEVER),
            };
            let next = until.earlier(change).earlier(to);
            each(speeds, next - time);
            time = next;
        }
        if time < to {
            each(WheelSpeeds::ZERO, to - time);
        }
    }

    /// Forgets all: another clock counts from here on.
    pub fn clear(&mut self) {
        self.sent = Sent::default();
        self.played.clear();
    }
}

#[cfg(test)]
mod tests;
