//! Robots of which nobody says how late they follow: it is identified, and what they do follows it.

#![allow(clippy::unwrap_used)] // a test that cannot go on fails

use umwelt_core::derived::{Quantity, complete};
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

fn scenario(lag: f64, dead_time: f64, floor: &str, calibrated: bool, rtt: Rtt) -> Scenario {
    let known = Settings { noise: PoseNoise::CAMERA, ..Settings::default() };
    let settings = complete(known, |_| false);
    let drive = Drive { lag, dead_time, ..settings.drive };
    let waypoints = vec![Point::new(0.8, 0.0), Point::new(0.8, 0.4)];
    Scenario {
        settings,
        plant: PlantModel { drive, slip: Slip::preset(floor).unwrap(), noise: PoseNoise::CAMERA },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(rtt) },
        task: Task {
            waypoints,
            calibration: calibrated.then(Calibration::default),
            ..Task::thesis()
        },
        start: Pose::default(),
        region: None,
        time_limit: 120.0,
    }
}

fn middle(mut of: Vec<f64>) -> (f64, f64) {
    of.sort_by(f64::total_cmp);
    (of[of.len() / 2], of[of.len() * 9 / 10])
}

#[test]
fn measure() {
    for (lag, dead_time) in [(0.0,0.0), (0.06,0.0), (0.16, 0.04), (0.2,0.2)] {
        for (floor, calibrated) in
            [("hard", false), ("hard", true), ("dusty", true), ("slippery", true)]
        {
            for rtt in [Rtt::Constant(0.3), Rtt::Constant(0.7)] {
                let run = |change: fn(&mut Scenario)| {
                    let (mut times, mut deviations, mut off) = (vec![], vec![], vec![]);
                    for seed in 0..20 {
                        let mut scenario = scenario(lag, dead_time, floor, calibrated, rtt.clone());
                        change(&mut scenario);
                        let (outcome, controller) = scenario.run_with(seed, |_| {}).unwrap();
                        times.push(outcome.time + if outcome.arrived { 0.0 } else { 1000.0 });
                        deviations.push(outcome.max_deviation * 1e3);
                        if let Some(it) = controller.drive_estimate() {
                            off.push((it.sum.mean - lag - dead_time) * 1e3);
                        } else {
                            off.push(0.0)
                        }
                    }
                    (middle(times), middle(deviations), middle(off))
                };
                let identified = run(|_| {});
                let oracle = run(|it| {
                    it.settings.identifies_lag = false;
                    it.settings.drive = it.plant.drive;
                });
                let none = run(|it| {
                    it.settings.identifies_lag = false;
                    it.settings.drive.lag = 0.0;
                    it.settings.drive.dead_time = 0.0;
                });
                println!(
                    "{lag} {dead_time} {floor} {calibrated} {rtt:?}:\n  id {identified:.2?}\n  or {oracle:.2?}\n  0  {none:.2?}"
                );
            }
        }
    }
    let _ = Quantity::ALL;
}
