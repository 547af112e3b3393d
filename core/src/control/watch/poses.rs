//! What the watch takes from each pose: one that is accepted, one that is set aside, and one that does not come.

use super::Watch;
use super::alarm::Alarm;
use super::evidence::{Kind, Step};
use super::finding::Finding;
use super::look::{SHOWS_STUCK, fast};
use super::still::{Still, Stillness};
use crate::settings::Settings;
use crate::time::RobotTime;

/// A cell holds this part of the motion that says something.
const CELL_SHARE: f64 = 1.0 / 12.0;

/// Poses older than this many s, or than [`MISSED`] intervals, are no poses any more.
const NO_POSES: f64 = 1.0;

/// See [`NO_POSES`].
const MISSED: f64 = 2.5;

/// Poses farther apart in s, and than [`MISSED`] intervals, have nothing to do with each other.
const LONGEST_GAP: f64 = 0.5;

/// A pose's share in the interval between poses.
const INTERVAL_SHARE: f64 = 0.2;

/// Longest interval in s that counts as one: what comes more rarely is missing.
const LONGEST_INTERVAL: f64 = 2.0;

impl Watch {
    /// A pose was set aside at `taken`.
    pub fn set_aside(&mut self, taken: RobotTime) -> Finding {
        self.jumps.set_aside(taken);
        match self.jumps.most(taken) {
            Some((jumps, of)) => self.hold(Alarm::Jumping { jumps, of }),
            None => Finding::Nothing,
        }
    }

    /// The newest pose is `age` s old `now`, none where there was none; `wants` says whether a task wants
    /// the robot to move. Returns what has begun, and what has ended.
    pub fn age(
        &mut self,
        now: RobotTime,
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
    /// says whether a task wants it to move, `played` whether it played the commands between two instants. Returns the
    /// kind of motion to look at, and what equal poses say.
    pub fn accept(
        &mut self,
        settings: &Settings,
        step: &Step,
        far: (f64, f64),
        wants: bool,
        played: impl Fn(RobotTime, RobotTime) -> bool,
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
            // It played less than was sent: as after a silence, when the first replies come late.
            _ if !played(now - self.still.commanded, now) => self.still.clear(),
            Stillness::Try => return (None, self.try_full(settings, now)),
            Stillness::Frozen => {
                let Still { poses, commanded, .. } = self.still;
                return (None, self.hold(Alarm::Frozen { poses, span: commanded }));
            }
        }
        let noise = self.jitter.at_least(settings.noise);
        let least = [noise.position, noise.heading].map(|sd| CELL_SHARE * SHOWS_STUCK * sd);
        (self.evidence.push(drive, step, least), Finding::Nothing)
    }
}
