//! What the robot itself allows: followed, and said on the log.

use crate::throttle::Throttle;
use tracing::{info, warn};
use umwelt_core::kinematics::Drive;
use umwelt_core::local::LocalLimits;

/// What the robot itself allows now. Each kind of change is said at most every other second: a hold of a moment is said
/// with its end.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Restraint {
    said: LocalLimits,
    limits: LocalLimits,
    holds: Throttle,
    releases: Throttle,
    speeds: Throttle,
}

impl Restraint {
    /// What holds for a robot with `drive`. A speed at which no motor turns is a hold here and for the server, whatever
    /// drive that was told.
    pub(crate) fn limits(&self) -> LocalLimits {
        self.limits
    }

    /// What it says means for a robot with `drive`.
    pub(crate) fn describe(&mut self, drive: &Drive) {
        self.limits = LocalLimits { hold: self.said.is_hold(drive), ..self.said };
    }

    /// Takes in what the drive says at robot time `now`; whether that is a change.
    pub(crate) fn take(&mut self, now: f64, said: LocalLimits, drive: &Drive) -> bool {
        if said == self.said {
            return false;
        }
        let was_held = self.limits.hold;
        self.said = said;
        self.limits = LocalLimits { hold: said.is_hold(drive), ..said };
        let max_speed = said.max_speed;
        match (was_held, self.limits.hold) {
            (false, true) => {
                if let Some(unsaid) = self.holds.ask(now) {
                    warn!(unsaid, max_speed, "the robot itself holds: ramping to rest");
                }
            }
            (true, false) => {
                if let Some(unsaid) = self.releases.ask(now) {
                    info!(unsaid, max_speed, "the robot itself no longer holds");
                }
            }
            _ => {
                if let Some(unsaid) = self.speeds.ask(now) {
                    info!(unsaid, max_speed, "the robot itself allows another speed");
                }
            }
        }
        true
    }
}
