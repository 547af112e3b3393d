//! From JSON bytes to a wire type, with the field path of whatever does not fit.

use crate::check::{Check, Checked};
use crate::problem::{Detail, Problems, reason};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use serde_path_to_error::{Path, Segment};

/// Reads a type that refuses unknown fields by itself (`deny_unknown_fields`) and checks it.
pub(crate) fn read<T: DeserializeOwned + Checked>(bytes: &[u8]) -> Result<T, Problems> {
    let body: T = parse(bytes)?;
    Check::all(&body)?;
    Ok(body)
}

/// Reads a type that is part of responses too and so must itself tolerate unknown fields; refuses them here.
///
/// A field is known if the type, serialised again, has it: no wire type leaves fields out.
pub(crate) fn read_shared<T: DeserializeOwned + Serialize + Checked>(
    bytes: &[u8],
) -> Result<T, Problems> {
    read_resolved(bytes, |_: &T, _| ()).map(|(body, ())| body)
}

/// Reads as [`read_shared`] does, and what `resolve` makes of the body; what that reports is told with the rest.
pub(crate) fn read_resolved<T: DeserializeOwned + Serialize + Checked, R>(
    bytes: &[u8],
    resolve: impl FnOnce(&T, &mut Check) -> R,
) -> Result<(T, R), Problems> {
    let body: T = parse(bytes)?;
    let given = parse::<Value>(bytes)?;
    let known = serde_json::to_value(&body).map_err(|error| malformed("", &given, &error))?;
    let mut check = Check::default();
    refuse_unknown(&mut check, &given, &known);
    body.check(&mut check);
    let resolved = resolve(&body, &mut check);
    check.finish()?;
    Ok((body, resolved))
}

fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problems> {
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let body = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let given = serde_json::from_slice(bytes).unwrap_or_default();
        let field = if error.path().iter().next().is_none() {
            String::new()
        } else {
            error.path().to_string()
        };
        malformed(&field, at(&given, error.path()), error.inner())
    })?;
    deserializer.end().map_err(|error| malformed("", &Value::Null, &error))?;
    Ok(body)
}

fn malformed(field: &str, value: &Value, error: &serde_json::Error) -> Problems {
    let message = error.to_string();
    // serde tells the kinds of its errors apart by their words alone.
    let unknown = message.starts_with("unknown field");
    let reason = if unknown { reason::UNKNOWN_FIELD } else { reason::MALFORMED };
    Detail::new(reason, field, value.clone(), message).into()
}

/// The value at `path`, null where there is none.
fn at<'a>(body: &'a Value, path: &Path) -> &'a Value {
    path.iter().fold(body, |value, segment| match segment {
        Segment::Seq { index } => &value[*index],
        Segment::Map { key } => &value[key.as_str()],
        Segment::Enum { .. } | Segment::Unknown => &Value::Null,
    })
}

fn refuse_unknown(check: &mut Check, given: &Value, known: &Value) {
    let (Value::Object(given), Value::Object(known)) = (given, known) else { return };
    for (name, value) in given {
        match known.get(name) {
            None => {
                let remedy = format!("leave it out; known here: {}", names(known));
                check.report(reason::UNKNOWN_FIELD, name, value.clone(), remedy);
            }
            Some(Value::Array(items)) => {
                let given = value.as_array().into_iter().flatten();
                for (index, (given, known)) in given.zip(items).enumerate() {
                    check.item(name, index, |check| refuse_unknown(check, given, known));
                }
            }
            Some(known) => check.field(name, |check| refuse_unknown(check, value, known)),
        }
    }
}

fn names(object: &Map<String, Value>) -> String {
    object.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
}
