//! How well skid-steer robots drive: `measure_skid_steer [RUNS]` simulates episodes (a calibration, then a leg of 1.8 m, or
//! that and one of 0.4 m around a corner) of robots of several kinds, each described as what it is and as differential, and
//! prints the median time, the largest deviations of 50 and 90 % of the runs, and how many arrived.

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use umwelt_core::derived::complete;
use umwelt_core::episode::{Outcome, Scenario};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::{Drive, Kind, SkidSteer};
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

/// A robot of this kind on this floor, described as of that kind: 0.13 m/s, its lag not known, a round trip of 40 ms.
fn scenario(kind: Kind, described: Kind, slip: Slip, legs: usize) -> Scenario {
    let drive = Drive { kind: described, ..Drive::default() };
    let known = Settings {
        drive,
        noise: PoseNoise::CAMERA,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let waypoints = [Point::new(1.8, 0.0), Point::new(1.8, 0.4)][..legs].to_vec();
    let drive = Drive { lag: 0.1, dead_time: 0.03, kind, ..Drive::default() };
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

/// The value below which `part` of them lie.
fn quantile(outcomes: &[Outcome], of: fn(&Outcome) -> f64, part: f64) -> f64 {
    let mut values: Vec<f64> = outcomes.iter().map(of).collect();
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len() - 1;
    values[(part * last as f64).round() as usize]
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(50), |runs| runs.parse())?;
    let skid = |sideways, turn_by_speed| Kind::SkidSteer(SkidSteer { turn_by_speed, sideways });
    let kinds = [
        ("differential", Kind::Differential),
        ("sideways +0.02", skid(0.02, 0.0)),
        ("sideways -0.02", skid(-0.02, 0.0)),
        ("sideways +0.05", skid(0.05, 0.0)),
        ("sideways -0.05", skid(-0.05, 0.0)),
        ("by speed +1.0", skid(0.0, 1.0)),
        ("by speed -1.0", skid(0.0, -1.0)),
        ("+0.02, -1.0", skid(0.02, -1.0)),
    ];
    println!("{runs} runs each; time in s, deviation in mm");
    println!("floor     legs  robot           described as    time  dev50  dev90  arrived");
    let floors = [("hard", Slip::HARD), ("dusty", Slip::DUSTY), ("slippery", Slip::SLIPPERY)];
    for ((floor, slip), legs) in floors.into_iter().flat_map(|floor| [(floor, 1), (floor, 2)]) {
        for (name, kind) in kinds {
            for (told, described) in [("itself", kind), ("differential", Kind::Differential)] {
                if kind == Kind::Differential && told != "itself" {
                    continue;
                }
                let scenario = scenario(kind, described, slip, legs);
                let outcomes =
                    (0..runs).map(|seed| scenario.run(seed)).collect::<Result<Vec<_>, _>>()?;
                let arrived = outcomes.iter().filter(|outcome| outcome.arrived).count();
                let deviation =
                    |part| 1000.0 * quantile(&outcomes, |outcome| outcome.max_deviation, part);
                let time = quantile(&outcomes, |outcome| outcome.time, 0.5);
                let (half, most) = (deviation(0.5), deviation(0.9));
                println!(
                    "{floor:<9} {legs:>4}  {name:<15} {told:<13} {time:>6.1} {half:>6.1} {most:>6.1}  {arrived:>4}"
                );
            }
        }
    }
    Ok(())
}
