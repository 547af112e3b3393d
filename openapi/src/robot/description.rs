//! What was said of a robot, and no more: the rest follows from it.

use super::{DEFAULT_PRIOR, Spec};
use crate::body;
use crate::check::{Check, Validate};
use crate::checked::Checked;
use crate::problem::Problems;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The fields of a spec that follow from the rest where they are not said; others have a default of their own.
pub const DERIVED: [&str; 19] = [
    "drive.max_linear_m_per_s",
    "drive.min_linear_m_per_s",
    "drive.max_angular_rad_per_s",
    "drive.min_angular_rad_per_s",
    "drive.max_linear_acceleration_m_per_s2",
    "drive.max_angular_acceleration_rad_per_s2",
    "drive.max_wheel_speed_rad_per_s",
    "steering.alpha_m_per_s",
    "steering.stop_radius_m",
    "steering.tolerance_m",
    "steering.turn_tolerance_rad",
    "steering.turn_beyond_rad",
    "variance.position_m2",
    "variance.heading_rad2",
    "loop_delay_s",
    "watchdog_s",
    "horizon_slots",
    "drive.lag_s",
    "drive.dead_time_s",
];

/// What is identified where it is not said; before the first motion and delivery it has a value that follows, or its default.
pub const IDENTIFIED: [&str; 5] =
    ["loop_delay_s", "drive.lag_s", "drive.dead_time_s", NOISE[0], NOISE[1]];

/// The noise of poses, which the method `adaptive` alone identifies, where neither is said.
pub const NOISE: [&str; 2] = ["noise.position_m", "noise.heading_rad"];

/// What was said of a robot: the fields of a [`Spec`] that someone gave, in its form. What is left out has its default, or
/// follows from the rest; which of them do is a table in `docs/method.md`.
///
/// ```
/// use umwelt_api::robot::Description;
/// let said = Description::read(br#"{"drive": {"wheel_radius_m": 0.033, "max_linear_m_per_s": 0.22}}"#)?;
/// assert!(said.says("drive.wheel_radius_m") && !said.says("drive.track_width_m"));
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Description(pub(super) Map<String, Value>);

/// A spec of which only the ranges are checked: what is left out is not what it will be.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Said(pub(crate) Spec);

impl Validate for Said {
    fn check(&self, check: &mut Check) {
        self.0.check_ranges(check);
    }
}

impl Validate for Description {
    fn check(&self, check: &mut Check) {
        self.spec().check_ranges(check);
    }
}

impl Description {
    /// Reads the body of a PUT. Whether its fields agree with each other and a prior goes by the name that it gives is not
    /// asked: that takes the values of all fields.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, values out of range.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        let read = body::read_said(json, |_: &Said, _, _| ())?;
        Checked::new(Self(read.said))
    }

    /// Of these fields.
    #[cfg(feature = "core")]
    pub(crate) fn of(said: Map<String, Value>) -> Self {
        Self(said)
    }

    /// The spec that it is part of, everything else by default.
    pub(crate) fn spec(&self) -> Spec {
        // It was made of a spec.
        serde_json::from_value(Value::Object(self.0.clone())).unwrap_or_default()
    }

    /// Whether the field at `path` was said: `drive.lag_s`.
    pub fn says(&self, path: &str) -> bool {
        says(&self.0, path)
    }

    /// The name of the prior: that of the default one where it has no other and none of its own.
    pub fn prior(&self) -> Option<&str> {
        self.0.get("prior").map_or(Some(DEFAULT_PRIOR), Value::as_str)
    }
}

impl From<&Spec> for Description {
    /// Everything is said.
    fn from(spec: &Spec) -> Self {
        match serde_json::to_value(spec) {
            Ok(Value::Object(said)) => Self(said),
            // A number that JSON cannot say: it is refused where it is checked.
            _ => Self::default(),
        }
    }
}

fn says(fields: &Map<String, Value>, path: &str) -> bool {
    match path.split_once('.') {
        None => fields.contains_key(path),
        Some((first, rest)) => {
            matches!(fields.get(first), Some(Value::Object(inner)) if says(inner, rest))
        }
    }
}

#[cfg(feature = "document")]
mod schema {
    //! A description has the schema of a spec.

    use super::{Description, Spec};
    use std::borrow::Cow;
    use utoipa::openapi::RefOr;
    use utoipa::openapi::schema::Schema;
    use utoipa::{PartialSchema, ToSchema};

    impl PartialSchema for Description {
        fn schema() -> RefOr<Schema> {
            Spec::schema()
        }
    }

    impl ToSchema for Description {
        fn name() -> Cow<'static, str> {
            Spec::name()
        }

        fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
            Spec::schemas(schemas);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn said(body: &Value) -> Value {
        json!(Description::read(body.to_string().as_bytes()).unwrap().into_inner())
    }

    #[test]
    fn what_was_said_is_kept_as_it_was_meant() {
        assert_eq!(said(&json!({})), json!({}));
        let body = json!({"horizon_slots": 20.0, "drive": {"lag_s": 0}, "prior": {"turn": {"mu": 0, "k": 1, "r": 4, "s": 1}}});
        let meant = json!({"horizon_slots": 20, "drive": {"lag_s": 0.0}, "prior": {"turn": {"mu": 0.0, "k": 1.0, "r": 4.0, "s": 1.0}}});
        assert_eq!(said(&body), meant);
        let whole = json!(Spec::default());
        assert_eq!(said(&whole), whole);
    }

    /// Guards against a robot that cannot be described with a top speed below the default smallest one.
    #[test]
    fn only_what_was_said_is_checked() {
        assert!(Description::read(br#"{"drive": {"max_linear_m_per_s": 0.01}}"#).is_ok());
        let problems = Description::read(br#"{"drive": {"lag": 1, "lag_s": 9}}"#).unwrap_err();
        let fields: Vec<_> = problems.details().iter().map(|it| it.field.as_str()).collect();
        assert_eq!(fields, ["drive.lag", "drive.lag_s"]);
    }
}
