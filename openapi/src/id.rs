//! Names of resources.

use crate::problem::{Detail, Problems, reason};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use utoipa::ToSchema;

/// Longest id: that of a DNS label, so that an id can be a host name.
pub const MAX_ID_LENGTH: usize = 63;

/// The id of a robot: 1 to 63 of `a-z`, `0-9` and `-`.
///
/// ```
/// use umwelt_api::RobotId;
/// let id: RobotId = "rover-7".parse()?;
/// assert_eq!(id.as_str(), "rover-7");
/// assert!("Rover 7".parse::<RobotId>().is_err());
/// # Ok::<(), umwelt_api::InvalidId>(())
/// ```
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "String", into = "String")]
#[schema(value_type = String, pattern = "^[a-z0-9-]{1,63}$", min_length = 1, max_length = 63)]
pub struct RobotId(Arc<str>);

/// A text that is no id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an id is 1 to 63 of a-z, 0-9 and -, not {0:?}")]
pub struct InvalidId(pub String);

impl RobotId {
    /// The id as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for RobotId {
    type Err = InvalidId;

    fn from_str(text: &str) -> Result<Self, InvalidId> {
        let allowed = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'-');
        if (1..=MAX_ID_LENGTH).contains(&text.len()) && text.bytes().all(allowed) {
            Ok(Self(text.into()))
        } else {
            Err(InvalidId(text.to_owned()))
        }
    }
}

impl TryFrom<String> for RobotId {
    type Error = InvalidId;

    fn try_from(text: String) -> Result<Self, InvalidId> {
        text.parse()
    }
}

impl From<RobotId> for String {
    fn from(id: RobotId) -> Self {
        id.as_str().to_owned()
    }
}

impl AsRef<str> for RobotId {
    fn as_ref(&self) -> &str {
        self.as_str()
    }
}

impl std::borrow::Borrow<str> for RobotId {
    fn borrow(&self) -> &str {
        self.as_str()
    }
}

impl fmt::Display for RobotId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for RobotId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl From<InvalidId> for Problems {
    /// The id as it stands in a path: field `robot`.
    fn from(invalid: InvalidId) -> Self {
        Detail::new(reason::INVALID_ID, "robot", invalid.0, "use 1 to 63 of a-z, 0-9 and -").into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_lower_case_digits_and_hyphens() {
        for good in ["a", "7", "-", "rover-7", &"x".repeat(63)] {
            assert_eq!(good.parse::<RobotId>().map(|id| id.to_string()), Ok(good.to_owned()));
        }
        for bad in ["", "A", "a b", "a/b", "ä", "a\n", "..", "a_b", &"x".repeat(64)] {
            assert!(bad.parse::<RobotId>().is_err(), "{bad:?}");
            assert!(serde_json::from_value::<RobotId>(bad.into()).is_err(), "{bad:?}");
        }
    }
}
