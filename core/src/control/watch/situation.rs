//! What a look of the watch needs to know besides poses and commands.

use super::advance::Goal;
use super::alarm::Oddity;
use crate::time::RobotTime;

/// What a look needs to know besides poses and commands.
#[derive(Clone, Copy, Debug)]
pub struct Situation {
    /// When the newest pose was taken.
    pub now: RobotTime,
    /// Its heading in rad.
    pub heading: f64,
    /// Whether the variance rule slows the robot down.
    pub creeps: bool,
    /// Where it is to go, while it turns or drives there.
    pub goal: Option<Goal>,
    /// Its distance from the path and the largest one allowed, in m.
    pub path: Option<(f64, f64)>,
    /// What about the samples cannot be.
    pub oddity: Option<Oddity>,
}
