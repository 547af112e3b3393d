//! What a missing field means: the base of a form, laid under what is there.
//!
//! A base is JSON of the form itself. `"field?": {...}` stands for something that may be null: what is missing is null, what
//! is there is filled in. `"field!": {...}` must be there and is filled in: a robot without a drive is no robot. `[{...}]`
//! fills in every item of a list. A field that the base does not name must be there, too.

use serde_json::{Map, Value};

/// Fills in what `content` does not have.
///
/// # Errors
/// Which field must be there and is not.
pub(super) fn fill(content: &mut Value, base: &str) -> Result<(), String> {
    let base = serde_json::from_str(base).expect("a test reads each of them");
    fill_in(content, &base)
}

fn fill_in(value: &mut Value, base: &Value) -> Result<(), String> {
    match (value, base) {
        (Value::Object(fields), Value::Object(base)) => {
            base.iter().try_for_each(|(key, base)| fill_field(fields, key, base))
        }
        (Value::Array(items), Value::Array(base)) => {
            let mut pairs = items.iter_mut().zip(base.iter().cycle());
            pairs.try_for_each(|(item, base)| fill_in(item, base))
        }
        _ => Ok(()),
    }
}

fn fill_field(fields: &mut Map<String, Value>, key: &str, base: &Value) -> Result<(), String> {
    let name = key.trim_end_matches(['?', '!']);
    if let Some(value) = fields.get_mut(name) {
        return fill_in(value, base);
    }
    let missing = match key.strip_prefix(name) {
        Some("!") => return Err(format!("missing field `{name}`")),
        Some("?") => Value::Null,
        _ => plain(base)?,
    };
    fields.insert(name.to_owned(), missing);
    Ok(())
}

/// The base as a value: lists are empty, what may be null is null.
fn plain(base: &Value) -> Result<Value, String> {
    match base {
        Value::Object(_) => {
            let mut fields = Value::Object(Map::new());
            fill_in(&mut fields, base)?;
            Ok(fields)
        }
        Value::Array(_) => Ok(Value::Array(Vec::new())),
        other => Ok(other.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_there_stays_and_what_is_missing_is_that_of_the_base() {
        let base =
            r#"{"a": 1, "in": {"b": 2, "c?": {"d": 3}}, "list": [{"e": 4}], "f?": {"g": 5}}"#;
        let filled = |mut value: Value| {
            fill(&mut value, base).unwrap();
            value
        };
        let all = json!({"a": 1, "in": {"b": 2, "c": null}, "list": [], "f": null});
        assert_eq!(filled(json!({})), all);
        let given = json!({"a": 9, "in": {"c": {}}, "list": [{"e": 8}, {}], "f": null, "own": 7});
        let expected = json!({
            "a": 9, "in": {"b": 2, "c": {"d": 3}}, "list": [{"e": 8}, {"e": 4}], "f": null, "own": 7
        });
        assert_eq!(filled(given), expected);
    }

    /// Guards against a robot that gets the drive of another one because its own was lost.
    #[test]
    fn what_must_be_there_is_not_made_up() {
        let base = r#"{"drive!": {"lag_s": 0.0}, "list": [{"slip!": {}}]}"#;
        let filled = |mut value: Value| fill(&mut value, base).map(|()| value);
        let missing = |name| Err(format!("missing field `{name}`"));
        assert_eq!(filled(json!({})), missing("drive"));
        assert_eq!(filled(json!({"drive": {}, "list": [{}]})), missing("slip"));
        let whole = json!({"drive": {"lag_s": 0.0}, "list": []});
        assert_eq!(filled(json!({"drive": {}})), Ok(whole));
    }
}
