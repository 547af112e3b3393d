//! What the watch over commanded and seen motion finds.

use serde::{Deserialize, Serialize};
use umwelt_core::task::Limit as CoreLimit;
use umwelt_core::watch::{Alarm, Condition};
use utoipa::ToSchema;

/// What is wrong. See `docs/watch.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = watch::State)]
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

impl From<Condition> for State {
    fn from(core: Condition) -> Self {
        match core {
            Condition::Stuck => Self::Stuck,
            Condition::Frozen => Self::Frozen,
            Condition::NoPoses => Self::NoPoses,
            Condition::FrameMismatch => Self::FrameMismatch,
            Condition::OffPath => Self::OffPath,
            Condition::Jumping => Self::Jumping,
            Condition::NotAsDescribed => Self::NotAsDescribed,
            Condition::Raised => Self::Raised,
        }
    }
}

/// What the watch finds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = watch::Watch)]
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

impl Watch {
    /// What was found `since_s_ago`.
    pub fn new(alarm: &Alarm, rests: bool, since_s_ago: Option<f64>) -> Self {
        let state = alarm.condition().into();
        Self { state, rests, seen: alarm.seen(), remedy: alarm.remedy().to_owned(), since_s_ago }
    }
}

/// What limits a robot's speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = watch::Limit)]
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

impl From<CoreLimit> for Limit {
    fn from(core: CoreLimit) -> Self {
        match core {
            CoreLimit::Drive => Self::Drive,
            CoreLimit::Alpha => Self::Alpha,
            CoreLimit::Waypoint => Self::Waypoint,
            CoreLimit::Acceleration => Self::Acceleration,
            CoreLimit::Variance => Self::Variance,
            CoreLimit::Watch => Self::Watch,
            CoreLimit::Hold => Self::Hold,
        }
    }
}

impl Limit {
    /// In core's terms; none for one of a later version.
    pub fn to_core(self) -> Option<CoreLimit> {
        Some(match self {
            Self::Drive => CoreLimit::Drive,
            Self::Alpha => CoreLimit::Alpha,
            Self::Waypoint => CoreLimit::Waypoint,
            Self::Acceleration => CoreLimit::Acceleration,
            Self::Variance => CoreLimit::Variance,
            Self::Watch => CoreLimit::Watch,
            Self::Hold => CoreLimit::Hold,
            Self::Other => return None,
        })
    }
}

impl State {
    /// In core's terms; none for one of a later version.
    pub fn to_core(self) -> Option<Condition> {
        Condition::ALL.into_iter().find(|condition| Self::from(*condition) == self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_wire_and_of_core() {
        for condition in Condition::ALL {
            let state = State::from(condition);
            let json = serde_json::to_value(state).unwrap();
            assert_eq!((json.as_str(), state.name()), (Some(condition.name()), condition.name()));
            assert_eq!(state.to_core(), Some(condition));
        }
        for limit in [Limit::Drive, Limit::Alpha, Limit::Waypoint, Limit::Acceleration] {
            assert_eq!(serde_json::to_value(limit).unwrap().as_str(), Some(limit.name()));
        }
        assert_eq!(serde_json::from_str::<State>("\"of-tomorrow\"").unwrap(), State::Other);
        assert_eq!(State::Other.to_core(), None);
    }
}
