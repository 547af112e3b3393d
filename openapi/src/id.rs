//! Names of resources.

use crate::problem::{Detail, Problems, reason};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// Longest id: that of a DNS label, so that an id can be a host name.
pub const MAX_ID_LENGTH: usize = 63;

/// A text that is no id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "an id is 1 to 63 of A-Z, a-z, 0-9, -, _ and ., the first a letter or a digit, not {text:?}"
)]
pub struct InvalidId {
    /// What it would have been the id of, as a path names it: `robot`, `prior`, ...
    pub of: &'static str,
    /// The text.
    pub text: String,
}

/// What to use instead of a text that is no id.
pub(crate) const REMEDY: &str =
    "use 1 to 63 of A-Z, a-z, 0-9, -, _ and ., the first a letter or a digit";

/// What an id matches that something new may have.
pub(crate) const PATTERN: &str = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$";

/// Whether something new may go by `text`: an id that begins with `-` looks like an option to whoever reads a command.
pub(crate) fn is_new_id(text: &str) -> bool {
    is_id(text) && !text.starts_with('-')
}

/// Whether `text` is an id. Earlier versions took those that begin with `-`, and what goes by one can still be named. One
/// that begins with a point would be hidden, or another folder; both are as serials, host names and ROS have it.
pub(crate) fn is_id(text: &str) -> bool {
    let allowed = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.');
    (1..=MAX_ID_LENGTH).contains(&text.len())
        && text.bytes().all(allowed)
        && !text.starts_with(['.', '_'])
}

fn parse(text: &str, of: &'static str) -> Result<Arc<str>, InvalidId> {
    if is_id(text) { Ok(text.into()) } else { Err(InvalidId { of, text: text.to_owned() }) }
}

impl From<InvalidId> for Problems {
    /// The id as it stands in a path: the field is the name of the parameter.
    fn from(invalid: InvalidId) -> Self {
        Detail::new(reason::INVALID_ID, invalid.of, invalid.text, REMEDY).into()
    }
}

/// The id of a robot: 1 to 63 of `A-Z`, `a-z`, `0-9`, `-`, `_` and `.`, the first a letter or a digit.
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
#[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$", min_length = 1, max_length = 63)]
pub struct RobotId(Arc<str>);

/// The name of a prior: 1 to 63 of `A-Z`, `a-z`, `0-9`, `-`, `_` and `.`, the first a letter or a digit.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "String", into = "String")]
#[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$", min_length = 1, max_length = 63)]
pub struct PriorId(Arc<str>);

/// The name of a simulated environment: 1 to 63 of `A-Z`, `a-z`, `0-9`, `-`, `_` and `.`, the first a letter or a digit.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "String", into = "String")]
#[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$", min_length = 1, max_length = 63)]
pub struct EnvironmentId(Arc<str>);

/// The id of an evolution, given by the server: `evolution-12`. Ids never come back.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "String", into = "String")]
#[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$", min_length = 1, max_length = 63)]
pub struct EvolutionId(Arc<str>);

/// The id of a comparison, given by the server: `comparison-12`. Ids never come back.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "String", into = "String")]
#[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$", min_length = 1, max_length = 63)]
pub struct ComparisonId(Arc<str>);

/// What every id can do: be read, be shown, be looked up by its text.
macro_rules! id {
    ($Id:ident, $of:literal) => {
        impl $Id {
            /// The id as text.
            pub fn as_str(&self) -> &str {
                &self.0
            }

            /// Whether something new may go by it: earlier versions took ids that begin with `-`.
            ///
            /// # Errors
            /// Where it begins with `-`.
            pub fn check_new(&self) -> Result<(), InvalidId> {
                if is_new_id(&self.0) {
                    Ok(())
                } else {
                    Err(InvalidId { of: $of, text: self.0.to_string() })
                }
            }
        }

        impl FromStr for $Id {
            type Err = InvalidId;

            fn from_str(text: &str) -> Result<Self, InvalidId> {
                parse(text, $of).map(Self)
            }
        }

        impl TryFrom<String> for $Id {
            type Error = InvalidId;

            fn try_from(text: String) -> Result<Self, InvalidId> {
                text.parse()
            }
        }

        impl From<$Id> for String {
            fn from(id: $Id) -> Self {
                id.as_str().to_owned()
            }
        }

        impl AsRef<str> for $Id {
            fn as_ref(&self) -> &str {
                self.as_str()
            }
        }

        impl std::borrow::Borrow<str> for $Id {
            fn borrow(&self) -> &str {
                self.as_str()
            }
        }

        impl fmt::Display for $Id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.as_str())
            }
        }

        impl fmt::Debug for $Id {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Debug::fmt(self.as_str(), f)
            }
        }
    };
}

id!(RobotId, "robot");
id!(PriorId, "prior");
id!(EnvironmentId, "environment");
id!(EvolutionId, "evolution");
id!(ComparisonId, "comparison");

impl EvolutionId {
    /// The id of the evolution of this number: `evolution-12`.
    pub fn numbered(number: u64) -> Self {
        Self(format!("evolution-{number}").into())
    }
}

impl ComparisonId {
    /// The id of the comparison of this number: `comparison-12`.
    pub fn numbered(number: u64) -> Self {
        Self(format!("comparison-{number}").into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_letters_digits_and_three_marks() {
        for good in ["a", "7", "-", "rover-7", "Rover_7.b", "X", "a.", &"x".repeat(63)] {
            assert_eq!(good.parse::<RobotId>().map(|id| id.to_string()), Ok(good.to_owned()));
        }
        for bad in
            ["", "a b", "a/b", "ä", "a\n", ".", "..", ".a", "_a", "a%2e", "a:b", &"x".repeat(64)]
        {
            assert!(bad.parse::<RobotId>().is_err(), "{bad:?}");
            assert!(serde_json::from_value::<RobotId>(bad.into()).is_err(), "{bad:?}");
        }
    }

    /// What an earlier version took can be named, and nothing new goes by it.
    #[test]
    fn nothing_new_begins_with_a_hyphen() {
        for (text, is_new) in
            [("a", true), ("7-a", true), ("a-", true), ("-", false), ("-a", false)]
        {
            let id: RobotId = text.parse().unwrap();
            assert_eq!(id.check_new().is_ok(), is_new, "{text}");
        }
        let problems = Problems::from("-a".parse::<PriorId>().unwrap().check_new().unwrap_err());
        assert_eq!(problems.details()[0].field, "prior");
    }

    #[test]
    fn what_is_no_id_names_its_parameter() {
        let field = |problems: Problems| problems.details()[0].field.clone();
        assert_eq!(field("a b".parse::<RobotId>().unwrap_err().into()), "robot");
        assert_eq!(field("a b".parse::<PriorId>().unwrap_err().into()), "prior");
        assert_eq!(field("a b".parse::<EnvironmentId>().unwrap_err().into()), "environment");
        assert_eq!(field("a b".parse::<EvolutionId>().unwrap_err().into()), "evolution");
        assert_eq!(field("a b".parse::<ComparisonId>().unwrap_err().into()), "comparison");
    }

    #[test]
    fn a_number_makes_an_id() {
        for number in [0, 12, u64::MAX] {
            let id = EvolutionId::numbered(number);
            assert_eq!(id.as_str().parse(), Ok(id.clone()));
            let id = ComparisonId::numbered(number);
            assert_eq!(id.as_str().parse(), Ok(id.clone()));
        }
    }
}
