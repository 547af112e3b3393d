//! Poses that jump there and back, or are set aside in number.

use crate::time::RobotTime;

/// Poses looked back on.
const LOOKED_BACK: u32 = u32::BITS;

/// So many of them jumped: a quarter. A camera loses its robot now and then; a quarter of the time is no now and then.
const MANY: u32 = 8;

/// So many of them were set aside: three quarters, so that what is accepted is as likely chance.
const MOST: u32 = 24;

/// For so long in s: a burst of a fast camera is over by then.
const FOR: f64 = 2.0;

/// The same for [`MOST`]: the robot drives as good as blind.
const BLIND_FOR: f64 = 0.5;

/// The last poses: which of them jumped, which were set aside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jumps {
    jumped: u32,
    aside: u32,
    count: u32,
    many_since: Option<RobotTime>,
    most_since: Option<RobotTime>,
    /// Which way the last accepted pose jumped, if it did: ahead, aside, around.
    last: [i8; 3],
}

impl Jumps {
    /// Takes in a pose that was set aside at `taken`.
    pub fn set_aside(&mut self, taken: RobotTime) {
        self.push(true, true, taken);
    }

    /// Takes in an accepted pose that lies `off` by so many m ahead and aside and rad around from where it was expected,
    /// where `far` is what a robot can hardly have moved: m and rad. Only a jump back after one there counts: what goes on
    /// one way is the robot.
    pub fn accept(&mut self, off: [f64; 3], far: (f64, f64), taken: RobotTime) {
        let way = |off: f64, far: f64| {
            if off > far {
                1
            } else if off < -far {
                -1
            } else {
                0
            }
        };
        let ways = [way(off[0], far.0), way(off[1], far.0), way(off[2], far.1)];
        let is_back = ways.iter().zip(self.last).any(|(&now, before)| now * before < 0);
        self.last = ways;
        self.push(is_back, false, taken);
    }

    fn push(&mut self, is_jump: bool, is_aside: bool, taken: RobotTime) {
        self.jumped = self.jumped << 1 | u32::from(is_jump);
        self.aside = self.aside << 1 | u32::from(is_aside);
        self.count = (self.count + 1).min(LOOKED_BACK);
        let since = |holds: bool, since: Option<RobotTime>| holds.then(|| since.unwrap_or(taken));
        self.many_since = since(self.jumped.count_ones() >= MANY, self.many_since);
        self.most_since = since(self.aside.count_ones() >= MOST, self.most_since);
    }

    /// How many of how many, where poses jump.
    pub fn many(&self, now: RobotTime) -> Option<(u32, u32)> {
        let is_long = self.many_since.is_some_and(|since| now - since >= FOR);
        is_long.then(|| (self.jumped.count_ones(), self.count))
    }

    /// How many of how many, where next to all of them are set aside.
    pub fn most(&self, now: RobotTime) -> Option<(u32, u32)> {
        let is_long = self.most_since.is_some_and(|since| now - since >= BLIND_FOR);
        is_long.then(|| (self.aside.count_ones(), self.count))
    }
}
