//! How often a robot that is described as differential is proposed to be skid-steer: `measure_kind [RUNS]` simulates a
//! calibration and a task of two legs on several floors, of robots that are one or the other, and prints in what part of the
//! runs it is, the evidence, and how often the 90 % intervals of its two numbers hold them.

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use umwelt_core::derived::complete;
use umwelt_core::drive::{Quantity, SkidEstimate};
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::{Drive, Kind, SkidSteer};
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{Lateness, PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

/// A robot of this kind on this floor, described as differential: 0.13 m/s, a round trip of 40 ms, a lag that its seed draws.
fn scenario(skid: SkidSteer, slip: Slip, seed: u64) -> Scenario {
    let known = Settings {
        noise: PoseNoise::CAMERA,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let waypoints = vec![Point::new(1.0, 0.0), Point::new(1.0, 0.4)];
    let Lateness { lag, dead_time } = Lateness::drawn(seed);
    let drive = Drive { lag, dead_time, kind: Kind::SkidSteer(skid), ..Drive::default() };
    Scenario {
        settings: complete(known, |_| false),
        plant: PlantModel { drive, slip, noise: PoseNoise::CAMERA, ..PlantModel::default() },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
        task: Task { waypoints, calibration: Some(Calibration::default()), ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 120.0,
    }
}

/// What part of the estimates has it, in %.
fn part(estimates: &[SkidEstimate], has: impl Fn(&SkidEstimate) -> bool) -> f64 {
    let those = estimates.iter().filter(|it| has(it)).count();
    100.0 * those as f64 / estimates.len() as f64
}

/// The middle one.
fn median(estimates: &[SkidEstimate], of: impl Fn(&SkidEstimate) -> f64) -> f64 {
    let mut values: Vec<f64> = estimates.iter().map(of).collect();
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(400), |runs| runs.parse())?;
    let skid = |sideways, turn_by_speed| SkidSteer { turn_by_speed, sideways };
    let robots = [
        ("differential", skid(0.0, 0.0)),
        ("marker 3 mm off", skid(0.003, 0.0)),
        ("sideways +0.02", skid(0.02, 0.0)),
        ("sideways -0.02", skid(-0.02, 0.0)),
        ("sideways +0.05", skid(0.05, 0.0)),
        ("by speed +1.0", skid(0.0, 1.0)),
        ("+0.02, -1.0", skid(0.02, -1.0)),
    ];
    println!("{runs} runs each; evidence and sideways are medians, the rest parts in %");
    println!("floor     robot            proposed  ln evidence  sideways  held  by speed  held");
    let floors = [("hard", Slip::HARD), ("dusty", Slip::DUSTY), ("slippery", Slip::SLIPPERY)];
    for (floor, slip) in floors {
        for (name, skid) in robots {
            let mut estimates = Vec::new();
            for seed in 0..runs {
                let (_, controller) = scenario(skid, slip, seed).run_with(seed, |_| {})?;
                estimates.extend(controller.drive_estimate().and_then(|it| it.skid));
            }
            let holds = |it: Quantity, value| it.interval.0 <= value && value <= it.interval.1;
            println!(
                "{floor:<9} {name:<16} {:>8.2}  {:>11.1}  {:>8.4}  {:>4.0}  {:>8.2}  {:>4.0}",
                part(&estimates, SkidEstimate::is_proposed),
                median(&estimates, |it| it.ln_evidence),
                median(&estimates, |it| it.sideways.mean),
                part(&estimates, |it| holds(it.sideways, skid.sideways)),
                median(&estimates, |it| it.turn_by_speed.mean),
                part(&estimates, |it| holds(it.turn_by_speed, skid.turn_by_speed)),
            );
        }
    }
    Ok(())
}
