//! What one robot must not do, judged by how it truly moves. Times are arguments, in s on one monotonic clock.
//!
//! A robot is **blind** where its tracker shows nothing new, its wheels are blocked, or no server can be heard. It may go
//! on for as long as it plays what it has, and for [`BLIND`] more in which someone notices. A robot that is slow and does
//! not move may be tried faster, and is not blind then. A robot whose stop was acknowledged rests [`STOPS_WITHIN`] later,
//! until it is resumed.
//!
//! Where the harness itself stood still nothing is known: time in which it did is not counted, and a stop is judged anew
//! from there on.

use serde::Serialize;
use std::collections::BTreeMap;
use umwelt_core::horizon::{SLOT, WATCHDOG};
use umwelt_core::settings::LOOP_DELAY;
use umwelt_core::watch::RAISED_FOR;

/// Slots of the horizons that the robots get.
pub const SLOTS: f64 = 20.0;

/// Time in s of the longest ramp to rest: full speed over the largest acceleration.
const RAMP: f64 = 0.44;

/// Time in s for which a robot moves at most by what it was told before: a reply under way, its horizon, the watchdog
/// and the ramp.
pub const BY_ITSELF: f64 = LOOP_DELAY + SLOTS * SLOT + WATCHDOG + RAMP;

/// Time in s beyond [`BY_ITSELF`] for which a robot may drive blind.
pub const BLIND: f64 = 2.0;

/// Time in s after which a robot rests whose stop was acknowledged: as if its link were cut in that moment, and half as
/// much again for a busy machine.
pub const STOPS_WITHIN: f64 = 1.5 * BY_ITSELF;

/// A motion shorter than this many s in all, three slots, is a tremor of the measurement.
const TREMOR: f64 = 0.1;

/// Most violations that are told in words.
const TOLD: usize = 20;

/// Why a robot cannot know how it moves, or cannot be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Blindness {
    /// Its tracker repeats a pose with fresh stamps.
    FrozenTracker,
    /// Its tracker shows nothing.
    NoPoses,
    /// Its wheels are told to turn and do not.
    BlockedWheels,
    /// Its link carries nothing.
    NoLink,
    /// The server is dead or stands still.
    NoServer,
}

impl Blindness {
    const ALL: [Self; 5] =
        [Self::FrozenTracker, Self::NoPoses, Self::BlockedWheels, Self::NoLink, Self::NoServer];
}

/// How a robot moves over a short time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// Whether its wheels truly turn.
    pub moves: bool,
    /// Whether they are told to.
    pub is_told: bool,
}

/// What was counted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Stops that were acknowledged as kept, and not overtaken by a resume.
    pub stops: u64,
    /// Those after which the robot moved before it was resumed.
    pub stops_undone: u64,
    /// Lines of wheel speeds.
    pub lines: u64,
    /// Those that broke a limit or were none.
    pub limits_broken: u64,
    /// How often a robot drove blind for too long, and why.
    pub blind: BTreeMap<Blindness, u64>,
    /// Longest time in s that it moved blind.
    pub blind_s: f64,
    /// Judgements begun anew because the harness itself stood still.
    pub voided: u64,
    /// The first violations in words.
    pub told: Vec<String>,
}

impl Counts {
    /// Takes in those of another robot.
    pub fn add(&mut self, other: Self) {
        self.stops += other.stops;
        self.stops_undone += other.stops_undone;
        self.lines += other.lines;
        self.limits_broken += other.limits_broken;
        for (why, count) in other.blind {
            *self.blind.entry(why).or_default() += count;
        }
        self.blind_s = self.blind_s.max(other.blind_s);
        self.voided += other.voided;
        self.told.extend(other.told);
        self.told.truncate(TOLD);
    }

    fn tell(&mut self, violation: String) {
        if self.told.len() < TOLD {
            self.told.push(violation);
        }
    }
}

/// A time that a robot has moved in where it must not, from a moment on.
#[derive(Clone, Copy, Debug)]
struct Watched {
    from: f64,
    moved: f64,
    is_counted: bool,
    /// Whether it was seen not to move, and is tried at higher speeds.
    is_tried: bool,
}

impl Watched {
    fn from(from: f64) -> Self {
        Self { from, moved: 0.0, is_counted: false, is_tried: false }
    }

    /// Takes in `duration` s of motion until `now`; whether it is now, for the first time, more than `allowed` s.
    fn moves(&mut self, now: f64, duration: f64, allowed: f64) -> bool {
        if now > self.from {
            self.moved += duration.min(now - self.from);
        }
        let is_first = self.moved > allowed && !self.is_counted;
        self.is_counted |= is_first;
        is_first
    }
}

/// The judge of one robot.
#[derive(Debug)]
pub struct Judge {
    robot: String,
    stopped: Option<Watched>,
    resumed: f64,
    blind: BTreeMap<Blindness, Watched>,
    counts: Counts,
}

impl Judge {
    /// The judge of `robot`.
    pub fn new(robot: &str) -> Self {
        Self {
            robot: robot.to_owned(),
            stopped: None,
            resumed: f64::NEG_INFINITY,
            blind: BTreeMap::new(),
            counts: Counts::default(),
        }
    }

    /// What was counted so far.
    pub fn counts(&self) -> Counts {
        self.counts.clone()
    }

    /// The robot has moved like this for `duration` s, until `now`.
    pub fn moved(&mut self, now: f64, duration: f64, motion: Motion) {
        let Motion { moves, is_told } = motion;
        if moves && self.stopped.as_mut().is_some_and(|it| it.moves(now, duration, TREMOR)) {
            self.counts.stops_undone += 1;
            self.counts.tell(format!("{} moves at {now:.2} s though it was stopped", self.robot));
        }
        for why in Blindness::ALL {
            let counts_as_driving = if why == Blindness::BlockedWheels { is_told } else { moves };
            let Some(watched) = self.blind.get_mut(&why).filter(|_| counts_as_driving) else {
                continue;
            };
            let is_too_long = watched.moves(now, duration, BY_ITSELF + BLIND);
            self.counts.blind_s = self.counts.blind_s.max(watched.moved);
            if is_too_long {
                *self.counts.blind.entry(why).or_default() += 1;
                let robot = &self.robot;
                self.counts.tell(format!("{robot} drives blind at {now:.2} s: {why:?}"));
            }
        }
    }

    /// A stop was sent at `sent` and acknowledged as kept at `now`. A resume sent in between may be the later word.
    pub fn stop_acknowledged(&mut self, sent: f64, now: f64) {
        if self.resumed <= sent {
            self.counts.stops += 1;
            self.stopped = Some(Watched::from(now + STOPS_WITHIN));
        }
    }

    /// The robot is not told to rest any more, says who should know: a stop that is in force must not be gone.
    pub fn is_not_stopped(&mut self, now: f64) {
        if self.stopped.take().is_some_and(|stopped| !stopped.is_counted) {
            self.counts.stops_undone += 1;
            self.counts.tell(format!("{}: its stop is gone at {now:.2} s", self.robot));
        }
    }

    /// A resume is being sent.
    pub fn resumes(&mut self, now: f64) {
        self.stopped = None;
        self.resumed = now;
        self.begins_anew(now);
    }

    /// Someone begins anew who watches the robot, or it is told anew to drive: who has seen nothing yet cannot know.
    pub fn begins_anew(&mut self, now: f64) {
        for watched in self.blind.values_mut() {
            (watched.from, watched.moved) = (now, 0.0);
        }
    }

    /// The robot is blind from `now` on.
    pub fn goes_blind(&mut self, why: Blindness, now: f64) {
        self.blind.insert(why, Watched::from(now));
    }

    /// It is not any more; whoever watches it may notice what else is wrong from here on.
    pub fn sees(&mut self, why: Blindness, now: f64) {
        self.blind.remove(&why);
        self.begins_anew(now);
    }

    /// Someone has seen that the robot does not move, and tries it at higher speeds, as motors with a dead band need it:
    /// it has that long, once, until it has to rest.
    pub fn is_tried(&mut self, now: f64) {
        let blocked = self.blind.get_mut(&Blindness::BlockedWheels);
        if let Some(watched) = blocked.filter(|watched| !watched.is_tried) {
            *watched = Watched { is_tried: true, ..Watched::from(now + RAISED_FOR) };
        }
    }

    /// The harness has stood still until `now`.
    pub fn stood_still(&mut self, now: f64) {
        if let Some(stopped) = &mut self.stopped {
            stopped.from = stopped.from.max(now + STOPS_WITHIN);
            self.counts.voided += 1;
        }
    }

    /// A line of wheel speeds came; `broken` says what is wrong with it.
    pub fn line(&mut self, broken: Result<(), String>) {
        self.counts.lines += 1;
        if let Err(broken) = broken {
            self.counts.limits_broken += 1;
            self.counts.tell(format!("{}: {broken}", self.robot));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.01;
    const DRIVES: Motion = Motion { moves: true, is_told: true };
    const RESTS: Motion = Motion { moves: false, is_told: false };
    const BLOCKED: Motion = Motion { moves: false, is_told: true };

    /// A robot that moves like this from `from` to `to` s.
    fn run(judge: &mut Judge, from: f64, to: f64, motion: Motion) {
        let steps = ((to - from) / STEP).round() as u32;
        for step in 1..=steps {
            judge.moved(from + f64::from(step) * STEP, STEP, motion);
        }
    }

    fn blind(judge: &Judge, why: Blindness) -> u64 {
        judge.counts().blind.get(&why).copied().unwrap_or(0)
    }

    #[test]
    fn a_robot_that_drives_after_its_stop_is_seen_once() {
        let mut judge = Judge::new("r1");
        run(&mut judge, 0.0, 10.0, DRIVES);
        judge.stop_acknowledged(9.9, 10.0);
        run(&mut judge, 10.0, 10.0 + STOPS_WITHIN - 0.1, DRIVES);
        run(&mut judge, 10.0 + STOPS_WITHIN - 0.1, 20.0, RESTS);
        assert_eq!((judge.counts().stops, judge.counts().stops_undone), (1, 0), "it came to rest");
        run(&mut judge, 20.0, 25.0, DRIVES);
        assert_eq!(judge.counts().stops_undone, 1, "{:?}", judge.counts());
        assert_eq!(judge.counts().told.len(), 1);
    }

    #[test]
    fn a_stop_that_is_gone_counts_once_and_only_where_there_was_one() {
        let mut judge = Judge::new("r1");
        judge.is_not_stopped(1.0);
        assert_eq!(judge.counts().stops_undone, 0);
        judge.stop_acknowledged(2.0, 2.1);
        judge.is_not_stopped(2.2);
        judge.is_not_stopped(2.3);
        run(&mut judge, 2.3, 20.0, DRIVES);
        assert_eq!(judge.counts().stops_undone, 1);
    }

    #[test]
    fn a_later_resume_ends_a_stop_and_one_on_the_way_makes_it_doubtful() {
        let mut judge = Judge::new("r1");
        judge.stop_acknowledged(0.0, 0.1);
        judge.resumes(5.0);
        run(&mut judge, 5.0, 20.0, DRIVES);
        // Sent before the stop and answered whenever: the stop is the later word.
        judge.resumes(20.00);
        judge.stop_acknowledged(20.01, 20.1);
        assert!(judge.stopped.is_some());
        // Sent while the stop was under way: either may be the later word.
        judge.resumes(30.05);
        judge.stop_acknowledged(30.0, 30.1);
        assert!(judge.stopped.is_none());
        run(&mut judge, 30.1, 60.0, DRIVES);
        assert_eq!((judge.counts().stops, judge.counts().stops_undone), (2, 0));
    }

    #[test]
    fn every_way_to_drive_blind_for_too_long_is_seen() {
        for why in Blindness::ALL {
            let motion = if why == Blindness::BlockedWheels { BLOCKED } else { DRIVES };
            let mut judge = Judge::new("r1");
            run(&mut judge, 0.0, 10.0, motion);
            judge.goes_blind(why, 10.0);
            run(&mut judge, 10.0, 10.0 + BY_ITSELF + BLIND - 0.1, motion);
            assert_eq!(blind(&judge, why), 0, "not yet");
            run(&mut judge, 20.0, 30.0, RESTS);
            run(&mut judge, 30.0, 30.3, motion);
            assert_eq!(
                judge.counts().blind,
                BTreeMap::from([(why, 1)]),
                "a rest makes it no shorter"
            );
            run(&mut judge, 30.3, 60.0, motion);
            assert_eq!(blind(&judge, why), 1, "once");
        }
    }

    #[test]
    fn who_sees_again_or_is_told_anew_drives_with_new_right() {
        let mut judge = Judge::new("r1");
        judge.goes_blind(Blindness::FrozenTracker, 0.0);
        run(&mut judge, 0.0, 3.0, DRIVES);
        judge.begins_anew(3.0);
        run(&mut judge, 3.0, 6.0, DRIVES);
        judge.sees(Blindness::FrozenTracker, 6.0);
        run(&mut judge, 6.0, 60.0, DRIVES);
        assert_eq!(judge.counts().blind, BTreeMap::new());
    }

    #[test]
    fn a_blocked_robot_may_be_tried_faster_once_and_for_so_long() {
        let mut judge = Judge::new("r1");
        judge.goes_blind(Blindness::BlockedWheels, 0.0);
        run(&mut judge, 0.0, 3.0, BLOCKED);
        judge.is_tried(3.0);
        run(&mut judge, 3.0, 3.0 + RAISED_FOR, BLOCKED);
        assert_eq!(judge.counts().blind, BTreeMap::new());
        judge.is_tried(3.0 + RAISED_FOR);
        run(&mut judge, 3.0 + RAISED_FOR, 10.0 + RAISED_FOR, BLOCKED);
        assert_eq!(blind(&judge, Blindness::BlockedWheels), 1, "not twice");
    }

    #[test]
    fn what_the_harness_slept_through_is_not_judged() {
        let mut judge = Judge::new("r1");
        judge.stop_acknowledged(0.0, 0.1);
        judge.stood_still(2.0);
        run(&mut judge, 2.0, 4.0, DRIVES);
        assert_eq!((judge.counts().stops_undone, judge.counts().voided), (0, 1));
        run(&mut judge, 4.0, 5.0, DRIVES);
        assert_eq!(judge.counts().stops_undone, 1, "and what it saw is");
    }

    #[test]
    fn broken_lines_are_counted_and_told() {
        let mut judge = Judge::new("r1");
        judge.line(Ok(()));
        judge.line(Err("too fast".into()));
        let counts = judge.counts();
        assert_eq!((counts.lines, counts.limits_broken), (2, 1));
        assert_eq!(counts.told, ["r1: too fast"]);
    }
}
