//! Describing a robot: what the flags and a file say of it.

use super::super::failure::Failure;
use super::super::input;
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;
use umwelt_api::PriorId;
use umwelt_api::robot::{
    Attribution, DERIVED, Description, IDENTIFIED, Kind, Method, NOISE, Patch, Robot, Spec,
};

pub(super) const METHODS: &[&str] =
    &["fixed-normal", "fixed-bad", "statistic", "bayesian", "adaptive"];
pub(super) const ATTRIBUTIONS: &[&str] = &["sent", "played"];
const KINDS: &[&str] = &["differential", "skid-steer"];

/// What can be said of a robot. "derived" stands for what follows from the rest.
#[derive(Debug, Args)]
pub(super) struct Flags {
    /// How the environment is identified [default: adaptive]
    #[arg(long, value_parser = input::named::<Method>(METHODS))]
    method: Option<Method>,
    /// What errors are measured against: commands as sent or as played [default: sent; played with method adaptive]
    #[arg(long, value_parser = input::named::<Attribution>(ATTRIBUTIONS))]
    attribution: Option<Attribution>,
    /// Use the drift channel: heading error per metre [default: it is not used]
    #[arg(long)]
    drift: bool,
    /// Slots of 30 ms per reply; 1 is the thesis [default: derived: 40, or three loop delays]
    #[arg(long, value_name = "N")]
    slots: Option<usize>,
    /// Time from a pose being taken to its reply being applied [default: identified; 0.23 before the first delivery]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    loop_delay: Option<f64>,
    /// Time from a pose being taken to its stamp, where the tracker stamps late or not at all [default: 0]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sensor_delay: Option<f64>,
    /// How long the robot goes on without replies before it ramps to rest; 0 is for ever, for simulations [default:
    /// derived: 0.3, more where the loop delay is more than 0.23]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    watchdog: Option<f64>,
    /// Standard deviation of an observed position [default: identified; 0.0005 of methods other than adaptive]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    position_noise: Option<f64>,
    /// Standard deviation of an observed heading [default: identified; 0.003 of methods other than adaptive]
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    heading_noise: Option<f64>,
    /// What the robot believes of the floor before any sample: a name of `umwelt prior list` [default: default]
    #[arg(long, value_name = "NAME")]
    prior: Option<PriorId>,
    /// Speed of the steering law on a straight line [default: derived: 1.54 times the largest speed]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    steering_speed: Option<f64>,
    /// Distance to a waypoint at which the robot stops [default: derived: 1/15 of the wheel radius, at least the noise]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    stop_radius: Option<f64>,
    /// Distance from a waypoint within which the robot has arrived, where its task says none [default: derived: a third
    /// of the wheel radius, at least 2.5 times the noise]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Standard deviation of the predicted position above which the robot slows down [default: derived: what it drives
    /// in 77 ms at its largest speed]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    position_limit: Option<f64>,
    // Last, because its heading holds for all flags below it.
    #[command(flatten)]
    drive: Drive,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Drive")]
struct Drive {
    /// Radius of both wheels [default: 0.03]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    wheel_radius: Option<f64>,
    /// Distance between the wheels [default: 0.1]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    track_width: Option<f64>,
    /// What the wheels do on the ground: differential (they roll) or skid-steer (they slide sideways in turns) [default:
    /// differential]
    #[arg(long, value_parser = input::named::<Kind>(KINDS))]
    kind: Option<Kind>,
    /// Of skid steer: how far the tracked point moves to the left per radian of turn to the left [default: 0]
    #[arg(long, value_name = "M/RAD", allow_negative_numbers = true)]
    sideways: Option<f64>,
    /// Of skid steer: by what part it turns more per m/s of speed, where --track-width is that of turns in place
    /// [default: 0]
    #[arg(long, value_name = "S/M", allow_negative_numbers = true)]
    turn_by_speed: Option<f64>,
    /// Largest speed of either wheel [default: derived: the largest speed and turn at once, and a quarter more]
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    max_wheel_speed: Option<f64>,
    /// Largest speed [default: derived: 0.13, or what --max-wheel-speed allows]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    max_speed: Option<f64>,
    /// Smallest speed at which the motors turn [default: derived: 0.77 rad/s of the wheels]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    min_speed: Option<f64>,
    /// Largest angular velocity [default: derived: 1.25, less where the track is wide for the speed]
    #[arg(long, alias = "max-angular", value_name = "RAD/S", allow_negative_numbers = true)]
    max_turn: Option<f64>,
    /// Smallest angular velocity of a turn in place [default: derived: a third of a rad/s of the wheels]
    #[arg(long, alias = "min-angular", value_name = "RAD/S", allow_negative_numbers = true)]
    min_turn: Option<f64>,
    /// Largest change of speed [default: derived: 0.3, or the largest speed in 3.3 s]
    #[arg(long, value_name = "M/S^2", allow_negative_numbers = true)]
    max_acceleration: Option<f64>,
    /// Largest change of angular velocity [default: derived: that of speed over the track]
    #[arg(
        long,
        alias = "max-angular-acceleration",
        value_name = "RAD/S^2",
        allow_negative_numbers = true
    )]
    max_turn_acceleration: Option<f64>,
    /// Time constant with which the wheels follow a command [default: identified; 0.11 before the first motion; 0 where
    /// --dead-time is said]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    lag: Option<f64>,
    /// Time before the wheels begin to follow a command [default: identified; 0.02 before the first motion; 0 where --lag
    /// is said]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dead_time: Option<f64>,
}

impl Flags {
    /// What they say, each in its field.
    fn say(&self, patch: &mut Patch) {
        let drive = &self.drive;
        let mut say = |path: &str, value: Option<Value>| {
            if let Some(value) = value {
                patch.set(path, value);
            }
        };
        say("method", of(self.method));
        say("attribution", of(self.attribution));
        say("drift", self.drift.then_some(json!(true)));
        say("horizon_slots", of(self.slots));
        say("loop_delay_s", of(self.loop_delay));
        say("sensor_delay_s", of(self.sensor_delay));
        say("watchdog_s", of(self.watchdog));
        say("noise.position_m", of(self.position_noise));
        say("noise.heading_rad", of(self.heading_noise));
        say("prior", of(self.prior.as_ref()));
        say("steering.alpha_m_per_s", of(self.steering_speed));
        say("steering.stop_radius_m", of(self.stop_radius));
        say("steering.tolerance_m", of(self.tolerance));
        say("variance.position_m2", of(self.position_limit.map(|sd| sd * sd)));
        say("drive.wheel_radius_m", of(drive.wheel_radius));
        say("drive.track_width_m", of(drive.track_width));
        say("drive.max_wheel_speed_rad_per_s", of(drive.max_wheel_speed));
        say("drive.max_linear_m_per_s", of(drive.max_speed));
        say("drive.min_linear_m_per_s", of(drive.min_speed));
        say("drive.max_angular_rad_per_s", of(drive.max_turn));
        say("drive.min_angular_rad_per_s", of(drive.min_turn));
        say("drive.max_linear_acceleration_m_per_s2", of(drive.max_acceleration));
        say("drive.max_angular_acceleration_rad_per_s2", of(drive.max_turn_acceleration));
        say("drive.kind", of(drive.kind));
        say("drive.sideways_m_per_rad", of(drive.sideways));
        say("drive.turn_by_speed_s_per_m", of(drive.turn_by_speed));
        say("drive.lag_s", of(drive.lag));
        say("drive.dead_time_s", of(drive.dead_time));
    }

    /// The file, with the flags on top.
    pub(super) fn description(&self, file: Option<&Path>) -> Result<Description, Failure> {
        let mut said = Description::default();
        let mut source = "the description".to_owned();
        if let Some(path) = file {
            source = input::name(path);
            let read = Description::read(&input::read(path)?);
            said = read.map_err(|problems| Failure::wrong_body(&source, &problems))?.into_inner();
            source.push_str(" with these flags");
        }
        let mut patch = Patch::default();
        self.say(&mut patch);
        let read = Description::read(&said.patched(&patch));
        let read = read.map_err(|problems| Failure::wrong_body(&source, &problems))?;
        Ok(read.into_inner())
    }

    /// What they change, and what is taken back.
    pub(super) fn patch(&self, unset: &[String]) -> Result<Patch, Failure> {
        let mut patch = Patch::default();
        self.say(&mut patch);
        let read = Description::read(&Description::default().patched(&patch));
        read.map_err(|problems| Failure::wrong_body("the change", &problems))?;
        let known = Description::from(&Spec::default());
        for field in unset {
            if !known.says(field) {
                let text = format!(
                    "--unset {field}: there is no such field; `umwelt robot show` lists them"
                );
                return Err(Failure::Wrong(text));
            }
            patch.set(field, Value::Null);
        }
        if patch.is_empty() {
            return Err(Failure::Wrong(
                "nothing to change: give a flag or --unset FIELD".to_owned(),
            ));
        }
        Ok(patch)
    }
}

/// A value that was given, as JSON. A number that JSON cannot say becomes none, which its field refuses.
fn of(value: Option<impl Serialize>) -> Option<Value> {
    value.map(|value| json!(value))
}

/// Where the value of a field comes from.
fn origin(robot: &Robot, path: &str) -> &'static str {
    let said = &robot.described;
    let is_noise = NOISE.contains(&path);
    let is_asked = robot.spec.method == Method::Adaptive && !NOISE.iter().any(|it| said.says(it));
    if said.says(path) {
        "set"
    } else if IDENTIFIED.contains(&path) && (is_asked || !is_noise) {
        "until identified"
    } else if DERIVED.contains(&path) {
        "derived"
    } else {
        "default"
    }
}

/// What is known of a robot, one field a line: its value with its unit, and where that comes from.
pub(super) fn understood(robot: &Robot) -> String {
    let mut fields = Vec::new();
    flatten("", &serde_json::to_value(&robot.spec).unwrap_or_default(), &mut fields);
    let widest = |column: fn(&(String, String)) -> usize| fields.iter().map(column).max();
    let width = widest(|(path, _)| path.len()).unwrap_or(0);
    let values = widest(|(_, value)| value.len()).unwrap_or(0);
    let line = |(path, value): &(String, String)| {
        let origin = origin(robot, path);
        format!("  {path:<width$}  {value:<values$}  {origin}\n")
    };
    fields.iter().map(line).collect()
}

/// Each field with its path, named as in the file, and its value with its unit.
fn flatten(path: &str, value: &Value, fields: &mut Vec<(String, String)>) {
    match value {
        Value::Object(object) => {
            for (name, value) in object {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                flatten(&path, value, fields);
            }
        }
        Value::String(text) => fields.push((path.to_owned(), text.clone())),
        Value::Number(number) if number.is_f64() => {
            let number = short(number.as_f64().unwrap_or_default());
            fields
                .push((path.to_owned(), format!("{number} {}", unit(path)).trim_end().to_owned()));
        }
        other => fields.push((path.to_owned(), other.to_string())),
    }
}

/// A number with four digits that count.
fn short(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let rounded: f64 = format!("{number:.3e}").parse().unwrap_or(number);
    if (1e-5..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// The unit that the name of a field ends with.
fn unit(path: &str) -> &'static str {
    const UNITS: [(&str, &str); 11] = [
        ("_rad_per_s2", "rad/s^2"),
        ("_m_per_s2", "m/s^2"),
        ("_rad_per_s", "rad/s"),
        ("_m_per_s", "m/s"),
        ("_m_per_rad", "m/rad"),
        ("_s_per_m", "s/m"),
        ("_rad2", "rad^2"),
        ("_m2", "m^2"),
        ("_rad", "rad"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    UNITS.into_iter().find(|(ending, _)| path.ends_with(ending)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_have_their_unit() {
        for (number, text) in [
            (0.0, "0"),
            (0.33846153, "0.3385"),
            (1e-4, "0.0001"),
            (2.0, "2"),
            (1e-10, "1e-10"),
            (-0.7, "-0.7"),
        ] {
            assert_eq!(short(number), text);
        }
        assert_eq!(
            (unit("drive.lag_s"), unit("variance.position_m2"), unit("method")),
            ("s", "m^2", "")
        );
        assert_eq!(unit("drive.max_angular_acceleration_rad_per_s2"), "rad/s^2");
        let [sideways, by_speed] = ["sideways_m_per_rad", "turn_by_speed_s_per_m"].map(unit);
        assert_eq!((sideways, by_speed), ("m/rad", "s/m"));
    }
}
