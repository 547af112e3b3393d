//! `Idempotency-Key`: a POST that creates, sent twice, creates once.

use crate::problem::{Detail, Problems, reason};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// Longest key: two UUIDs and words between them.
pub const MAX_KEY: usize = 128;

/// The key of one intention to create something: 1 to 128 visible ASCII characters.
///
/// ```
/// use umwelt_api::IdempotencyKey;
/// assert!("3f2c-night-run".parse::<IdempotencyKey>().is_ok());
/// assert!("night run".parse::<IdempotencyKey>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct IdempotencyKey(Arc<str>);

/// A text that is no key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an Idempotency-Key is 1 to {MAX_KEY} visible ASCII characters, not {0:?}")]
pub struct InvalidKey(pub String);

impl IdempotencyKey {
    /// The name of the header.
    pub const HEADER: &str = "Idempotency-Key";

    /// The key as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for IdempotencyKey {
    type Err = InvalidKey;

    fn from_str(text: &str) -> Result<Self, InvalidKey> {
        if (1..=MAX_KEY).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_graphic()) {
            Ok(Self(text.into()))
        } else {
            Err(InvalidKey(text.to_owned()))
        }
    }
}

impl fmt::Display for IdempotencyKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl From<InvalidKey> for Problems {
    /// The field is the name of the header.
    fn from(invalid: InvalidKey) -> Self {
        let remedy = format!("use 1 to {MAX_KEY} visible ASCII characters");
        Detail::new(reason::MALFORMED, IdempotencyKey::HEADER, invalid.0, remedy).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_visible_ascii() {
        for good in ["a", "~!", &"x".repeat(128)] {
            assert_eq!(good.parse::<IdempotencyKey>().unwrap().as_str(), good);
        }
        for bad in ["", "a b", "a\n", "ä", "\u{7f}", &"x".repeat(129)] {
            let problems = Problems::from(bad.parse::<IdempotencyKey>().unwrap_err());
            assert_eq!(problems.details()[0].field, "Idempotency-Key", "{bad:?}");
        }
    }
}
