//! What a check came to.

use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is wrong. See `docs/check.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = CheckFault)]
pub enum Fault {
    /// No poses come, or no more of them.
    NoPoses,
    /// Too few poses a second to see the motions.
    TooFewPoses,
    /// The stamps of the poses are of another clock.
    OtherClock,
    /// The robot was seen farther away than the wiggle takes it.
    TooFar,
    /// Nothing moves.
    DoesNotMove,
    /// It turns and does not drive.
    DoesNotDrive,
    /// It drives and does not turn.
    DoesNotTurn,
    /// It turns, and the heading stays the same.
    HeadingFixed,
    /// Positions are in millimetres.
    PositionsInMillimetres,
    /// Positions are in centimetres.
    PositionsInCentimetres,
    /// The heading is in degrees.
    HeadingInDegrees,
    /// The left wheel runs backward.
    LeftWheelInverted,
    /// The right wheel runs backward.
    RightWheelInverted,
    /// Both wheels run backward, or the heading is half a turn off and an axis mirrored.
    BothWheelsInverted,
    /// The wheels are swapped, or an axis of positions and heading is mirrored.
    WheelsSwapped,
    /// The left wheel does not turn.
    LeftWheelStands,
    /// The right wheel does not turn.
    RightWheelStands,
    /// The heading is half a turn off, or both wheels are inverted and swapped.
    HeadingHalfTurnOff,
    /// The heading is a quarter of a turn off.
    HeadingQuarterTurnOff,
    /// The heading is off by something else.
    HeadingOff,
    /// The heading counts clockwise.
    HeadingClockwise,
    /// Positions are mirrored in x, their heading is not.
    XMirrored,
    /// Positions are mirrored in y, their heading is not.
    YMirrored,
    /// Positions have x and y exchanged, their heading has not.
    AxesExchanged,
    /// Motion comes later after its command than described, or sooner.
    Delay,
    /// The poses are noisier than described.
    Noise,
    /// It moves as with wheels of another radius.
    WheelRadius,
    /// It turns as with another track width.
    TrackWidth,
    /// The motions fit nothing of all this.
    Unclear,
    /// Something of a later version.
    #[serde(other)]
    Other,
}

impl Fault {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoPoses => "no-poses",
            Self::TooFewPoses => "too-few-poses",
            Self::OtherClock => "other-clock",
            Self::TooFar => "too-far",
            Self::DoesNotMove => "does-not-move",
            Self::DoesNotDrive => "does-not-drive",
            Self::DoesNotTurn => "does-not-turn",
            Self::HeadingFixed => "heading-fixed",
            Self::PositionsInMillimetres => "positions-in-millimetres",
            Self::PositionsInCentimetres => "positions-in-centimetres",
            Self::HeadingInDegrees => "heading-in-degrees",
            Self::LeftWheelInverted => "left-wheel-inverted",
            Self::RightWheelInverted => "right-wheel-inverted",
            Self::BothWheelsInverted => "both-wheels-inverted",
            Self::WheelsSwapped => "wheels-swapped",
            Self::LeftWheelStands => "left-wheel-stands",
            Self::RightWheelStands => "right-wheel-stands",
            Self::HeadingHalfTurnOff => "heading-half-turn-off",
            Self::HeadingQuarterTurnOff => "heading-quarter-turn-off",
            Self::HeadingOff => "heading-off",
            Self::HeadingClockwise => "heading-clockwise",
            Self::XMirrored => "x-mirrored",
            Self::YMirrored => "y-mirrored",
            Self::AxesExchanged => "axes-exchanged",
            Self::Delay => "delay",
            Self::Noise => "noise",
            Self::WheelRadius => "wheel-radius",
            Self::TrackWidth => "track-width",
            Self::Unclear => "unclear",
            Self::Other => "other",
        }
    }
}

/// Something that is wrong, and what to do about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CheckFinding)]
pub struct Finding {
    /// What is wrong.
    pub name: Fault,
    /// What was seen, in words and numbers.
    pub seen: String,
    /// What to do about it.
    pub remedy: String,
}

/// The report of a check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CheckReport)]
pub struct Report {
    /// What is wrong, the gravest first; empty where all is well.
    pub findings: Vec<Finding>,
    /// Time from a command to its motion; null where no motion was seen.
    #[serde(default)]
    pub delay_s: Option<f64>,
    /// The same as described: dead time and lag.
    #[serde(serialize_with = "number::finite")]
    pub described_delay_s: f64,
    /// Standard deviation of the positions at rest, per axis; null where there were too few.
    #[serde(default)]
    pub noise_position_m: Option<f64>,
    /// Standard deviation of the heading at rest.
    #[serde(default)]
    pub noise_heading_rad: Option<f64>,
    /// Distance driven per metre commanded; null where it could not be measured.
    #[serde(default)]
    pub forward_ratio: Option<f64>,
    /// Angle turned per radian commanded, negative where it turns the other way.
    #[serde(default)]
    pub turn_ratio: Option<f64>,
    /// Poses per second.
    #[serde(serialize_with = "number::finite")]
    pub poses_per_second: f64,
    /// Time that the check took.
    #[serde(serialize_with = "number::finite")]
    pub span_s: f64,
}

impl Report {
    /// Whether nothing is wrong.
    pub fn is_well(&self) -> bool {
        self.findings.is_empty()
    }
}
