//! A change of plans spread within the acceleration limits.

use crate::geometry::Twist;
use crate::geometry::elementary::{least, most};
use crate::horizon::{RAMP_STEP, SLOT};
use crate::kinematics::Drive;
use crate::time::RobotTime;

/// A twist that follows what is demanded as far as the acceleration limits allow.
///
/// Commands of one plan keep the limits already, slot by slot: so up to one slot of acceleration time is saved up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slew {
    output: Twist,
    /// Acceleration time in s that is not used up yet, at most one slot.
    credit: f64,
    settled: bool,
}

impl Slew {
    /// At `output` for long.
    pub const fn new(output: Twist) -> Self {
        Self { output, credit: SLOT, settled: true }
    }

    /// The twist now.
    pub const fn output(&self) -> Twist {
        self.output
    }

    /// Whether it is what was demanded last.
    pub const fn is_settled(&self) -> bool {
        self.settled
    }

    /// What was put out so far comes to be `output` for the same wheel speeds, of another drive.
    pub fn becomes(&mut self, output: Twist) {
        (self.output, self.settled) = (output, false);
    }

    /// Lets the time from `from` to `until` pass.
    pub fn wait(&mut self, from: RobotTime, until: RobotTime) {
        self.credit = least(SLOT, until + self.credit - from);
    }

    /// Moves toward `demand` as far as the unused acceleration time allows.
    pub fn toward(&mut self, drive: &Drive, demand: Twist) -> Twist {
        let needed = drive.change_time(self.output, demand);
        // The tolerance covers rounding in plans that use the limit to the full.
        self.settled = needed <= self.credit + 1e-6;
        if self.settled {
            self.credit = most(0.0, self.credit - needed);
            self.output = demand;
        } else {
            let share = self.credit / needed;
            self.credit = 0.0;
            self.output = drive.part_way(self.output, demand, share);
        }
        self.output
    }

    /// Calls `each` with the twists that hold in turn, and for how many s, where `demand` holds for `duration` s.
    pub fn hold(
        &mut self,
        drive: &Drive,
        demand: Twist,
        duration: f64,
        mut each: impl FnMut(Twist, f64),
    ) {
        let mut left = duration;
        while left > 0.0 {
            let output = self.toward(drive, demand);
            let step = if self.settled { left } else { least(left, RAMP_STEP) };
            each(output, step);
            self.wait(RobotTime::ZERO, RobotTime::new(step));
            left -= step;
        }
    }
}
