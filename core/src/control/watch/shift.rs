//! Whether the tracked point is the middle of the axle: it stays where it is while the robot turns in place.

use serde::{Deserialize, Serialize};

/// Radians turned in place over which a shift is remembered: a slow turn counts as much as a fast one.
const SHIFT_MEMORY: f64 = 12.0;

/// How far the tracked point moves while the robot turns in place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shift {
    /// Radians that it was commanded to turn.
    pub commanded: f64,
    /// Radians that it turned.
    pub turned: f64,
    /// How far the point moved meanwhile, forward and to the left, in m.
    pub moved: [f64; 2],
}

impl Shift {
    /// Takes in a turn: what was commanded, and what was seen forward, to the left and turned.
    pub fn push(&mut self, commanded: f64, [forward, left, turned]: [f64; 3]) {
        let kept = 1.0 - (turned.abs() / SHIFT_MEMORY).min(1.0);
        let Self { commanded: before, turned: until, moved: [ahead, aside] } = *self;
        self.commanded = kept * before + commanded;
        self.turned = kept * until + turned.abs();
        self.moved = [kept * ahead + forward, kept * aside + left];
    }
}
