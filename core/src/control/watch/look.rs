//! What the watch concludes from the evidence: stuck, against the command, off the path, not as described.

use super::Watch;
use super::alarm::{Alarm, Compared, Oddity};
use super::evidence::{Kind, Sums, UNDESCRIBED_DELAY};
use super::finding::Finding;
use super::fit::{Fit, Response};
use super::raise::How;
use super::shift::Shift;
use super::situation::Situation;
use crate::control::condition::Condition;
use crate::exchange::PoseNoise;
use crate::geometry::Twist;
use crate::settings::Settings;
use crate::time::RobotTime;

/// Time in s of commanded motion after which a robot that was not seen to move is stuck: what is left of 2 s to come to
/// rest are the sensor's and the link's delay and the ramp.
const STUCK_TIME: f64 = 0.9;

/// The same where the command goes to and fro: what is left of one way is taken for the other way for a while.
const TO_AND_FRO_TIME: f64 = 1.5 * STUCK_TIME;

/// Motion seen of a standing robot in one cell, in standard deviations of a pose: twice what is expected, and some.
const NOISE_A_CELL: f64 = 3.0;

/// Time in s of motion against the command after which frame or wheels are wrong, not counting what may still be of the
/// motion before: more than may go undescribed of the delay, so that a change of direction is not taken for it.
const MISMATCH_TIME: f64 = 0.6;

/// Part of the commanded motion below which nothing moved: a dead band and blocked wheels give none, wheels described
/// wrongly by a factor of five a fifth.
const MOVED: f64 = 0.1;

/// Part of the commanded motion from which on the robot surely moves: twice what noise may make of [`MOVED`].
const MOVES: f64 = 2.0 * MOVED;

/// Part of the commanded motion, in any direction, below which a robot stands rather than moves elsewhere.
const ELSEWHERE: f64 = 0.3;

/// Part of the commanded motion below which a robot that the variance rule slows down is tried faster.
const CREEPS: f64 = 0.35;

/// Part of the commanded motion above which all is well.
const HEALTHY: f64 = 0.5;

/// Commanded motion in standard deviations of a pose that separates [`MOVED`] from half: 0.4 of it is seven standard
/// deviations of a difference of two poses.
pub(super) const SHOWS_STUCK: f64 = 24.0;

/// The same for motion against the command, which is as far again from what it should be.
const TELLS_MISMATCH: f64 = 12.0;

/// Part of its full speed that is no speed.
const NO_SPEED: f64 = 1e-3;

/// Part of its full speed above which raising a speed is no use.
const FULL: f64 = 0.9;

/// Part of the speed at which the robot was lately seen to move that is the same speed: a dead band may lie close below.
const AS_FAST: f64 = 0.97;

/// Times the smallest speed up to which a robot creeps: on a slope it may be tried faster though it crept before.
const CREEP: f64 = 2.0;

/// What is remembered after a look of the fastest speed at which the robot was seen to move: half after 14 s.
const TOP_MEMORY: f64 = 0.995;

/// Driven back by more than this part of the command: slopes that a robot slides down while it creeps up are above.
const BACK: f64 = -0.5;

/// Turned back by more than this part of the command.
const TURNED_BACK: f64 = -0.4;

/// Moved beside the command by more than this part of it, and by less than [`ALONG`] along it: more than 45 degrees off.
const BESIDE: f64 = 0.7;

/// See [`BESIDE`].
const ALONG: f64 = 0.6;

/// Part of a commanded turn below which a robot that runs off instead does not turn.
const NO_TURN: f64 = 0.4;

/// Time in s without any advance after which a robot that is not as described, or whose poses jump, is to rest.
const NO_ADVANCE: f64 = 5.0;

/// Part of the track by which the tracked point may move per radian turned in place.
const SHIFT: f64 = 0.25;

/// Radians turned in place from which that is known.
const SHIFT_TURNED: f64 = 2.0;

/// A part that differs from a half by less than this is a half.
const ABOUT_HALF: f64 = 0.15;

/// Looks in a row at which the robot was too far from its path.
const LOOKS_OFF_PATH: u32 = 2;

impl Watch {
    /// Looks at the last cells of a kind. `played` says whether the robot played the commands between two robot
    /// times, as far as it reports that.
    pub fn look(
        &mut self,
        settings: &Settings,
        kind: Kind,
        situation: &Situation,
        played: impl Fn(RobotTime, RobotTime) -> bool,
    ) -> Finding {
        let noise = self.jitter.at_least(settings.noise);
        if kind == Kind::Turn && self.evidence.is_settled() {
            let (commanded, seen) = self.evidence.newest();
            self.shift.push(commanded, seen);
        }
        let Some(finding) = self.look_at_motion(settings, kind, noise, situation, &played) else {
            return Finding::Nothing;
        };
        if matches!(finding, Finding::Rest(_) | Finding::Raised(_)) {
            return finding;
        }
        if let Some((alarm, (from, to))) = self.mismatch(settings, kind, noise, situation.heading)
            && played(from - UNDESCRIBED_DELAY, to)
        {
            return self.hold(alarm);
        }
        match self.look_at_way(settings, noise, situation) {
            Finding::Nothing => finding,
            other => other,
        }
    }

    /// Whether the robot moves at all; none where it played less than was sent: replies came late.
    fn look_at_motion(
        &mut self,
        settings: &Settings,
        kind: Kind,
        noise: PoseNoise,
        situation: &Situation,
        played: impl Fn(RobotTime, RobotTime) -> bool,
    ) -> Option<Finding> {
        let shows = |time: f64| {
            move |sums: &Sums| {
                let enough = sums.early >= SHOWS_STUCK * sd(kind, noise);
                sums.span >= time && sums.early > 0.0 && enough
            }
        };
        // What is left of a turn one way and a turn the other way may come to nothing together.
        let is_still = |sums: &Sums| {
            let noise = NOISE_A_CELL * sd(kind, noise) * f64::from(sums.cells);
            sums.covered - noise < ELSEWHERE * sums.early
        };
        let recent = self.evidence.is_settled();
        let recent = recent.then(|| self.evidence.latest_settled(kind, shows(STUCK_TIME)));
        let to_and_fro = self.evidence.latest(kind, shows(TO_AND_FRO_TIME)).filter(is_still);
        let mut finding = Finding::Nothing;
        for sums in recent.flatten().into_iter().chain(to_and_fro) {
            let (along, any) = shares(kind, settings, &sums, sums.early);
            let stands = along < MOVED && any < ELSEWHERE;
            let creeps = situation.creeps && along < CREEPS && any < HEALTHY;
            if stands || creeps {
                let (from, to) = sums.times;
                if !played(from, to - UNDESCRIBED_DELAY) {
                    return None;
                }
                let how = if stands { How::Stood } else { How::Crept };
                return Some(self.stands(settings, kind, &sums, situation.now, how));
            }
            if along >= MOVES {
                self.raise.succeeded();
            }
            if along >= HEALTHY {
                let top = &mut self.top[kind as usize];
                // It may be the last of the commands that moved it.
                *top = sums.fastest.max(TOP_MEMORY * *top);
                finding = Finding::Healthy;
            }
        }
        Some(finding)
    }

    /// The robot stands, or as good as: raises its smallest speed where that may help.
    fn stands(
        &mut self,
        settings: &Settings,
        kind: Kind,
        sums: &Sums,
        now: RobotTime,
        how: How,
    ) -> Finding {
        let full = full(settings);
        let (fastest, index) = match kind {
            Kind::Drive => (full.linear, 0),
            Kind::Turn => (full.angular, 2),
        };
        let is_full = sums.peak >= fast(settings, self.top, kind);
        if is_full && how == How::Crept {
            return Finding::Nothing;
        }
        if is_full || self.raise.is_over(kind, now) {
            let Sums { commanded, span, seen, .. } = *sums;
            let turning = kind == Kind::Turn;
            return self.hold(Alarm::Stuck(Compared {
                turning,
                commanded,
                seen: seen[index],
                span,
            }));
        }
        self.raised(kind, sums.peak, fastest, now, how)
    }

    fn raised(
        &mut self,
        kind: Kind,
        stood: f64,
        fastest: f64,
        now: RobotTime,
        how: How,
    ) -> Finding {
        let least = self.raise.step(kind, now, stood, fastest, how);
        let alarm = Alarm::Raised { turning: kind == Kind::Turn, stood, least };
        self.remark = self.remark.filter(|it| it.condition() != Condition::Raised).or(Some(alarm));
        self.evidence.clear();
        Finding::Raised(alarm)
    }

    /// Equal poses, and the camera may have no noise: the robot may stand in a dead band.
    pub(super) fn try_full(&mut self, settings: &Settings, now: RobotTime) -> Finding {
        let (full, (linear, angular)) = (full(settings), self.still.fastest);
        // Of unequal wheels a turn in place has a speed that is none.
        if linear > NO_SPEED * full.linear {
            self.raised(Kind::Drive, linear, full.linear, now, How::AtOnce)
        } else {
            self.raised(Kind::Turn, angular, full.angular, now, How::AtOnce)
        }
    }

    /// Whether the robot moves against or beside the command, and from when to when it was looked at.
    fn mismatch(
        &self,
        settings: &Settings,
        kind: Kind,
        noise: PoseNoise,
        heading: f64,
    ) -> Option<(Alarm, (RobotTime, RobotTime))> {
        let drive = &settings.drive;
        let half = drive.track_width / 2.0;
        let sums = self.evidence.latest_settled(kind, |sums| {
            sums.span >= MISMATCH_TIME && sums.commanded >= TELLS_MISMATCH * sd(kind, noise)
        })?;
        let response = response(kind, settings, &sums);
        let [forward, left, turned] = response;
        let is_wrong = match kind {
            Kind::Drive => {
                forward < BACK
                    || (left.abs() >= BESIDE && forward < ALONG)
                    || (turned.abs() >= BESIDE && forward < NO_TURN)
            }
            Kind::Turn => {
                let shows = half * sums.commanded >= TELLS_MISMATCH * noise.position;
                turned < TURNED_BACK || (shows && forward.abs() >= BESIDE && turned < NO_TURN)
            }
        };
        if !is_wrong {
            return None;
        }
        let other = match kind {
            Kind::Drive => Kind::Turn,
            Kind::Turn => Kind::Drive,
        };
        let beside = self.evidence.latest(other, |sums| {
            sums.span >= UNDESCRIBED_DELAY && sums.commanded >= TELLS_MISMATCH * sd(other, noise)
        });
        let beside = beside.map(|sums| self::response(other, settings, &sums));
        let (fit, seen) = match kind {
            Kind::Drive => (Fit::of(Some(response), beside, heading), sums.seen[0]),
            Kind::Turn => (Fit::of(beside, Some(response), heading), sums.seen[2]),
        };
        let Sums { commanded, span, times, .. } = sums;
        let compared = Compared { turning: kind == Kind::Turn, commanded, seen, span };
        Some((Alarm::FrameMismatch { compared, fit }, times))
    }

    /// Whether the robot is on its way, and gets on.
    fn look_at_way(
        &mut self,
        settings: &Settings,
        noise: PoseNoise,
        situation: &Situation,
    ) -> Finding {
        if let Some((deviation, limit)) = situation.path {
            if deviation <= limit {
                self.leave = None;
            }
            let is_off = deviation > self.leave.unwrap_or(limit);
            self.off_path = if is_off { self.off_path + 1 } else { 0 };
            if self.off_path >= LOOKS_OFF_PATH {
                return self.hold(Alarm::OffPath { deviation, limit });
            }
        }
        let now = situation.now;
        let idle = match situation.goal {
            Some(goal) => self.advance.push(goal, noise.position, now),
            None => {
                self.advance.pause();
                0.0
            }
        };
        let jumping = self.jumps.many(now).map(|(jumps, of)| Alarm::Jumping { jumps, of });
        let oddity = situation.oddity.or_else(|| self.shift_of(settings, noise));
        let odd = jumping.or(oddity.map(Alarm::NotAsDescribed));
        let Some(odd) = odd else {
            self.remark = self.remark.filter(|it| it.condition() == Condition::Raised);
            return Finding::Nothing;
        };
        if idle >= NO_ADVANCE {
            return self.hold(odd);
        }
        let is_news = self.remark.is_none_or(|it| it.condition() != odd.condition());
        self.remark = Some(odd);
        if is_news { Finding::Remark(odd) } else { Finding::Nothing }
    }

    /// How far the tracked point moves per radian turned in place, where that is too far.
    fn shift_of(&mut self, settings: &Settings, noise: PoseNoise) -> Option<Oddity> {
        let Shift { commanded, turned, moved: [ahead, aside] } = self.shift;
        let track = settings.drive.track_width;
        let allowed = SHIFT * track;
        let shows = turned >= SHIFT_TURNED && TELLS_MISMATCH * noise.position <= allowed * turned;
        let shift = ahead.hypot(aside) / turned.max(SHIFT_TURNED);
        if !shows || shift <= allowed {
            return None;
        }
        // One wheel that stands leaves half the turn, about itself: the middle moves by half the track per radian.
        let is_half = |part: f64| (part - 0.5).abs() < ABOUT_HALF;
        let about_wheel = is_half(ahead.abs() / (turned * track)) && is_half(turned / commanded);
        Some(if about_wheel && aside.abs() < ABOUT_HALF * ahead.abs() {
            Oddity::OneWheel { left: ahead > 0.0 }
        } else {
            Oddity::ShiftPerRadian(shift)
        })
    }
}

/// The speeds at which the robot drives and turns where nothing slows it down.
fn full(settings: &Settings) -> Twist {
    let Settings { drive, steering, .. } = settings;
    let linear = drive.limited(Twist::new(drive.max_linear.min(steering.alpha), 0.0)).linear;
    Twist::new(linear, drive.limited(Twist::new(0.0, drive.max_angular)).angular)
}

/// The speed from which raising it is no use: next to the full one, or to that at which the robot was seen to move and
/// which is no creeping.
pub(super) fn fast(settings: &Settings, top: [f64; 2], kind: Kind) -> f64 {
    let (full, drive) = (full(settings), &settings.drive);
    let (full, least) = match kind {
        Kind::Drive => (full.linear, drive.min_linear),
        Kind::Turn => (full.angular, drive.min_angular),
    };
    let top = top[kind as usize];
    let enough = FULL * full;
    if top > 0.0 { enough.min(AS_FAST * top.max(CREEP * least)) } else { enough }
}

/// Noise of a pose in the units of the motion.
fn sd(kind: Kind, noise: PoseNoise) -> f64 {
    match kind {
        Kind::Drive => noise.position,
        Kind::Turn => noise.heading,
    }
}

/// What was seen per `commanded` motion: along it, and in any direction.
fn shares(kind: Kind, settings: &Settings, sums: &Sums, commanded: f64) -> (f64, f64) {
    let whole = response(kind, settings, sums).map(|it| it * sums.commanded / commanded);
    let along = match kind {
        Kind::Drive => whole[0],
        Kind::Turn => whole[2],
    };
    (along, whole.iter().map(|it| it * it).sum::<f64>().sqrt())
}

/// What was seen per unit commanded.
fn response(kind: Kind, settings: &Settings, sums: &Sums) -> Response {
    let half = settings.drive.track_width / 2.0;
    let unit = match kind {
        Kind::Drive => sums.commanded,
        Kind::Turn => half * sums.commanded,
    };
    let [forward, left, turned] = sums.seen;
    [forward / unit, left / unit, half * turned / unit]
}
