//! What the robot itself allows, as the controller hears of it, and for how long it went its own way.
//!
//! While it did, its commands say nothing about how it moved: no window of motion that touches that time is used.

use crate::exchange::Request;
use crate::geometry::Twist;
use crate::kinematics::Drive;
use crate::local::LocalLimits;
use crate::time::RobotTime;

/// Time in s after which a robot that never reports what it plays counts as following its commands again.
const REPORTED_BY: f64 = 2.0;

/// What a request means for the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Nothing.
    None,
    /// The robot rests on its own, and has dropped its commands.
    Rests,
    /// It goes on from where it stands.
    GoesOn,
}

/// A stretch of robot time in which the robot did something else than commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Away {
    /// It followed its commands then, for the last time.
    from: RobotTime,
    /// When the newest request that changed what it allows was sent, and its sequence.
    asked: RobotTime,
    sequence: u64,
    /// From then on it follows its commands again; none as long as it plays no horizon that was planned for that.
    until: Option<RobotTime>,
}

/// What was heard of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Heard {
    limits: LocalLimits,
    /// Whether it is to rest, by its drive and what it allows.
    is_held: bool,
    /// When the last request was sent.
    sent: Option<RobotTime>,
    /// Whether it played a horizon then.
    was_playing: bool,
    away: Option<Away>,
}

impl Heard {
    /// Takes in what a request says.
    pub(super) fn take(&mut self, request: &Request, drive: &Drive) -> Change {
        let (was_held, limits) = (self.is_held, request.limits);
        let is_held = limits.is_hold(drive);
        // Also a hold of which no request came through.
        let let_go = self.was_playing && request.playing.is_none();
        if is_held || was_held || let_go || limits != self.limits {
            let from = self.away.filter(|away| away.until.is_none()).map(|away| away.from);
            self.away = Some(Away {
                from: from.or(self.sent).unwrap_or(request.sent),
                asked: request.sent,
                sequence: request.sequence,
                until: None,
            });
        } else if let Some(away) = &mut self.away
            && away.until.is_none()
        {
            // The ramp from one speed to another is not what either plan says.
            let ramp = drive.stopping_time(Twist::new(drive.max_linear, drive.max_angular));
            away.until = match request.playing {
                Some(playing) if playing.horizon >= away.sequence => Some(playing.since + ramp),
                _ => (request.sent >= away.asked + REPORTED_BY).then_some(request.sent),
            };
        }
        self.limits = limits;
        self.is_held = is_held;
        self.sent = Some(request.sent);
        self.was_playing = request.playing.is_some();
        match (was_held, is_held) {
            (false, true) => Change::Rests,
            (true, false) => Change::GoesOn,
            _ if let_go => Change::Rests,
            _ => Change::None,
        }
    }

    /// Whether the robot holds.
    pub(super) fn is_held(&self) -> bool {
        self.is_held
    }

    /// What the robot allows.
    pub(super) fn limits(&self) -> LocalLimits {
        self.limits
    }

    /// `drive` with the speed that the robot allows; none where that is its own.
    pub(super) fn slowed(&self, drive: &Drive) -> Option<Drive> {
        let max = self.limits.max_speed.filter(|max| *max < drive.max_linear && !self.is_held)?;
        Some(Drive { max_linear: max, ..*drive })
    }

    /// Whether the robot went its own way at any time from `from` to `to`.
    pub(super) fn was_away(&self, from: RobotTime, to: RobotTime) -> bool {
        self.away.is_some_and(|away| to > away.from && away.until.is_none_or(|until| from < until))
    }
}

#[cfg(test)]
mod tests;
