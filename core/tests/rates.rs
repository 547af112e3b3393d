//! Poses at any rate: a robot arrives as soon and as exactly as what they show of it allows.

#![allow(clippy::unwrap_used)] // a test that cannot go on fails

use umwelt_core::derived::complete;
use umwelt_core::episode::{Outcome, Scenario};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

/// Drives a metre and back on this floor, seen every `frame` s.
fn run(slip: Slip, frame: f64, seed: u64) -> Outcome {
    let known = Settings {
        noise: PoseNoise::CAMERA,
        identifies_noise: true,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let settings = complete(known, |_| false);
    let drive = Drive { lag: 0.1, dead_time: 0.03, ..settings.drive };
    let scenario = Scenario {
        settings,
        plant: PlantModel { drive, slip, noise: PoseNoise::CAMERA, ..PlantModel::default() },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
        task: Task {
            waypoints: vec![Point::new(1.0, 0.0), Point::new(0.0, 0.0)],
            calibration: Some(Calibration::default()),
            ..Task::thesis()
        },
        start: Pose::default(),
        region: None,
        frame,
        time_limit: 120.0,
    };
    scenario.run(seed).unwrap()
}

/// Median time in s and median of the largest deviations in m of nine runs, all of which arrive.
fn median(slip: Slip, frame: f64) -> (f64, f64) {
    let runs: Vec<_> = (0..9).map(|seed| run(slip, frame, seed)).collect();
    assert!(runs.iter().all(|it| it.arrived), "every {frame} s: {runs:?}");
    let middle = |of: fn(&Outcome) -> f64| {
        let mut values: Vec<_> = runs.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[4]
    };
    (middle(|it| it.time), middle(|it| it.max_deviation))
}

/// Guards against: a tracker that is slower or faster than the slots costs more than the poses that it does not send.
#[test]
fn poses_at_any_rate_drive_as_well_as_one_per_slot() {
    for slip in [Slip::HARD, Slip::DUSTY] {
        let (time, deviation) = median(slip, 0.03);
        for rate in [2.0, 5.0, 10.0, 20.0, 60.0, 250.0] {
            let (slower, farther) = median(slip, 1.0 / rate);
            // Each of four rests lasts until a pose shows it; what the floor does between two poses is seen with the second.
            let unseen = (1.0 / rate - 0.03).max(0.0);
            assert!(
                slower < time + 4.0 * unseen + 0.5 && farther < 2.5 * deviation + 0.001,
                "{rate} Hz: {slower} s, {farther} m; once per slot {time} s, {deviation} m"
            );
        }
    }
}

/// Guards against: a camera whose interval is a slot but for a rounding keeps its robot at one command for ever.
#[test]
fn poses_a_whisker_beside_the_slots_drive_as_well() {
    let (time, _) = median(Slip::HARD, 0.03);
    for off in [-1e-5, -3e-7, -1e-8, 1e-9, 1e-8, 3e-7, 1e-6, 1e-5] {
        let (slower, farther) = median(Slip::HARD, 0.03 + off);
        assert!(slower < 1.1 * time && farther < 0.005, "{off}: {slower} s, {farther} m");
    }
}
