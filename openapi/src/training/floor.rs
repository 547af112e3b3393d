//! The floor of a simulated environment.

use crate::check::{Check, Range, Validate};
use crate::named::NameOr;
use crate::schema::ToSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// At -1 the robot would not move, at 1 twice as far; no floor does either.
pub const SLIP_MEAN: Range = Range::new(-0.999, 0.999, "");
/// Ten times what any floor that was recorded does.
pub const SLIP_SD: Range = Range::new(0.0, 4.0, "");

/// The floors that have a name, roughly from the best to the worst.
pub const FLOORS: [&str; 8] =
    ["none", "hard", "loaded", "dusty", "slippery", "oily", "towing", "ramp"];

/// One ratio error of the commanded motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = SlipChannel)]
pub struct SlipChannel {
    /// Its mean; -0.1 is a tenth less far.
    pub mean: f64,
    /// Its standard deviation over 100 ms.
    pub sd: f64,
}

impl Validate for SlipChannel {
    fn check(&self, check: &mut Check) {
        check.number("mean", self.mean, SLIP_MEAN);
        check.number("sd", self.sd, SLIP_SD);
    }
}

/// What a floor adds to the commanded motion, in the body frame. A channel that is left out has no error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = TrainingSlip)]
pub struct Slip {
    /// Forward error per metre commanded.
    pub forward: SlipChannel,
    /// Lateral error per metre commanded, to the left.
    pub lateral: SlipChannel,
    /// Heading error per radian commanded.
    pub turn: SlipChannel,
    /// Heading error in rad per metre commanded, to the left.
    pub drift: SlipChannel,
}

impl Validate for Slip {
    fn check(&self, check: &mut Check) {
        check.field("forward", |check| self.forward.check(check));
        check.field("lateral", |check| self.lateral.check(check));
        check.field("turn", |check| self.turn.check(check));
        check.field("drift", |check| self.drift.check(check));
    }
}

/// A floor: the name of a preset, or its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = TrainingFloor)]
pub enum Floor {
    /// One of `none`, `hard`, `dusty`, `slippery`, `oily`, `loaded`, `ramp`; a later version may know more.
    Preset(String),
    /// Its numbers.
    Slip(Slip),
}

impl<'de> Deserialize<'de> for Floor {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match NameOr::read(deserializer, "the name of a floor, or an object with its slip")? {
            NameOr::Name(name) => Self::Preset(name),
            NameOr::Thing(slip) => Self::Slip(slip),
        })
    }
}

impl Floor {
    pub(super) fn check(&self, field: &str, check: &mut Check) {
        match self {
            Self::Slip(slip) => check.field(field, |check| slip.check(check)),
            Self::Preset(name) => check.preset(field, name, &FLOORS),
        }
    }
}
