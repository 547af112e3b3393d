//! The names of what the [watch](crate::watch) may find, with which a task's progress shows it.

use serde::{Deserialize, Serialize};

/// The name of what is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// Commanded and not moved.
    Stuck,
    /// The same pose again and again, bit for bit, while commanded to move.
    Frozen,
    /// No accepted pose for too long.
    NoPoses,
    /// Moves against or beside the command.
    FrameMismatch,
    /// Too far from the path.
    OffPath,
    /// Poses jump there and back, or are set aside in number.
    Jumping,
    /// What the samples say cannot be the robot that was described.
    NotAsDescribed,
    /// The smallest speed was raised because the robot did not move at it. A remark, never a reason to rest.
    Raised,
}

impl Condition {
    /// Every condition, in the order in which they are documented.
    pub const ALL: [Self; 8] = [
        Self::Stuck,
        Self::Frozen,
        Self::NoPoses,
        Self::FrameMismatch,
        Self::OffPath,
        Self::Jumping,
        Self::NotAsDescribed,
        Self::Raised,
    ];

    /// The name used on the wire.
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
        }
    }
}
