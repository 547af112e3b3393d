//! The floor of a simulated environment.

use crate::check::{Check, Checked, Range};
use crate::named::NameOr;
use crate::problem::Problems;
use serde::{Deserialize, Deserializer, Serialize};
use umwelt_core::plant::{self, MAX_SLIP_SD, SLIP_PRESETS, SlipError};
use utoipa::ToSchema;

/// At -1 the robot would not move, at 1 twice as far; no floor does either.
pub const SLIP_MEAN: Range = Range::new(-0.999, 0.999, "");
/// Ten times what any floor that was recorded does.
pub const SLIP_SD: Range = Range::new(0.0, MAX_SLIP_SD, "");

/// One ratio error of the commanded motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = training::SlipChannel)]
pub struct SlipChannel {
    /// Its mean; -0.1 is a tenth less far.
    pub mean: f64,
    /// Its standard deviation over 100 ms.
    pub sd: f64,
}

impl Checked for SlipChannel {
    fn check(&self, check: &mut Check) {
        check.number("mean", self.mean, SLIP_MEAN);
        check.number("sd", self.sd, SLIP_SD);
    }
}

impl From<plant::SlipChannel> for SlipChannel {
    fn from(core: plant::SlipChannel) -> Self {
        Self { mean: core.mean(), sd: core.sd() }
    }
}

impl SlipChannel {
    fn convert(self) -> Result<plant::SlipChannel, SlipError> {
        plant::SlipChannel::new(self.mean, self.sd)
    }
}

/// What a floor adds to the commanded motion, in the body frame. A channel that is left out has no error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = training::Slip)]
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

impl Checked for Slip {
    fn check(&self, check: &mut Check) {
        check.field("forward", |check| self.forward.check(check));
        check.field("lateral", |check| self.lateral.check(check));
        check.field("turn", |check| self.turn.check(check));
        check.field("drift", |check| self.drift.check(check));
    }
}

impl Slip {
    /// The slip in core's terms, whatever its ranges: what a program keeps was checked when it came.
    ///
    /// # Errors
    /// Where a channel is no slip at all.
    pub fn convert(self) -> Result<plant::Slip, SlipError> {
        Ok(plant::Slip {
            forward: self.forward.convert()?,
            lateral: self.lateral.convert()?,
            turn: self.turn.convert()?,
            drift: self.drift.convert()?,
        })
    }
}

/// A floor: the name of a preset, or its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = training::Floor)]
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
            Self::Preset(name) => check.preset(field, name, &SLIP_PRESETS),
        }
    }

    /// The floor in core's terms.
    ///
    /// # Errors
    /// An unknown preset, or every number that is out of its range; fields are named from `slip` on.
    pub fn to_core(&self) -> Result<plant::Slip, Problems> {
        let mut check = Check::default();
        self.check("slip", &mut check);
        let slip = match self {
            Self::Preset(name) => plant::Slip::preset(name),
            Self::Slip(slip) => check.ok("slip", slip.convert()),
        };
        check.finish()?;
        Ok(slip.unwrap_or_default())
    }
}

impl From<plant::Slip> for Slip {
    fn from(core: plant::Slip) -> Self {
        Self {
            forward: core.forward.into(),
            lateral: core.lateral.into(),
            turn: core.turn.into(),
            drift: core.drift.into(),
        }
    }
}

impl From<plant::Slip> for Floor {
    /// By its name where it is a preset.
    fn from(core: plant::Slip) -> Self {
        let preset = SLIP_PRESETS.into_iter().find(|name| plant::Slip::preset(name) == Some(core));
        preset.map_or_else(|| Self::Slip(core.into()), |name| Self::Preset(name.to_owned()))
    }
}
