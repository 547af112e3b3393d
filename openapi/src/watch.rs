//! What the watch over commanded and seen motion finds.

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is wrong. See `docs/watch.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = WatchState)]
pub enum State {
    /// Commanded to move and not seen to.
    Stuck,
    /// The same pose again and again, bit for bit, while commanded to move.
    Frozen,
    /// No accepted pose for too long; the robot goes on by itself when poses come.
    NoPoses,
    /// Moves against or beside the command.
    FrameMismatch,
    /// Too far from the path.
    OffPath,
    /// Poses jump there and back, or are set aside in number.
    Jumping,
    /// What the samples say cannot be the robot that was described.
    NotAsDescribed,
    /// The smallest speed was raised because the robot did not move at it.
    Raised,
    /// Something of a later version.
    #[serde(other)]
    Other,
}

impl State {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stuck => "stuck",
            Self::Frozen => "frozen",
            Self::NoPoses => "no-poses",
            Self::FrameMismatch => "frame-mismatch",
            Self::OffPath => "off-path",
            Self::Jumping => "jumping",
            Self::NotAsDescribed => "not-as-described",
            Self::Raised => "raised",
            Self::Other => "other",
        }
    }
}

/// What the watch finds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Watch)]
pub struct Watch {
    /// What is wrong.
    pub state: State,
    /// Whether the robot rests for it: until it is resumed or given another task, where poses are missing until they come.
    pub rests: bool,
    /// What was seen, in words and numbers.
    pub seen: String,
    /// What to do about it.
    pub remedy: String,
    /// Time since it was found; null where that was before the server started.
    #[serde(default)]
    pub since_s_ago: Option<f64>,
}

/// What limits a robot's speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = WatchLimit)]
pub enum Limit {
    /// The largest speeds of the drive.
    Drive,
    /// The steering law's speed, `steering.alpha_m_per_s`.
    Alpha,
    /// The waypoint or direction at which it is to stop.
    Waypoint,
    /// The largest acceleration.
    Acceleration,
    /// The predicted variance of the pose.
    Variance,
    /// The watch: the robot is to rest, or a smallest speed was raised.
    Watch,
    /// The robot itself, which says hold or a smaller largest speed.
    Hold,
    /// Something of a later version.
    #[serde(other)]
    Other,
}

impl Limit {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Drive => "drive",
            Self::Alpha => "alpha",
            Self::Waypoint => "waypoint",
            Self::Acceleration => "acceleration",
            Self::Variance => "variance",
            Self::Watch => "watch",
            Self::Hold => "hold",
            Self::Other => "other",
        }
    }
}
