//! The first thing that keeps a text from being what was asked for, in our words, with its field path.

use super::syntax;
use crate::problem::{Detail, Problems, reason};
use serde::de::{self, Expected, Unexpected};
use serde_json::Value;
use std::fmt::{self, Display, Write};

/// One step of the way to a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Field(String),
    Item(usize),
}

/// The way to a value, its last step first: it is collected where an error unwinds.
pub(super) type Trail = Vec<Step>;

/// What is wrong, and where.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    reason: &'static str,
    trail: Trail,
    value: Value,
    remedy: String,
}

impl Fault {
    /// A value of another kind than `wanted`.
    pub(super) fn kind(given: &'static str, value: Value, wanted: impl Display) -> Self {
        let remedy = format!("use {wanted}, not {given}");
        Self { reason: reason::MALFORMED, trail: Trail::new(), value, remedy }
    }

    /// A value that is of the right kind and still cannot be meant.
    pub(super) fn value(reason: &'static str, value: Value, remedy: String) -> Self {
        Self { reason, trail: Trail::new(), value, remedy }
    }

    /// What is no JSON, or JSON and more; `trail` leads to where it was seen.
    pub(super) fn of_syntax(json: &[u8], error: &serde_json::Error, trail: Trail) -> Self {
        let syntax::Finding { value, remedy } = syntax::find(json, error);
        Self { reason: reason::MALFORMED, trail, value, remedy }
    }

    /// The same, found in this field or item.
    pub(super) fn within(mut self, step: Step) -> Self {
        self.trail.push(step);
        self
    }

    /// The same, said by a type that reads itself and does not repeat what it was given: what is `shown`.
    pub(super) fn about(mut self, shown: impl FnOnce() -> Value) -> Self {
        if self.trail.is_empty() && self.value.is_null() {
            self.value = shown();
        }
        self
    }

    /// The same about a field whose name was the trouble: what it held.
    pub(super) fn holding(mut self, value: Value) -> Self {
        self.value = value;
        self
    }
}

impl From<Fault> for Problems {
    fn from(fault: Fault) -> Self {
        let mut path = String::new();
        for step in fault.trail.iter().rev() {
            // Writing to a String cannot fail.
            let _ = match step {
                Step::Item(index) => write!(path, "[{index}]"),
                Step::Field(name) if path.is_empty() => write!(path, "{name}"),
                Step::Field(name) => write!(path, ".{name}"),
            };
        }
        Detail::new(fault.reason, path, fault.value, fault.remedy).into()
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.remedy)
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    /// What a type says that reads itself from a text, as an id does.
    fn custom<T: Display>(message: T) -> Self {
        Self::value(reason::MALFORMED, Value::Null, message.to_string())
    }

    fn invalid_type(given: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let (kind, value) = said(given);
        Self::kind(kind, value, in_our_words(expected))
    }

    fn invalid_value(given: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let wanted = in_our_words(expected);
        Self::value(reason::MALFORMED, said(given).1, format!("use {wanted}"))
    }

    fn invalid_length(given: usize, expected: &dyn Expected) -> Self {
        let wanted = in_our_words(expected);
        Self::value(reason::WRONG_LENGTH, given.into(), format!("use {wanted}"))
    }

    fn unknown_variant(given: &str, known: &'static [&'static str]) -> Self {
        Self::value(reason::MALFORMED, given.into(), format!("use one of: {}", known.join(", ")))
    }

    fn unknown_field(given: &str, known: &'static [&'static str]) -> Self {
        let remedy = format!("leave it out; known here: {}", known.join(", "));
        let fault = Self::value(reason::UNKNOWN_FIELD, Value::Null, remedy);
        fault.within(Step::Field(given.to_owned()))
    }

    fn missing_field(name: &'static str) -> Self {
        let remedy = "it is missing and has no default: say it".to_owned();
        Self::value(reason::MALFORMED, Value::Null, remedy).within(Step::Field(name.to_owned()))
    }

    fn duplicate_field(name: &'static str) -> Self {
        let remedy = "it stands twice: say it once".to_owned();
        Self::value(reason::MALFORMED, Value::Null, remedy).within(Step::Field(name.to_owned()))
    }
}

/// What was given: its kind, and as much of it as an error repeats.
fn said(given: Unexpected<'_>) -> (&'static str, Value) {
    match given {
        Unexpected::Bool(value) => ("true or false", value.into()),
        Unexpected::Unsigned(number) => ("a number", number.into()),
        Unexpected::Signed(number) => ("a number", number.into()),
        Unexpected::Float(number) => ("a number", number.into()),
        Unexpected::Char(text) => ("a text", text.to_string().into()),
        Unexpected::Str(text) => ("a text", text.into()),
        Unexpected::Unit | Unexpected::Option => ("null", Value::Null),
        Unexpected::Seq => ("a list", Value::Null),
        Unexpected::Map => ("an object", Value::Null),
        _ => ("something else", Value::Null),
    }
}

/// Whether what a visitor expects is an object of the contract: a struct, or an enum with a tag.
pub(super) fn is_object(expected: &dyn Expected) -> bool {
    let words = expected.to_string();
    let known = ["struct ", "internally tagged enum ", "variant of enum ", "enum "];
    known.iter().any(|known| words.starts_with(known))
}

/// What serde's visitors expect, in the words of the contract. Visitors of our own say it in them already.
fn in_our_words(given: &dyn Expected) -> String {
    let expected = given.to_string();
    const INTEGERS: [&str; 10] =
        ["u8", "u16", "u32", "u64", "usize", "i8", "i16", "i32", "i64", "isize"];
    let words = match expected.as_str() {
        _ if is_object(given) => "an object",
        "f64" | "f32" => "a number",
        "a boolean" => "true or false",
        "a string" | "string" | "variant identifier" => "a text",
        "a sequence" => "a list",
        integer if INTEGERS.contains(&integer) => "a whole number",
        other => other,
    };
    words.to_owned()
}
