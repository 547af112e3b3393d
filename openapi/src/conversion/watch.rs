//! What the watch finds and what limits the speed.

use crate::watch::{Limit, State, Watch};
use umwelt_core::task::Limit as CoreLimit;
use umwelt_core::watch::{Alarm, Condition};

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

impl Watch {
    /// What was found `since_s_ago`.
    pub fn new(alarm: &Alarm, rests: bool, since_s_ago: Option<f64>) -> Self {
        let state = alarm.condition().into();
        Self { state, rests, seen: alarm.seen(), remedy: alarm.remedy().to_owned(), since_s_ago }
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
