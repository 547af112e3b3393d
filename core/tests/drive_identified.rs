//! Robots of which nobody says how late they follow: it is identified, and what they do follows it.

#![allow(clippy::unwrap_used)] // a test that cannot go on fails

use umwelt_core::controller::Controller;
use umwelt_core::derived::{Quantity, complete};
use umwelt_core::drive::DriveEstimate;
use umwelt_core::episode::{Outcome, Scenario};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

const SEEDS: u64 = 6;

/// A robot of which nothing is described but its camera, on two legs with a corner between them.
fn scenario(lag: f64, dead_time: f64, rtt: f64) -> Scenario {
    let known = Settings { noise: PoseNoise::CAMERA, ..Settings::default() };
    let settings = complete(known, |_| false);
    let drive = Drive { lag, dead_time, ..settings.drive };
    let waypoints = vec![Point::new(0.8, 0.0), Point::new(0.8, 0.4)];
    Scenario {
        settings,
        plant: PlantModel {
            drive,
            slip: Slip::HARD,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(rtt)) },
        task: Task { waypoints, calibration: Some(Calibration::default()), ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 120.0,
    }
}

/// The same with its drive described as it is, or otherwise.
fn described(scenario: &Scenario, drive: Drive) -> Scenario {
    let is_said = |quantity| matches!(quantity, Quantity::Lag | Quantity::DeadTime);
    let settings = complete(Settings { drive, ..scenario.settings }, is_said);
    Scenario { settings, ..scenario.clone() }
}

/// Every run, which arrives.
fn runs(scenario: &Scenario) -> Vec<(Outcome, Controller)> {
    let run = |seed| scenario.run_with(seed, |_| {}).unwrap();
    let runs: Vec<_> = (0..SEEDS).map(run).collect();
    assert!(runs.iter().all(|(outcome, _)| outcome.arrived));
    runs
}

/// Mean time in s, and the largest deviation in m.
fn cost(runs: &[(Outcome, Controller)]) -> (f64, f64) {
    let time: f64 = runs.iter().map(|(outcome, _)| outcome.time).sum();
    let deviation = runs.iter().map(|(outcome, _)| outcome.max_deviation).fold(0.0, f64::max);
    (time / runs.len() as f64, deviation)
}

/// Guards against: a robot that is slower to follow than its description says strays and hunts, over any link.
#[test]
fn a_calibrated_robot_drives_as_if_its_lag_had_been_told() {
    for (lag, dead_time) in [(0.0, 0.0), (0.1, 0.03), (0.16, 0.04), (0.05, 0.25)] {
        for rtt in [0.04, 0.3] {
            let scenario = scenario(lag, dead_time, rtt);
            let identified = runs(&scenario);
            for (_, controller) in &identified {
                let sum = controller.drive_estimate().unwrap().sum;
                assert!(
                    (sum.mean - lag - dead_time).abs() < 0.010,
                    "{lag} + {dead_time} s: {sum:?}"
                );
            }
            let told = cost(&runs(&described(&scenario, scenario.plant.drive)));
            let (time, deviation) = cost(&identified);
            assert!(
                time < 1.05 * told.0 && deviation < 1.5 * told.1 + 0.001,
                "{lag} + {dead_time} s at {rtt} s: {time} s, {deviation} m, told {told:?}"
            );
        }
    }
}

/// Guards against: only those who calibrate have what was identified.
#[test]
fn starts_and_stops_of_legs_teach_it_too() {
    let mut scenario = scenario(0.16, 0.04, 0.04);
    scenario.task.calibration = None;
    for (_, controller) in runs(&scenario) {
        let sum = controller.drive_estimate().unwrap().sum;
        assert!((sum.mean - 0.2).abs() < 0.010, "{sum:?}");
    }
}

/// Guards against: what the user said is overruled, or a robot of an earlier version drives otherwise.
#[test]
fn what_is_described_is_not_identified() {
    let scenario = scenario(0.16, 0.04, 0.04);
    let wrong =
        runs(&described(&scenario, Drive { lag: 0.0, dead_time: 0.0, ..scenario.plant.drive }));
    assert!(wrong.iter().all(|(_, controller)| controller.drive_estimate().is_none()));
    let (time, _) = cost(&runs(&scenario));
    assert!(cost(&wrong).0 > 1.3 * time, "{} s against {time} s", cost(&wrong).0);
}

/// Guards against: a restart, a new floor or a new task begin from the prior.
#[test]
fn it_is_kept_over_restarts_and_floors() {
    let scenario = scenario(0.16, 0.04, 0.04);
    let (_, controller) = scenario.run_with(1, |_| {}).unwrap();
    let known = controller.drive_estimate();
    let saved = controller.saved();
    let task = controller.task().cloned();
    let mut restored = Controller::restore(scenario.settings, task, false, saved).unwrap();
    assert_eq!(restored.drive_estimate(), known);
    restored.restart_clock();
    restored.reset_belief();
    restored.set_task(Task::thesis());
    let late = |it: Option<DriveEstimate>| it.map(|it| (it.sum, it.lag, it.dead_time));
    assert_eq!(late(restored.drive_estimate()), late(known));
    // Said and taken back, it begins anew.
    let told = described(&scenario, Drive::default()).settings;
    restored.replace_settings(told);
    assert_eq!(restored.drive_estimate(), None);
    restored.replace_settings(scenario.settings);
    let anew = restored.drive_estimate().unwrap();
    assert_eq!((anew.stretches, anew.sum), (0, anew.prior));
}
