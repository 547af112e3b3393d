//! The scenarios: what is driven, and in which environments.
//!
//! Every constant that the thesis leaves out is named here with its reason.

use super::contender;
use super::environment::Environment;
use super::settings::ComparisonSettings;
use std::f64::consts::FRAC_PI_2;
use umwelt_core::episode::Region;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Outage};
use umwelt_core::plant::{PlantModel, Slip, SlipChannel};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::Task;

/// The names that [`ComparisonSettings::scenario`] knows.
pub const SCENARIOS: [&str; 7] =
    ["thesis", "thesis-real", "floor-change", "link-change", "bursty", "outage", "systematic"];

/// Trials of each contender in each environment where none are said. The thesis has 15.
pub const TRIALS: usize = 1000;

/// Longest time in s from the end of the calibration to the arrival on the thesis's round trip of 0.9 m: eighteen times
/// what a robot takes at full speed. Beyond it a robot counts as not arrived.
const SHORT_LIMIT: f64 = 180.0;

/// The same on the longer tasks, of 3.7 and 4.8 m.
const LONG_LIMIT: f64 = 400.0;

/// Length in m of the legs of the long task: environments change in the middle of a leg of at least 2 m.
const LONG_LEG: f64 = 2.4;

/// Where on the long leg the environment changes, and where it changes back, in m.
const CHANGED: (f64, f64) = (0.8, 1.6);

/// Time constant in s with which the wheels of the field robot follow, and the time before they begin to: 120 ms in all,
/// in the middle of the 60 to 200 ms of field facts.
const FIELD_LAG: (f64, f64) = (0.08, 0.04);

/// When the outage begins and how long it lasts, in s: the calibration takes some 20 s, the first leg as long at full
/// speed, and 4 s are a silence as Wi-Fi to a moving robot has them (field facts: whole seconds, worst 12 s).
const OUTAGE: Outage = Outage { start: 30.0, duration: 4.0 };

/// The robot of the thesis, whose wheels follow at once: its model knows no lag.
fn thesis_robot() -> Settings {
    Settings { noise: PoseNoise::CAMERA, ..Settings::default() }
}

/// A robot as they are: its wheels lag, and its controller knows by how much.
fn field_robot() -> Settings {
    let (lag, dead_time) = FIELD_LAG;
    let drive = Drive { lag, dead_time, ..Drive::default() };
    Settings { drive, ..thesis_robot() }
}

/// A robot that is not quite as it is described to its controller (field facts: robots differ by 0.4 % and 1 %; these are some
/// times that, a robot with a worn wheel and a load): wheels 2 % too large, a track 4 % too wide, one wheel larger than
/// the other, so that it drifts by 0.05 rad/m, and a lag of which its controller knows nothing.
fn uncalibrated(settings: &Settings) -> PlantModel {
    let (lag, dead_time) = FIELD_LAG;
    let described = settings.drive;
    let drive = Drive {
        wheel_radius: 1.02 * described.wheel_radius,
        track_width: 1.04 * described.track_width,
        lag,
        dead_time,
        ..described
    };
    let drift = SlipChannel::new(0.05, Slip::HARD.drift.sd()).expect("constants in their domain");
    PlantModel {
        drive,
        slip: Slip { drift, ..Slip::HARD },
        noise: settings.noise,
        ..PlantModel::default()
    }
}

fn link(name: &str) -> LinkModel {
    LinkModel::preset(name).expect("a preset")
}

fn robot(settings: &Settings, slip: Slip) -> PlantModel {
    PlantModel { drive: settings.drive, slip, noise: settings.noise, ..PlantModel::default() }
}

fn environment(name: &str, plant: PlantModel, link: LinkModel) -> Environment {
    Environment { name: name.to_owned(), plant, link, region: None }
}

/// There and back along x, calibration first.
fn long_task() -> Task {
    let waypoints = vec![Point::new(LONG_LEG, 0.0), Point::new(0.0, 0.0)];
    Task { waypoints, ..Task::thesis() }
}

/// The thesis's corridor of 1.85 m, there and back.
fn corridor() -> (Task, Pose) {
    let (here, there) = (Point::new(-0.035, -0.865), Point::new(-0.145, 0.975));
    // It stands at the first point, along the corridor.
    let start = Pose::new(here.x, here.y, FRAC_PI_2);
    (Task { waypoints: vec![here, there, here], ..Task::thesis() }, start)
}

impl ComparisonSettings {
    /// The scenario called `name`, one of [`SCENARIOS`], with every contender, [`TRIALS`] trials and seed 1.
    ///
    /// - `thesis`: (0,0) -> (0.2,0) -> (-0.5,0) m on a hard floor, normal and bad link, a robot without lag.
    /// - `thesis-real`: the thesis's corridor, there and back; the robot lags and its controller knows it.
    /// - `floor-change`: 2.4 m there and back; the floor is slippery from 0.8 to 1.6 m.
    /// - `link-change`: the same way; the link is bad from 0.8 to 1.6 m.
    /// - `bursty`: the same way over bursty Wi-Fi with silences, on a hard and on a slippery floor.
    /// - `outage`: the same way; nothing gets through for 4 s.
    /// - `systematic`: the thesis's trip with a robot that is not as described.
    ///
    /// ```
    /// use umwelt_lab::comparison::{ComparisonSettings, SCENARIOS};
    /// assert!(SCENARIOS.iter().all(|name| ComparisonSettings::scenario(name).is_some()));
    /// assert_eq!(ComparisonSettings::scenario("moon"), None);
    /// ```
    pub fn scenario(name: &str) -> Option<Self> {
        let (thesis, field) = (thesis_robot(), field_robot());
        let hard = robot(&field, Slip::HARD);
        let slippery = robot(&field, Slip::SLIPPERY);
        let both = |plant| {
            vec![
                environment("normal", plant, link("normal")),
                environment("bad-link", plant, link("bad")),
            ]
        };
        let region = |slip, link| {
            let (from, to) = CHANGED;
            Some(Region { from, to, slip, link })
        };
        let at_origin = |task| (task, Pose::default());
        let (controller, (task, start), limit, environments) = match name {
            "thesis" => {
                let environments = both(robot(&thesis, Slip::HARD));
                (thesis, at_origin(Task::thesis()), SHORT_LIMIT, environments)
            }
            "thesis-real" => (field, corridor(), LONG_LIMIT, both(hard)),
            "floor-change" => {
                let with_patch = |it: Environment| Environment {
                    region: region(Slip::SLIPPERY, it.link.clone()),
                    ..it
                };
                let environments = both(hard).into_iter().map(with_patch).collect();
                (field, at_origin(long_task()), LONG_LIMIT, environments)
            }
            "link-change" => {
                let with_corner = |name, plant: PlantModel| Environment {
                    region: region(plant.slip, link("bad")),
                    ..environment(name, plant, link("normal"))
                };
                let environments =
                    vec![with_corner("hard", hard), with_corner("slippery", slippery)];
                (field, at_origin(long_task()), LONG_LIMIT, environments)
            }
            "bursty" => {
                let environments = vec![
                    environment("hard", hard, link("wifi-bursty")),
                    environment("slippery", slippery, link("wifi-bursty")),
                ];
                (field, at_origin(long_task()), LONG_LIMIT, environments)
            }
            "outage" => {
                let silent = |name| LinkModel { outages: vec![OUTAGE], ..link(name) };
                let environments = vec![
                    environment("normal", hard, silent("normal")),
                    environment("bad-link", hard, silent("bad")),
                ];
                (field, at_origin(long_task()), LONG_LIMIT, environments)
            }
            "systematic" => {
                let environments = both(uncalibrated(&thesis));
                (thesis, at_origin(Task::thesis()), SHORT_LIMIT, environments)
            }
            _ => return None,
        };
        Some(Self {
            scenario: name.to_owned(),
            contenders: contender::all(),
            environments,
            controller,
            task,
            start,
            time_limit: limit,
            trials: TRIALS,
            seed: 1,
        })
    }
}
