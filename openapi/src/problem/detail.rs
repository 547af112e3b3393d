//! One thing that is wrong.

use crate::schema::ToSchema;
use crate::visible;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Most details of one error: a body of 1000 bad waypoints must not answer with half a megabyte.
/// The message tells how many there were.
pub const MAX_DETAILS: usize = 100;

/// Longest text in bytes that an error repeats of what was sent.
pub const MAX_ECHO: usize = 200;

/// Longest remedy in bytes: it may name every field of a drive, and may hold words of a parser that repeat a text.
pub const MAX_REMEDY: usize = 500;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Detail)]
pub struct Detail {
    /// Why, for programs: `OUT_OF_RANGE`, `UNKNOWN_FIELD`, ...; expect others.
    pub reason: String,
    /// Path of the field, as `waypoints[3].x_m`; empty where the whole is meant.
    #[serde(default)]
    pub field: String,
    /// What the field held, shortened; null where it held nothing, a list or an object.
    #[serde(default)]
    pub value: Value,
    /// What to do about it, for people.
    #[serde(default)]
    pub remedy: String,
}

impl Detail {
    /// What is wrong with `field`; long texts are cut to [`MAX_ECHO`].
    pub fn new(
        reason: impl Into<String>,
        field: impl Into<String>,
        value: impl Into<Value>,
        remedy: impl Into<String>,
    ) -> Self {
        let value = match value.into() {
            Value::String(text) => Value::String(shortened(text, MAX_ECHO)),
            Value::Array(_) | Value::Object(_) => Value::Null,
            scalar => scalar,
        };
        let field = shortened(field.into(), MAX_ECHO);
        let remedy = shortened(remedy.into(), MAX_REMEDY);
        Self { reason: reason.into(), field, value, remedy }
    }
}

impl std::fmt::Display for Detail {
    /// The field, what it held where that is repeated, and what to do.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { field, value, remedy, .. } = self;
        match (field.is_empty(), value.is_null()) {
            (true, _) => write!(f, "{remedy}"),
            (false, true) => write!(f, "{field}: {remedy}"),
            (false, false) => write!(f, "{field} is {value}: {remedy}"),
        }
    }
}

impl Detail {
    /// The same with every hidden character of its texts escaped.
    pub(super) fn visible(self) -> Self {
        let shown = |text: String| visible::line(&text).into_owned();
        let value = match self.value {
            Value::String(text) => Value::String(shown(text)),
            // Whoever sends lists and objects for a value does not keep the contract.
            Value::Array(_) | Value::Object(_) => Value::Null,
            scalar => scalar,
        };
        let (reason, field, remedy) = (shown(self.reason), shown(self.field), shown(self.remedy));
        Self { reason, field, value, remedy }
    }
}

/// At most `longest` bytes of `text`, and that there was more.
pub(super) fn shortened(mut text: String, longest: usize) -> String {
    if text.len() > longest {
        text.truncate(text.floor_char_boundary(longest));
        text.push_str("...");
    }
    text
}
