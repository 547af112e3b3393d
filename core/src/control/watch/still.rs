//! Poses that are equal bit for bit: a tracker that repeats its last pose, or a robot that stands before a camera without
//! noise.

use super::evidence::Step;
use crate::geometry::Pose;
use crate::kinematics::Drive;

/// Time in s commanded to move under equal poses after which the poses are frozen, where the camera has noise or the
/// command was fast: what is left of 2 s to come to rest are the loop delay and the ramp.
const FROZEN: f64 = 0.8;

/// The same where it may be a slow robot that stands before a camera without noise: it gets a try at full speed first.
const FROZEN_SLOW: f64 = 1.3;

/// When that try begins: the rest of the time is for the ramp up and for the pose that shows it.
const TRIED: f64 = 0.5;

/// Rest in s after which a robot stands, whatever delay of it was not described.
const STANDS: f64 = 0.5;

/// Unequal poses of a standing robot after which the camera has noise.
const NOISY: u32 = 3;

/// Part of the smallest speeds above which a robot is commanded to move.
const COMMANDED: f64 = 0.5;

/// What equal poses say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stillness {
    /// Nothing.
    Fine,
    /// The robot may stand: try it at full speed.
    Try,
    /// The tracker repeats its pose.
    Frozen,
}

/// The run of equal poses, and whether the camera has noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Still {
    /// Equal poses in a row.
    pub poses: u32,
    /// Time in s commanded to move since the first of them.
    pub commanded: f64,
    /// Fastest speeds in m/s and rad/s meanwhile.
    pub fastest: (f64, f64),
    /// Time in s since the last command to move.
    rest: f64,
    /// Whether it ever was commanded to move: before, it stands.
    was_commanded: bool,
    /// Unequal poses seen of the standing robot.
    noisy: u32,
    tried: bool,
}

impl Still {
    /// Forgets the run; what is known of the camera stays.
    pub fn clear(&mut self) {
        let Self { noisy, was_commanded, .. } = *self;
        *self = Self { noisy, was_commanded, ..Self::default() };
    }

    /// Takes in a step; `full` says the speeds in m/s and rad/s that count as fast.
    pub fn push(
        &mut self,
        drive: &Drive,
        step: &Step,
        full: impl FnOnce() -> (f64, f64),
    ) -> Stillness {
        let span = step.to.taken - step.from.taken;
        let speeds = (step.commanded.forward.abs() / span, step.commanded.turn.abs() / span);
        let is_commanded =
            speeds.0 >= COMMANDED * drive.min_linear || speeds.1 >= COMMANDED * drive.min_angular;
        self.was_commanded |= is_commanded;
        self.rest = if is_commanded { 0.0 } else { self.rest + span };
        if !is_same(step.from.pose, step.to.pose) {
            if self.rest > STANDS || !self.was_commanded {
                self.noisy = self.noisy.saturating_add(1);
            }
            (self.poses, self.commanded, self.fastest, self.tried) = (1, 0.0, (0.0, 0.0), false);
            return Stillness::Fine;
        }
        self.poses = self.poses.saturating_add(1);
        if !is_commanded {
            return Stillness::Fine;
        }
        self.commanded += span;
        self.fastest = (self.fastest.0.max(speeds.0), self.fastest.1.max(speeds.1));
        let full = full();
        let is_fast = self.fastest.0 >= full.0 || self.fastest.1 >= full.1;
        let cannot_stand = self.noisy >= NOISY || (is_fast && !self.tried);
        if self.commanded >= if cannot_stand { FROZEN } else { FROZEN_SLOW } {
            Stillness::Frozen
        } else if self.commanded >= TRIED && !self.tried && !cannot_stand {
            self.tried = true;
            Stillness::Try
        } else {
            Stillness::Fine
        }
    }
}

fn is_same(one: Pose, other: Pose) -> bool {
    let bits = |pose: Pose| [pose.x, pose.y, pose.heading.radians()].map(f64::to_bits);
    bits(one) == bits(other)
}
