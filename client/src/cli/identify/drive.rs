//! The wheels of a recorded robot, as far as they are said.

use super::super::failure::Failure;
use super::super::input;
use serde_json::{Map, Value, json};
use std::path::Path;
use umwelt_api::robot::{Description, Drive};
use umwelt_core::geometry::{Twist, WheelSpeeds};
use umwelt_core::kinematics;

/// The drive, and whether its wheels were said.
pub(super) struct Wheels {
    pub(super) drive: kinematics::Drive,
    said: bool,
}

impl Wheels {
    /// What `--drive` says: pairs of field and value, or the path of a description.
    pub(super) fn read(text: &str) -> Result<Self, Failure> {
        let (source, json) = if text.is_empty() {
            ("--drive".to_owned(), b"{}".to_vec())
        } else if text.contains('=') {
            ("--drive".to_owned(), json!({"drive": fields(text)?}).to_string().into_bytes())
        } else if text.ends_with(".csv") {
            return Err(Failure::Wrong(format!(
                "--drive is {text}, a recording: put each FILE before --drive, or give --drive a description"
            )));
        } else {
            let path = Path::new(text);
            (input::name(path), input::read(path)?)
        };
        let read = Description::read(&json);
        let said = read.map_err(|problems| Failure::wrong_body(&source, &problems))?.into_inner();
        let fields = serde_json::to_value(&said).unwrap_or_default();
        let drive: Drive = serde_json::from_value(fields["drive"].clone()).unwrap_or_default();
        Ok(Self {
            drive: drive.convert(),
            said: said.says("drive.wheel_radius_m") && said.says("drive.track_width_m"),
        })
    }

    /// The motion of wheels that turn so fast; none where the wheels were not said.
    pub(super) fn twist(&self, left: f64, right: f64) -> Option<Twist> {
        self.said.then(|| kinematics::forward(&self.drive, WheelSpeeds { left, right }))
    }
}

/// Fields of a drive, as `wheel_radius_m=0.033,track_width_m=0.16`.
fn fields(text: &str) -> Result<Map<String, Value>, Failure> {
    let pair = |pair: &str| {
        let (name, value) = pair.split_once('=')?;
        let value: f64 = value.trim().parse().ok()?;
        value.is_finite().then(|| (name.trim().to_owned(), json!(value)))
    };
    let field = |text: &str| {
        pair(text).ok_or_else(|| {
            Failure::Wrong(format!(
                "--drive: \"{text}\" is not FIELD=NUMBER: use wheel_radius_m=0.033,track_width_m=0.16"
            ))
        })
    };
    text.split(',').map(field).collect()
}
