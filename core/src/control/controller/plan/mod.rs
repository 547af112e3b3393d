//! The plan: the whole task rolled forward on the predicted pose, one slot at a time, transitions included.

mod approach;
mod decide;
mod mend;
mod phase;
mod ramp;
mod roll;
mod sight;
mod square;
mod straight;

pub use phase::{Phase, Phases, REST_SLOTS};
pub use roll::Start;

use super::compensation::PathFollower;
use crate::geometry::{Twist, WheelSpeeds};
use crate::horizon::MAX_SLOTS;
use crate::prediction::{ErrorModel, Prediction};
use crate::settings::Settings;
use crate::task::{Limit, Task};
use crate::watch::Floors;
use arrayvec::ArrayVec;
use roll::Roll;

/// What a plan keeps to.
pub struct Rules<'a, F> {
    /// The settings.
    pub settings: &'a Settings,
    /// How it drives to a point.
    pub follower: &'a F,
    /// What was learned of the smallest speeds.
    pub floors: &'a Floors,
}

/// Rolls the task forward from the pose predicted at the start: wheel speeds per slot into `speeds`, the phases that they
/// lead through into `phases`.
/// Both are large and stay in place: a plan is made in every slot. Returns what limits the speed in the first one.
pub fn plan<F: PathFollower>(
    rules: Rules<F>,
    model: &ErrorModel,
    task: Option<&Task>,
    start: Start,
    prediction: Prediction,
    speeds: &mut ArrayVec<WheelSpeeds, MAX_SLOTS>,
    phases: &mut Phases,
) -> Option<Limit> {
    speeds.clear();
    phases.clear();
    let predictions = [prediction.clone(), prediction];
    let Rules { settings, follower, floors } = rules;
    let least = floors.raised(&settings.drive);
    let mut roll = Roll {
        settings,
        follower,
        floors,
        least: Twist::new(least.min_linear, least.min_angular),
        model,
        task,
        state: start,
        predictions,
        now: 0,
        limit: None,
    };
    let mut limit = None;
    for slot in 0..settings.slots.clamp(1, MAX_SLOTS) {
        phases.push(roll.state.phase);
        speeds.push(roll.next(slot));
        if slot == 0 {
            limit = roll.limit;
        }
    }
    phases.push(roll.state.phase);
    limit
}
