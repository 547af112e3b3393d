//! A change of parts of what was said of a robot.

use super::{Description, Spec};
use crate::body;
use crate::check::{Check, Validate};
use crate::checked::Checked;
use crate::problem::{Problems, reason};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The fields of a spec that are made of fields, each of which may be said or not. What else is an object is one value.
const GROUPS: [&str; 4] = ["drive", "noise", "variance", "steering"];

/// A change of a [`Description`]: a JSON merge patch (RFC 7396), but that `prior` and `predictor` are replaced as a whole. What
/// it has replaces what was said, null takes it back.
///
/// ```
/// use umwelt_api::robot::{Description, Patch};
/// let said = Description::read(br#"{"drive": {"lag_s": 0.1, "track_width_m": 0.2}}"#)?;
/// let patch = Patch::read(br#"{"drive": {"lag_s": null}, "method": "statistic"}"#)?;
/// let changed = Description::read(&said.patched(&patch))?;
/// assert!(changed.says("method") && changed.says("drive.track_width_m") && !changed.says("drive.lag_s"));
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Patch(Map<String, Value>);

impl Validate for Patch {
    /// Whether it agrees with what it does not change is checked with that.
    fn check(&self, check: &mut Check) {
        Description(self.set_fields()).check(check);
    }
}

impl Description {
    /// The same without the fields at these paths.
    #[cfg(feature = "core")]
    pub(crate) fn without(self, paths: &[String]) -> Self {
        let mut patch = Patch::default();
        for path in paths {
            let value = path.split('.').next().unwrap_or(path);
            let path = if GROUPS.contains(&value) { path } else { value };
            if self.says(path) {
                patch.set(path, Value::Null);
            }
        }
        let mut said = self.0;
        merge(&mut said, &patch.0);
        Self(said)
    }

    /// The body that says what this one says once `patch` has changed it.
    pub fn patched(&self, patch: &Patch) -> Vec<u8> {
        let mut said = self.0.clone();
        merge(&mut said, &patch.0);
        // A map of JSON values can be written.
        serde_json::to_vec(&said).unwrap_or_default()
    }
}

impl Patch {
    /// Reads the body of a PATCH.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, values out of range.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        let patch = Self(body::parse(json)?);
        patch.check_taken_back()?;
        let set = serde_json::to_vec(&patch.set_fields()).unwrap_or_default();
        Description::read(&set)?;
        Checked::new(patch)
    }

    /// Whether everything that it takes back is a field.
    fn check_taken_back(&self) -> Result<(), Problems> {
        let known = Description::from(&Spec::default());
        let mut check = Check::default();
        let mut look = |path: &str, value: &Value| {
            if value.is_null() && !known.says(path) {
                check.report(reason::UNKNOWN_FIELD, path, Value::Null, "leave it out");
            }
        };
        for (name, value) in &self.0 {
            look(name, value);
            if let Some(fields) = value.as_object().filter(|_| GROUPS.contains(&name.as_str())) {
                fields.iter().for_each(|(field, value)| look(&format!("{name}.{field}"), value));
            }
        }
        check.finish()
    }

    /// What it says, without what it takes back.
    fn set_fields(&self) -> Map<String, Value> {
        let mut said = Map::new();
        merge(&mut said, &self.0);
        said
    }

    /// Takes back or replaces the field at `path`: `drive.lag_s`.
    pub fn set(&mut self, path: &str, value: Value) {
        let mut fields = &mut self.0;
        let mut rest = path;
        while let Some((first, further)) = rest.split_once('.') {
            let inner = fields.entry(first).or_insert_with(|| Value::Object(Map::new()));
            if !inner.is_object() {
                *inner = Value::Object(Map::new());
            }
            let Value::Object(inner) = inner else { return };
            (fields, rest) = (inner, further);
        }
        fields.insert(rest.to_owned(), value);
    }

    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// RFC 7396, section 2, for the fields and those of the groups.
fn merge(target: &mut Map<String, Value>, patch: &Map<String, Value>) {
    for (name, value) in patch {
        match value {
            Value::Null => {
                target.remove(name);
            }
            Value::Object(patch) if GROUPS.contains(&name.as_str()) => {
                let inner = target.entry(name).or_insert_with(|| Value::Object(Map::new()));
                if !inner.is_object() {
                    *inner = Value::Object(Map::new());
                }
                if let Value::Object(inner) = inner {
                    merge(inner, patch);
                }
            }
            other => {
                target.insert(name.clone(), other.clone());
            }
        }
    }
}

#[cfg(feature = "document")]
mod schema {
    //! In a patch every field of a spec may also be null.

    use super::{Patch, Spec};
    use std::borrow::Cow;
    use utoipa::openapi::schema::{
        AdditionalProperties, Object, OneOfBuilder, Schema, SchemaType, Type,
    };
    use utoipa::openapi::{ObjectBuilder, RefOr};
    use utoipa::{PartialSchema, ToSchema};

    type Schemas = Vec<(String, RefOr<Schema>)>;

    impl PartialSchema for Patch {
        fn schema() -> RefOr<Schema> {
            let mut known = Vec::new();
            Spec::schemas(&mut known);
            let mut patch = Spec::schema();
            if let RefOr::T(Schema::Object(object)) = &mut patch {
                object.description =
                    Some("What to change of what was said; null takes it back.".to_owned());
                object.properties.values_mut().for_each(|it| nullable(it, &known));
            }
            patch
        }
    }

    impl ToSchema for Patch {
        fn name() -> Cow<'static, str> {
            "RobotPatch".into()
        }

        fn schemas(schemas: &mut Schemas) {
            Spec::schemas(schemas);
        }
    }

    /// Lets a field be null, and each field within it where it is a struct.
    fn nullable(schema: &mut RefOr<Schema>, known: &Schemas) {
        match schema {
            RefOr::T(Schema::Object(object)) => {
                object.default = None;
                let SchemaType::Type(kind) = object.schema_type.clone() else { return };
                object.schema_type = SchemaType::Array(vec![kind, Type::Null]);
            }
            RefOr::Ref(reference) => {
                let name = reference.ref_location.rsplit('/').next().unwrap_or_default();
                let found = known.iter().find(|(of, _)| of == name).map(|(_, schema)| schema);
                *schema = match found {
                    Some(RefOr::T(Schema::Object(inner))) if !inner.properties.is_empty() => {
                        let mut inner: Object = inner.clone();
                        inner.default = None;
                        inner.properties.values_mut().for_each(|it| nullable(it, known));
                        inner.schema_type = SchemaType::Array(vec![Type::Object, Type::Null]);
                        inner.additional_properties =
                            Some(Box::new(AdditionalProperties::FreeForm(false)));
                        Schema::Object(inner).into()
                    }
                    _ => {
                        let null = ObjectBuilder::new().schema_type(Type::Null);
                        OneOfBuilder::new().item(reference.clone()).item(null).into()
                    }
                };
            }
            RefOr::T(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// After the examples of RFC 7396, appendix A.
    #[test]
    fn a_patch_is_merged_as_the_standard_has_it() {
        for (target, patch, result) in [
            (json!({"a": "b"}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "b"}), json!({"b": "c"}), json!({"a": "b", "b": "c"})),
            (json!({"a": "b"}), json!({"a": null}), json!({})),
            (json!({"a": "b", "b": "c"}), json!({"a": null}), json!({"b": "c"})),
            (json!({"a": ["b"]}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "c"}), json!({"a": ["b"]}), json!({"a": ["b"]})),
            (
                json!({"drive": {"b": "c"}}),
                json!({"drive": {"b": "d", "c": null}}),
                json!({"drive": {"b": "d"}}),
            ),
            (json!({"drive": 1}), json!({"drive": {"b": 2}}), json!({"drive": {"b": 2}})),
            (json!({}), json!({"drive": {"b": null}}), json!({"drive": {}})),
            // One value each.
            (json!({"prior": {"a": 1}}), json!({"prior": {"b": 2}}), json!({"prior": {"b": 2}})),
            (json!({"predictor": {"a": 1}}), json!({"predictor": {}}), json!({"predictor": {}})),
        ] {
            let (Value::Object(target), Value::Object(patch)) = (target, patch) else { panic!() };
            let merged: Value =
                serde_json::from_slice(&Description(target).patched(&Patch(patch))).unwrap();
            assert_eq!(merged, result);
        }
    }

    #[test]
    fn a_patch_is_checked_by_itself() {
        let refused = |body: Value| Patch::read(body.to_string().as_bytes()).is_err();
        for wrong in [
            json!([]),
            json!({"drive": {"lag": null}}),
            json!({"colour": null}),
            json!({"drive": {"lag_s": 9}}),
            json!({"prior": {"turn": null}}),
            json!({"predictor": {"agents": 5}}),
        ] {
            assert!(refused(wrong.clone()), "{wrong}");
        }
        assert!(!refused(json!({"drive": null, "noise": {"position_m": null}, "method": null})));
    }

    #[test]
    fn a_patch_is_written_path_by_path() {
        let mut patch = Patch::default();
        patch.set("drive.lag_s", json!(0.1));
        patch.set("drive.dead_time_s", Value::Null);
        patch.set("method", json!("statistic"));
        let expected = json!({"drive": {"lag_s": 0.1, "dead_time_s": null}, "method": "statistic"});
        assert_eq!(json!(patch), expected);
    }
}
