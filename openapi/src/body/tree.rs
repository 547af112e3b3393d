//! A JSON text as it was said: the one form in which outside data is looked at before it gets a type.

use super::fault::{Fault, Step, Trail};
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::Value;
use std::borrow::Cow;
use std::fmt;

/// The integers of which f64 has every one: a whole number beyond them, said with a fraction or an exponent, may have
/// been another before it was written.
pub(super) const MAX_EXACT: f64 = 9_007_199_254_740_991.0;

/// One value. Texts without escapes are not copied; of fields that stand twice both are there.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node<'de> {
    Null,
    Bool(bool),
    Number(Number),
    Text(Cow<'de, str>),
    List(Vec<Self>),
    Object(Vec<(Cow<'de, str>, Self)>),
}

/// A number as it was said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Unsigned(u64),
    Negative(i64),
    Float(f64),
}

impl Number {
    /// The nearest f64.
    pub(super) fn float(self) -> f64 {
        match self {
            Self::Unsigned(number) => number as f64,
            Self::Negative(number) => number as f64,
            Self::Float(number) => number,
        }
    }

    /// The integer that it is: `20`, `20.0` and `2e1` are one, `20.5` is none, nor is what only rounds to one.
    pub(super) fn integer(self) -> Option<i128> {
        match self {
            Self::Unsigned(number) => Some(number.into()),
            Self::Negative(number) => Some(number.into()),
            Self::Float(number) => {
                let is_whole = number.fract() == 0.0 && number.abs() <= MAX_EXACT;
                is_whole.then_some(number as i128)
            }
        }
    }
}

impl<'de> Node<'de> {
    /// The value of a JSON text, all of it.
    pub(super) fn read(json: &'de [u8]) -> Result<Self, Fault> {
        // A byte-order mark says nothing in UTF-8, and some editors write one.
        let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
        let mut trail = Trail::default();
        let mut deserializer = serde_json::Deserializer::from_slice(json);
        let read = Seed(&mut trail).deserialize(&mut deserializer);
        read.and_then(|node| deserializer.end().map(|()| node))
            .map_err(|error| Fault::of_syntax(json, &error, trail))
    }

    /// What an error repeats of it: null for a list or an object.
    pub(super) fn shown(&self) -> Value {
        match self {
            Self::Null | Self::List(_) | Self::Object(_) => Value::Null,
            Self::Bool(value) => (*value).into(),
            Self::Number(Number::Unsigned(number)) => (*number).into(),
            Self::Number(Number::Negative(number)) => (*number).into(),
            Self::Number(Number::Float(number)) => (*number).into(),
            Self::Text(text) => text.as_ref().into(),
        }
    }

    /// What it is, in words.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Bool(_) => "true or false",
            Self::Number(_) => "a number",
            Self::Text(_) => "a text",
            Self::List(_) => "a list",
            Self::Object(_) => "an object",
        }
    }
}

/// Reads one value, and keeps the way to whatever cannot be read.
struct Seed<'a>(&'a mut Trail);

impl<'de> DeserializeSeed<'de> for Seed<'_> {
    type Value = Node<'de>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Node<'de>, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Seed<'_> {
    type Value = Node<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E: Error>(self) -> Result<Node<'de>, E> {
        Ok(Node::Null)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Node<'de>, E> {
        Ok(Node::Bool(value))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Node<'de>, E> {
        Ok(Node::Number(Number::Unsigned(number)))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Node<'de>, E> {
        Ok(Node::Number(Number::Negative(number)))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Node<'de>, E> {
        Ok(Node::Number(Number::Float(number)))
    }

    fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Node<'de>, E> {
        Ok(Node::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Node<'de>, E> {
        Ok(Node::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Node<'de>, A::Error> {
        let mut items = Vec::new();
        loop {
            match access.next_element_seed(Seed(self.0)) {
                Ok(Some(item)) => items.push(item),
                Ok(None) => return Ok(Node::List(items)),
                Err(error) => {
                    self.0.push(Step::Item(items.len()));
                    return Err(error);
                }
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Node<'de>, A::Error> {
        let mut fields = Vec::new();
        while let Some(name) = access.next_key_seed(Name)? {
            match access.next_value_seed(Seed(self.0)) {
                Ok(value) => fields.push((name, value)),
                Err(error) => {
                    self.0.push(Step::Field(name.into_owned()));
                    return Err(error);
                }
            }
        }
        Ok(Node::Object(fields))
    }
}

/// Reads the name of a field.
struct Name;

impl<'de> DeserializeSeed<'de> for Name {
    type Value = Cow<'de, str>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de> Visitor<'de> for Name {
    type Value = Cow<'de, str>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a field")
    }

    fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Self::Value, E> {
        Ok(Cow::Borrowed(text))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        Ok(Cow::Owned(text.to_owned()))
    }
}
