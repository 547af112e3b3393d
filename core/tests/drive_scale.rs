#![allow(clippy::unwrap_used)]
use umwelt_core::derived::{Quantity, complete};
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::*;
use umwelt_core::task::{Calibration, Task};

fn scenario(drive: Drive, floor: &str, calibrated: bool) -> Scenario {
    let known = Settings {
        noise: PoseNoise::CAMERA,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let settings = complete(known, |_| false);
    let drive = Drive { lag: 0.1, dead_time: 0.03, ..drive };
    let waypoints = vec![Point::new(1.8, 0.0), Point::new(1.8, 0.4)];
    Scenario {
        settings,
        plant: PlantModel { drive, slip: Slip::preset(floor).unwrap(), noise: PoseNoise::CAMERA },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
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
fn variants() {
    for (name, method, attribution, drift) in [("b sent", Method::Bayesian, Attribution::Sent, false), ("b played", Method::Bayesian, Attribution::Played, false), ("b played drift", Method::Bayesian, Attribution::Played, true), ("a sent", Method::Adaptive, Attribution::Sent, false), ("b sent drift", Method::Bayesian, Attribution::Sent, true)] {
        let mut times = vec![];
        for seed in 0..6 {
            let mut scenario = scenario(Drive::default(), "hard", true);
            scenario.settings.method = method; scenario.settings.attribution = attribution; scenario.settings.drift = drift;
            let (outcome, rows) = scenario.trace(seed).unwrap();
            times.push(outcome.time);
            if seed == 0 && name == "a sent" { let mut last = 0.0; for row in rows { if row.time > last + 0.5 { last = row.time; println!("{:.2} {:?} {} ({:.3} {:.3} {:.2}) {:?}", row.time, row.stage, row.leg, row.pose.x, row.pose.y, row.pose.heading.radians(), row.applied); } } }
        }
        println!("{name}: {times:.2?}");
    }
}
#[test]
fn measure() {
    let d = Drive::default();
    for (name, drive) in [
        ("as described", d),
        ("wheels -20 %", Drive { wheel_radius: 0.024, ..d }),
        ("wheels +20 %", Drive { wheel_radius: 0.036, ..d }),
        ("wheels x2", Drive { wheel_radius: 0.06, ..d }),
        ("track +3 %", Drive { track_width: 0.103, ..d }),
        ("unequal 2 %", Drive { unequal: 0.02, ..d }),
        ("all", Drive { wheel_radius: 0.024, track_width: 0.103, unequal: 0.02, ..d }),
    ] {
        for (floor, calibrated) in
            [("none", true), ("hard", true), ("hard", false), ("slippery", true)]
        {
            let run = |change: &dyn Fn(&mut Scenario)| {
                let (mut times, mut deviations) = (vec![], vec![]);
                let mut last = String::new();
                for seed in 0..20 {
                    let mut scenario = scenario(drive, floor, calibrated);
                    change(&mut scenario);
                    let (outcome, controller) = scenario.run_with(seed, |_| {}).unwrap();
                    times.push(outcome.time + if outcome.arrived { 0.0 } else { 1000.0 });
                    deviations.push(outcome.max_deviation * 1e3);
                    if let Some(it) = controller.drive_estimate() {
                        last = format!("{:.4} {:?}", it.sum.mean, it.scale.map(|q| (q.mean, q.sd)));
                    }
                }
                (middle(times), middle(deviations), last)
            };
            let adaptive = run(&|_| {});
            let told = run(&|it: &mut Scenario| {
                let p = it.plant.drive;
                let s = it.settings.drive;
                it.settings.drive = Drive {
                    wheel_radius: p.wheel_radius,
                    track_width: p.track_width,
                    unequal: p.unequal,
                    ..s
                };
            });
            let bayes = run(&|it: &mut Scenario| {
                it.settings.method = Method::Bayesian;
                it.settings.attribution = Attribution::Sent;
            });
            println!(
                "{name}, {floor} {calibrated}:\n   adaptive {adaptive:.3?}\n   told     {told:.3?}\n   bayesian {bayes:.3?}"
            );
        }
    }
    let _ = Quantity::ALL;
}
