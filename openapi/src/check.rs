//! Collects every problem of a body with its field path; the same walk tells the contract its limits.

use crate::id;
use crate::named::Known;
use crate::problem::{Detail, Problems, reason};
use crate::visible;
use serde_json::Value;
use std::fmt::{Display, Write};
use std::ops::RangeInclusive;

/// The numbers that a field may hold, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest number.
    pub min: f64,
    /// The largest number.
    pub max: f64,
    /// The unit, empty for a pure number.
    pub unit: &'static str,
}

impl Range {
    /// The numbers from `min` to `max` in `unit`.
    pub const fn new(min: f64, max: f64, unit: &'static str) -> Self {
        Self { min, max, unit }
    }

    /// Whether `value` is one of them; NaN is none.
    pub fn contains(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }
}

/// Outside data that can say everything that is wrong with it.
pub trait Validate {
    /// Reports each problem to `check`. Which limits are asked must not depend on the values.
    fn check(&self, check: &mut Check);

    /// Whether nothing is wrong with it; [`Checked`](crate::Checked) remembers that.
    ///
    /// # Errors
    /// Every field that is out of its range or contradicts another.
    fn validate(&self) -> Result<(), Problems> {
        let mut check = Check::default();
        self.check(&mut check);
        check.finish()
    }
}

/// A limit that a check has asked for, with its field path; items of a list as `waypoints[0].x_m`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Limit {
    Number(Range),
    Integer(RangeInclusive<u64>),
    Length(RangeInclusive<usize>),
    /// What the text matches, as ECMAScript has it.
    Pattern(&'static str),
    OneOf(Vec<String>),
    EachOnce,
}

/// Collects problems on a walk over a body. What knows more than the contract, which names stand for something and what
/// follows from the whole, adds its own through [`body::read_resolved`](crate::body::read_resolved).
#[derive(Default)]
pub struct Check {
    path: String,
    problems: Problems,
    limits: Option<Vec<(String, Limit)>>,
}

impl Check {
    /// The limits that hold for `value` and bodies like it.
    #[cfg(feature = "document")]
    pub(crate) fn limits(value: &impl Validate) -> Vec<(String, Limit)> {
        let mut check = Self { limits: Some(Vec::new()), ..Self::default() };
        value.check(&mut check);
        check.limits.unwrap_or_default()
    }

    /// Ends the walk.
    ///
    /// # Errors
    /// The problems found, if any.
    pub fn finish(self) -> Result<(), Problems> {
        if self.problems.is_empty() { Ok(()) } else { Err(self.problems) }
    }

    /// Checks what lies in field `name`.
    pub(crate) fn field(&mut self, name: &str, walk: impl FnOnce(&mut Self)) {
        let end = self.path.len();
        self.enter(name);
        walk(self);
        self.path.truncate(end);
    }

    /// Checks what lies at `index` of list `name`.
    pub(crate) fn item(&mut self, name: &str, index: usize, walk: impl FnOnce(&mut Self)) {
        let end = self.path.len();
        self.enter(name);
        // Writing to a String cannot fail.
        let _ = write!(self.path, "[{index}]");
        walk(self);
        self.path.truncate(end);
    }

    /// Checks each item of list `name`.
    pub(crate) fn items<T: Validate>(&mut self, name: &str, items: &[T]) {
        for (index, item) in items.iter().enumerate() {
            self.item(name, index, |check| item.check(check));
        }
    }

    /// Field `name` must be finite and within `range`.
    pub(crate) fn number(&mut self, name: &str, value: f64, range: Range) {
        self.limit(name, || Limit::Number(range));
        if range.contains(value) {
            return;
        }
        let reason = if value.is_finite() { reason::OUT_OF_RANGE } else { reason::NOT_FINITE };
        let space = if range.unit.is_empty() { "" } else { " " };
        let remedy =
            format!("use a number from {} to {}{space}{}", range.min, range.max, range.unit);
        self.report(reason, name, value, remedy);
    }

    /// Field `name` must lie within `range`.
    pub(crate) fn integer(&mut self, name: &str, value: u64, range: RangeInclusive<u64>) {
        self.limit(name, || Limit::Integer(range.clone()));
        if !range.contains(&value) {
            let remedy = format!("use an integer from {} to {}", range.start(), range.end());
            self.report(reason::OUT_OF_RANGE, name, value, remedy);
        }
    }

    /// The list or text in field `name` must have a length within `range`.
    pub(crate) fn length(&mut self, name: &str, length: usize, range: RangeInclusive<usize>) {
        self.limit(name, || Limit::Length(range.clone()));
        if !range.contains(&length) {
            let remedy = format!("use {} to {} of them, not {length}", range.start(), range.end());
            self.report(reason::WRONG_LENGTH, name, length, remedy);
        }
    }

    /// The text in field `name` must have a length in characters within `range`, and show as what it is.
    pub(crate) fn text(&mut self, name: &str, text: &str, range: RangeInclusive<usize>) {
        self.limit(name, || Limit::Length(range.clone()));
        self.limit(name, || Limit::Pattern(visible::PATTERN));
        let length = text.chars().count();
        if !range.contains(&length) {
            let remedy =
                format!("use {} to {} characters, not {length}", range.start(), range.end());
            self.report(reason::WRONG_LENGTH, name, text, remedy);
        }
        if let Some((before, character)) = visible::first_hidden(text) {
            let remedy = format!(
                "leave out U+{:04X}, which stands behind {before} characters: no control characters, line breaks, or \
                 marks of the direction of writing",
                u32::from(character)
            );
            self.report(reason::HIDDEN_CHARACTER, name, visible::line(text), remedy);
        }
    }

    /// Field `name` must be an id.
    pub(crate) fn id(&mut self, name: &str, text: &str) {
        self.limit(name, || Limit::Pattern(id::PATTERN));
        if !id::is_id(text) {
            self.report(reason::INVALID_ID, name, text, id::REMEDY);
        }
    }

    /// Field `name` must be an id that something new may have.
    pub(crate) fn new_id(&mut self, name: &str, text: &str) {
        self.limit(name, || Limit::Pattern(id::PATTERN));
        if !id::is_new_id(text) {
            self.report(reason::INVALID_ID, name, text, id::REMEDY);
        }
    }

    /// Field `name` must hold one of `known`.
    pub(crate) fn preset(&mut self, name: &str, text: &str, known: &'static [&'static str]) {
        self.one_of(name, known);
        if !known.contains(&text) {
            let remedy = format!("known: {}", known.join(", "));
            self.report(reason::UNKNOWN_PRESET, name, text, remedy);
        }
    }

    /// Field `name` holds one of these, which is checked where more is known.
    pub(crate) fn one_of<T: AsRef<str>>(&mut self, name: &str, known: &[T]) {
        let owned = || known.iter().map(|it| it.as_ref().to_owned()).collect();
        self.limit(name, || Limit::OneOf(owned()));
    }

    /// The list in field `name` holds nothing twice, which is checked where its items are.
    pub(crate) fn each_once(&mut self, name: &str) {
        self.limit(name, || Limit::EachOnce);
    }

    /// What the text in field `name` stands for; a text that is no name, or one that no one knows, is a problem.
    pub fn known<T>(
        &mut self,
        name: &str,
        text: &str,
        reason: &str,
        known: impl Fn(&str) -> Known<T>,
    ) -> Option<T> {
        if !id::is_id(text) {
            // What is no id at all is reported by the check of the field.
            return None;
        }
        match known(text) {
            Ok(found) => Some(found),
            Err(names) => {
                self.report(reason, name, text, format!("known: {}", names.join(", ")));
                None
            }
        }
    }

    /// What a conversion of field `name` gave; its error counts unless the checks have said what is wrong.
    pub fn ok<T, E: Display>(&mut self, name: &str, converted: Result<T, E>) -> Option<T> {
        match converted {
            Ok(core) => Some(core),
            Err(error) => {
                if self.problems.is_empty() {
                    self.report(reason::INCONSISTENT, name, Value::Null, error.to_string());
                }
                None
            }
        }
    }

    /// What field `name` holds must agree with the other fields.
    pub fn agrees(&mut self, name: &str, holds: bool, value: impl Into<Value>, remedy: &str) {
        if !holds {
            self.report(reason::INCONSISTENT, name, value, remedy);
        }
    }

    /// The fields that are wrong, as far as is known so far.
    #[cfg(feature = "core")]
    pub(crate) fn fields(&self) -> Vec<String> {
        self.problems.details().iter().map(|it| it.field.clone()).collect()
    }

    /// Reports a problem of field `name`; of the whole where the name is empty.
    pub fn report(
        &mut self,
        reason: &str,
        name: &str,
        value: impl Into<Value>,
        remedy: impl Into<String>,
    ) {
        let end = self.path.len();
        self.enter(name);
        self.problems.add(Detail::new(reason, &self.path, value, remedy));
        self.path.truncate(end);
    }

    fn limit(&mut self, name: &str, limit: impl FnOnce() -> Limit) {
        if self.limits.is_none() {
            return;
        }
        let end = self.path.len();
        self.enter(name);
        let path = self.path.clone();
        self.path.truncate(end);
        self.limits.get_or_insert_default().push((path, limit()));
    }

    fn enter(&mut self, name: &str) {
        if !self.path.is_empty() && !name.is_empty() {
            self.path.push('.');
        }
        self.path.push_str(name);
    }
}
