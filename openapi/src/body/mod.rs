//! From JSON bytes to a wire type: the one place where outside data is read.
//!
//! What is read is what was said. A text becomes a tree (`tree`), the tree a type (`typed`); what does not fit is told in
//! our words with its field path (`fault`, `syntax`). An object is never a list of its fields, `20.0` and
//! `2e1` are whole numbers, a field that stands twice is refused, a byte-order mark of UTF-8 is passed over.

mod fault;
mod syntax;
#[cfg(test)]
mod tests;
mod tree;
mod typed;

use crate::check::{Check, Validate};
use crate::checked::Checked;
use crate::problem::{Problems, reason};
use crate::schema::ToSchema;
use fault::Fault;
use serde::Serialize;
use serde::de::{DeserializeOwned, Error};
use serde_json::{Map, Value};
use std::borrow::Cow;
use tree::Node;
use typed::{Reader, Shapes};

/// What goes over the wire and has a schema.
pub trait Wired: ToSchema + Serialize + DeserializeOwned {}

impl<T: ToSchema + Serialize + DeserializeOwned> Wired for T {}

/// The body of a request.
pub trait Body: Validate + Wired {
    /// Most bytes of one.
    const MAX_BYTES: usize;

    /// What it may say that it is (`Content-Type`).
    const MEDIA_TYPES: &'static [&'static str] = &["application/json"];

    /// Reads one.
    ///
    /// # Errors
    /// Every problem of it.
    fn read(json: &[u8]) -> Result<Checked<Self>, Problems>;
}

/// Reads a type that is no part of the contract, in the same words: a line of a robot's own program, say.
///
/// ```
/// #[derive(serde::Deserialize)]
/// struct Line {
///     count: u32,
/// }
/// assert_eq!(umwelt_api::body::parse::<Line>(br#"{"count": 2.0}"#).unwrap().count, 2);
/// let problems = umwelt_api::body::parse::<Line>(b"[2]").err().unwrap();
/// assert_eq!(problems.details()[0].remedy, "use an object with count, not a list");
/// ```
///
/// # Errors
/// The first thing that keeps it from being a `T`.
pub fn parse<T: DeserializeOwned>(json: &[u8]) -> Result<T, Problems> {
    Ok(T::deserialize(Reader::new(&Node::read(json)?))?)
}

/// Reads a type that refuses unknown fields by itself (`deny_unknown_fields`) and checks it.
///
/// For types whose every part is a struct or a plain enum: within tagged enums serde takes lists for objects.
pub(crate) fn read<T: DeserializeOwned + Validate>(json: &[u8]) -> Result<Checked<T>, Problems> {
    Checked::new(parse(json)?)
}

/// Reads a type that is part of responses too and so must itself tolerate unknown fields; refuses them here.
///
/// A field is known if the type names it, or has it when it is serialised again: within tagged enums only the latter
/// can be seen, so types in them leave no field out.
pub(crate) fn read_shared<T: DeserializeOwned + Serialize + Validate>(
    json: &[u8],
) -> Result<Checked<T>, Problems> {
    read_resolved(json, |_: &T, _| ()).map(|(body, ())| body)
}

/// Reads a type that is part of responses too, refuses unknown fields, and gives what `resolve` makes of the body.
///
/// # Errors
/// Every problem of the body, with what `resolve` reports.
pub fn read_resolved<T: DeserializeOwned + Serialize + Validate, R>(
    json: &[u8],
    resolve: impl FnOnce(&T, &mut Check) -> R,
) -> Result<(Checked<T>, R), Problems> {
    let Reading { body, resolved, .. } = read_said(json, |body, _, check| resolve(body, check))?;
    Ok((body, resolved))
}

/// A body that was read.
pub(crate) struct Reading<T, R> {
    /// All of it.
    pub(crate) body: Checked<T>,
    /// What was said of it: the fields that were given, with the values that were read.
    pub(crate) said: Map<String, Value>,
    /// What was made of it.
    pub(crate) resolved: R,
}

/// The same, and what was said of it.
///
/// # Errors
/// Every problem of the body, with what `resolve` reports.
pub(crate) fn read_said<T: DeserializeOwned + Serialize + Validate, R>(
    json: &[u8],
    resolve: impl FnOnce(&T, &Map<String, Value>, &mut Check) -> R,
) -> Result<Reading<T, R>, Problems> {
    let given = Node::read(json)?;
    let shapes = Shapes::default();
    let body = T::deserialize(Reader::noting(&given, &shapes))?;
    let known = serde_json::to_value(&body).map_err(|error| Fault::custom(error.to_string()))?;
    let mut check = Check::default();
    same_shape(&mut check, &given, &known, &shapes);
    body.check(&mut check);
    let said = match said(&given, &known) {
        Value::Object(said) => said,
        _ => Map::new(),
    };
    let resolved = resolve(&body, &said, &mut check);
    Ok(Reading { body: Checked::after(check, body)?, said, resolved })
}

/// Of what is known the fields that were given.
fn said(given: &Node<'_>, known: &Value) -> Value {
    let (Node::Object(fields), Value::Object(known)) = (given, known) else { return known.clone() };
    let of_field = |(name, given): &(Cow<'_, str>, Node<'_>)| {
        let known = known.get(name.as_ref())?;
        Some((name.clone().into_owned(), said(given, known)))
    };
    Value::Object(fields.iter().filter_map(of_field).collect())
}

/// Refuses what was given and is not known, and lists in the place of objects.
fn same_shape(check: &mut Check, given: &Node<'_>, known: &Value, shapes: &Shapes) {
    match (given, known) {
        (Node::Object(fields), Value::Object(known)) => {
            let of_type = shapes.of(given).unwrap_or_default();
            only_known(check, fields, known, of_type, shapes);
        }
        (Node::List(_), Value::Object(known)) => {
            let remedy = format!("use an object with {}, not a list", names(known));
            check.report(reason::MALFORMED, "", Value::Null, remedy);
        }
        (Node::List(given), Value::Array(known)) => {
            for (index, (given, known)) in given.iter().zip(known).enumerate() {
                check.item("", index, |check| same_shape(check, given, known, shapes));
            }
        }
        _ => {}
    }
}

/// Refuses fields that neither stand in `known`, the same object said again, nor are `of_type`, which may leave some out.
fn only_known(
    check: &mut Check,
    given: &[(Cow<'_, str>, Node<'_>)],
    known: &Map<String, Value>,
    of_type: &[&str],
    shapes: &Shapes,
) {
    for (name, value) in given {
        match known.get(name.as_ref()) {
            Some(known) => check.field(name, |check| same_shape(check, value, known, shapes)),
            None if of_type.contains(&name.as_ref()) => {}
            None => {
                let remedy = format!("leave it out; known here: {}", names(known));
                check.report(reason::UNKNOWN_FIELD, name, value.shown(), remedy);
            }
        }
    }
}

fn names(object: &Map<String, Value>) -> String {
    object.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
}
