//! The watch: what was commanded compared with what was seen, over a sliding distance and time. What is commanded and
//! not seen ends in rest and a named [`Condition`].
//!
//! Thresholds follow from the drive (speeds, track), from what of its delay may not be described, and from the noise of
//! the poses, described or shown by themselves. `docs/watch.md` has them in a table.

mod advance;
mod alarm;
mod evidence;
mod fit;
mod jumps;
mod look;
mod raise;
mod still;

pub use advance::Goal;
pub use alarm::{Alarm, Compared, Condition, Oddity};
pub use evidence::{Kind, Step, UNDESCRIBED_DELAY};
pub use fit::Fit;
pub use look::Situation;
pub use raise::{Floor, Floors, RAISED_FOR};

use crate::settings::Settings;
use advance::Advance;
use evidence::{Evidence, Jitter};
use jumps::Jumps;
use look::{TELLS_STUCK, fast};
use raise::Raise;
use serde::{Deserialize, Serialize};
use still::{Still, Stillness};

/// A cell holds this part of the motion that tells something.
const CELL_SHARE: f64 = 1.0 / 12.0;

/// Radians turned in place over which a shift is remembered: a slow turn counts as much as a fast one.
const SHIFT_MEMORY: f64 = 12.0;

/// A robot that was let go on off its path may stray by this factor farther before it rests again.
const FARTHER: f64 = 1.5;

/// Poses older than this many s, or than [`MISSED`] intervals, are no poses any more.
const NO_POSES: f64 = 1.0;

/// See [`NO_POSES`].
const MISSED: f64 = 2.5;

/// Poses farther apart in s, and than [`MISSED`] intervals, have nothing to do with each other.
const LONGEST_GAP: f64 = 0.5;

/// A pose's share in the interval between poses.
const INTERVAL_SHARE: f64 = 0.2;

/// Longest interval in s that is believed: what comes more rarely is missing.
const LONGEST_INTERVAL: f64 = 2.0;

/// What a look found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// Nothing new.
    Nothing,
    /// The robot moves as commanded.
    Healthy,
    /// The robot is to rest until it is resumed.
    Rest(Alarm),
    /// Worth saying; the robot goes on.
    Remark(Alarm),
    /// A smallest speed was raised.
    Raised(Alarm),
}

/// What outlives a restart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Kept {
    /// Why the robot is to rest.
    pub holding: Option<Alarm>,
    /// What was learned of its smallest speeds.
    pub floors: Floors,
}

impl Kept {
    /// Whether there is nothing to keep.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// How far the tracked point moves while the robot turns in place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Shift {
    commanded: f64,
    turned: f64,
    moved: [f64; 2],
}

impl Shift {
    /// Takes in a turn: what was commanded, and what was seen forward, to the left and turned.
    fn push(&mut self, commanded: f64, [forward, left, turned]: [f64; 3]) {
        let kept = 1.0 - (turned.abs() / SHIFT_MEMORY).min(1.0);
        let Self { commanded: before, turned: until, moved: [ahead, aside] } = *self;
        self.commanded = kept * before + commanded;
        self.turned = kept * until + turned.abs();
        self.moved = [kept * ahead + forward, kept * aside + left];
    }
}

/// The watch over one robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Watch {
    holding: Option<Alarm>,
    /// Whether poses are missing.
    blind: Option<Alarm>,
    remark: Option<Alarm>,
    evidence: Evidence,
    jitter: Jitter,
    still: Still,
    jumps: Jumps,
    raise: Raise,
    advance: Advance,
    shift: Shift,
    off_path: u32,
    /// Farther from the path than the limit by leave of whoever resumed the robot: it may stray so far in m.
    leave: Option<f64>,
    /// Smoothed time in s between accepted poses.
    interval: f64,
    /// Fastest speeds in m/s and rad/s at which the robot was seen to move as commanded, of late.
    top: [f64; 2],
    /// Robot time of the first request, until a pose comes.
    waiting: Option<f64>,
}

impl Watch {
    /// A watch that goes on where one was when `kept` was taken.
    pub fn restored(kept: Kept) -> Self {
        let Kept { holding, floors } = kept;
        Self { holding, raise: Raise::learned(floors), ..Self::default() }
    }

    /// What outlives a restart.
    pub fn kept(&self) -> Kept {
        Kept { holding: self.holding, floors: self.raise.floors }
    }

    /// Whether the robot is to rest.
    pub fn rests(&self) -> bool {
        self.holding.is_some() || self.blind.is_some()
    }

    /// What is found, and whether the robot rests for it.
    pub fn state(&self) -> Option<(Alarm, bool)> {
        let rest = self.holding.or(self.blind).map(|alarm| (alarm, true));
        rest.or(self.remark.map(|alarm| (alarm, false)))
    }

    /// The smallest speeds as learned.
    pub fn floors(&self) -> &Floors {
        &self.raise.floors
    }

    /// Goes on after an alarm: a robot told to resume, or given another task. Returns the alarm.
    pub fn resume(&mut self) -> Option<Alarm> {
        if let Some(Alarm::OffPath { deviation, .. }) = self.holding {
            self.leave = Some(FARTHER * deviation);
        }
        self.remark = None;
        self.forget();
        self.holding.take()
    }

    /// The robot is held or moved by others: nothing that is seen says anything of the commands.
    pub fn pause(&mut self) {
        self.forget();
        self.raise.failed();
    }

    /// Poses begin anew: those before say nothing any more.
    pub fn forget(&mut self) {
        self.evidence.clear();
        self.still.clear();
        self.jumps = Jumps::default();
        self.advance.pause();
        self.off_path = 0;
    }

    /// The robot was carried: it may stray from its path until it is back on it.
    pub fn carried(&mut self) {
        self.leave = Some(f64::INFINITY);
    }

    /// The robot's clock counts anew.
    pub fn restart_clock(&mut self) {
        self.forget();
        self.raise.succeeded();
        (self.jitter, self.blind, self.waiting) = (Jitter::default(), None, None);
    }

    /// Another drive: what was learned of its smallest speeds is of the old one.
    pub fn unlearn(&mut self) {
        self.raise = Raise::default();
        self.shift = Shift::default();
    }

    /// A pose was set aside at robot time `taken`.
    pub fn set_aside(&mut self, taken: f64) -> Finding {
        self.jumps.set_aside(taken);
        match self.jumps.most(taken) {
            Some((jumps, of)) => self.hold(Alarm::Jumping { jumps, of }),
            None => Finding::Nothing,
        }
    }

    /// The newest pose is `age` s old at robot time `now`, none where there was none; `wants` says whether a task wants
    /// the robot to move. Returns what has begun, and what has ended.
    pub fn age(
        &mut self,
        now: f64,
        age: Option<f64>,
        wants: bool,
    ) -> (Option<Alarm>, Option<Alarm>) {
        let since = *self.waiting.get_or_insert(now);
        let limit = NO_POSES.max(MISSED * self.interval);
        let is_blind = wants && age.unwrap_or(now - since) > limit;
        match (is_blind, self.blind) {
            (true, None) => {
                let alarm = Alarm::NoPoses { age };
                self.blind = Some(alarm);
                self.forget();
                (Some(alarm), None)
            }
            (false, Some(_)) => (None, self.blind.take()),
            _ => (None, None),
        }
    }

    /// Takes in an accepted pose. `far` is what a robot can hardly have moved beside its commands, in m and rad; `wants`
    /// says whether a task wants it to move, `played` whether it played the commands between two robot times. Returns the
    /// kind of motion to look at, and what equal poses say.
    pub fn accept(
        &mut self,
        settings: &Settings,
        step: &Step,
        far: (f64, f64),
        wants: bool,
        played: impl Fn(f64, f64) -> bool,
    ) -> (Option<Kind>, Finding) {
        let (span, interval) = (step.to.taken - step.from.taken, self.interval);
        self.interval += INTERVAL_SHARE * (span.min(LONGEST_INTERVAL) - self.interval);
        self.jumps.accept(step.off, far, step.to.taken);
        self.jitter.push(step);
        if !wants || self.rests() {
            return (None, Finding::Nothing);
        }
        if span > LONGEST_GAP.max(MISSED * interval) {
            // What was played between them is not known well.
            self.forget();
            return (None, Finding::Nothing);
        }
        let drive = &settings.drive;
        let top = self.top;
        let stillness = self.still.push(drive, step, || {
            let fast = [Kind::Drive, Kind::Turn].map(|kind| fast(settings, top, kind));
            (fast[0], fast[1])
        });
        let now = step.to.taken;
        match stillness {
            Stillness::Fine => {}
            // It was told less than was sent: as after a silence, when the first replies come late.
            _ if !played(now - self.still.commanded, now) => self.still.clear(),
            Stillness::Try => return (None, self.try_full(settings, now)),
            Stillness::Frozen => {
                let Still { poses, commanded, .. } = self.still;
                return (None, self.hold(Alarm::Frozen { poses, span: commanded }));
            }
        }
        let noise = self.jitter.at_least(settings.noise);
        let least = [noise.position, noise.heading].map(|sd| CELL_SHARE * TELLS_STUCK * sd);
        (self.evidence.push(drive, step, least), Finding::Nothing)
    }

    fn hold(&mut self, alarm: Alarm) -> Finding {
        self.holding = Some(alarm);
        self.remark = None;
        self.raise.failed();
        self.forget();
        Finding::Rest(alarm)
    }
}
