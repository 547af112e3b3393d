//! The watch: what was commanded compared with what was seen, over a sliding distance and time. What is commanded and
//! not seen ends in rest and a named [`Condition`].
//!
//! Thresholds follow from the drive (speeds, track), from what of its delay may not be described, and from the noise of
//! the poses, described or shown by themselves. `docs/watch.md` has them in a table.

mod advance;
mod alarm;
mod evidence;
mod finding;
mod fit;
mod jumps;
mod look;
mod poses;
mod raise;
mod shift;
mod situation;
mod still;

pub use super::condition::Condition;
pub use advance::Goal;
pub use alarm::{Alarm, Compared, Oddity};
pub use evidence::{Kind, Step, UNDESCRIBED_DELAY};
pub use finding::Finding;
pub use fit::Fit;
pub use raise::{Floor, Floors, RAISED_FOR};
pub use situation::Situation;

use crate::exchange::PoseNoise;
use crate::time::RobotTime;
use advance::Advance;
use evidence::{Evidence, Jitter};
use jumps::Jumps;
use raise::Raise;
use serde::{Deserialize, Serialize};
use shift::Shift;
use still::Still;

/// A robot that was let go on off its path may stray by this factor farther before it rests again.
const FARTHER: f64 = 1.5;

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
    /// Why samples are set aside: what the robot is to rest for.
    pub fn rejects(&self) -> Option<Condition> {
        self.holding.map(|alarm| alarm.condition())
    }

    /// Whether there is nothing to keep.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
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
    /// When the first request was sent, until a pose comes.
    waiting: Option<RobotTime>,
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

    /// The noise of the poses, as described or as they show it, whichever is more.
    pub fn noise(&self, described: PoseNoise) -> PoseNoise {
        self.jitter.at_least(described)
    }

    /// The smallest speeds as learned.
    pub fn floors(&self) -> &Floors {
        &self.raise.floors
    }

    /// Goes on after an alarm: a robot that is resumed, or given another task. Returns the alarm.
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

    fn hold(&mut self, alarm: Alarm) -> Finding {
        self.holding = Some(alarm);
        self.remark = None;
        self.raise.failed();
        self.forget();
        Finding::Rest(alarm)
    }
}
