//! How long a waypoint takes that was missed by a centimetre or two, and whole tasks beside it.
//!
//! `cargo run --release -p umwelt-core --example measure_mending -- [RUNS] [SEED]` (default 400 runs per row, seed 1). A robot
//! with lag (80 ms) and dead time (40 ms), both known, seen by a camera, rests 11 to 25 mm off its waypoint (tolerance
//! 10 mm), which lies in any direction of it; the time is that until it is seen at rest there. Tasks are the thesis's, with
//! its calibration, whose time does not count, and without. Method `adaptive`, normal link, 20 slots.

#![allow(clippy::print_stdout, reason = "an example prints")]

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::error::Error;
use std::f64::consts::{PI, TAU};
use umwelt_core::episode::{Outcome, Scenario, TIME_LIMIT};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::Task;

/// A robot on a floor, without a task.
fn scenario(floor: &str) -> Result<Scenario, Box<dyn Error>> {
    let drive = Drive { lag: 0.08, dead_time: 0.04, ..Drive::default() };
    let settings = Settings {
        drive,
        noise: PoseNoise::CAMERA,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let slip = Slip::preset(floor).ok_or("no such floor")?;
    Ok(Scenario {
        settings,
        plant: PlantModel { drive, slip, noise: PoseNoise::CAMERA, ..PlantModel::default() },
        link: LinkModel::preset("normal").ok_or("no such link")?,
        task: Task::thesis(),
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: TIME_LIMIT,
    })
}

/// A task whose first waypoint is at `bearing` and so far away; where `goes_on` another one follows half a metre ahead.
fn missed(random: &mut Pcg64Mcg, goes_on: bool) -> (Task, f64) {
    let distance = 0.011 + 0.014 * random.random::<f64>();
    let bearing = TAU * random.random::<f64>() - PI;
    let first = Point::new(distance * bearing.cos(), distance * bearing.sin());
    let mut waypoints = vec![first];
    waypoints.extend(goes_on.then(|| Point::new(0.5, 0.0)));
    (Task { waypoints, calibration: None, ..Task::thesis() }, bearing)
}

fn show(name: &str, outcomes: &[Outcome]) {
    let sorted = |of: fn(&Outcome) -> f64| {
        let mut values: Vec<f64> = outcomes.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        move |part: f64| values[((values.len() - 1) as f64 * part) as usize]
    };
    let (time, deviation) = (sorted(|it| it.time), sorted(|it| 1e3 * it.max_deviation));
    let arrived = outcomes.iter().filter(|it| it.arrived).count();
    println!(
        "| {name} | {:.2} s | {:.2} s | {:.1} mm | {:.1} mm | {arrived} of {} |",
        time(0.5),
        time(0.9),
        deviation(0.5),
        deviation(0.9),
        outcomes.len()
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let runs: u64 = arguments.next().map_or(Ok(400), |runs| runs.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |seed| seed.parse())?;
    println!("{runs} runs per row, seed {seed}");
    println!("| | time, median | 90 % | deviation, median | 90 % | arrived |");
    println!("|---|--:|--:|--:|--:|--:|");
    for floor in ["hard", "dusty", "slippery"] {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (mut all, mut behind, mut beside) = (Vec::new(), Vec::new(), Vec::new());
        for run in 0..runs {
            let (task, bearing) = missed(&mut random, false);
            let outcome = Scenario { task, ..scenario(floor)? }.run((seed << 32) + run)?;
            all.push(outcome);
            if bearing.abs() > 0.75 * PI {
                behind.push(outcome);
            } else if bearing.abs() > 0.25 * PI {
                beside.push(outcome);
            }
        }
        show(&format!("missed, {floor}"), &all);
        show("of them behind", &behind);
        show("of them beside", &beside);
        let on = (0..runs).map(|run| {
            let (task, _) = missed(&mut random, true);
            Ok(Scenario { task, ..scenario(floor)? }.run((seed << 32) + run)?)
        });
        let on: Vec<Outcome> = on.collect::<Result<_, Box<dyn Error>>>()?;
        show("missed, and on by half a metre", &on);
        for calibration in [Task::thesis().calibration, None] {
            let tasks = (0..runs).map(|run| {
                let task = Task { calibration, ..Task::thesis() };
                Ok(Scenario { task, ..scenario(floor)? }.run((seed << 32) + run)?)
            });
            let tasks: Vec<Outcome> = tasks.collect::<Result<_, Box<dyn Error>>>()?;
            let how = if calibration.is_some() { "calibrated" } else { "not calibrated" };
            show(&format!("task, {floor}, {how}"), &tasks);
        }
    }
    Ok(())
}
