//! What fusing poses is worth, and how well their noise is identified: `measure_poses [RUNS]` drives simulated robots by noisy
//! trackers at several rates, with the noise described and not, and prints time, deviation, how far the robot is from where
//! it is believed to be, and how often the interval of the noise holds the truth.

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use umwelt_core::controller::Controller;
use umwelt_core::derived::{Quantity, complete};
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

fn main() -> Result<(), Box<dyn Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(20), |text| text.parse())?;
    let drive =
        Drive { wheel_radius: 0.033, track_width: 0.16, max_linear: 0.22, ..Drive::default() };
    println!(
        "noise       Hz floor    described  method    arrived  time   dev p50  p90 mm  off, rms mm: fused, observed  sd, mm  holds position, heading"
    );
    for noise in [0.0005, 0.003, 0.01] {
        let noise = PoseNoise { position: noise, heading: noise.max(0.003) * 1.75 };
        for hz in [10.0, 30.0, 100.0] {
            for floor in ["hard", "dusty", "slippery"] {
                for (described, method) in
                    [(true, Method::Bayesian), (true, Method::Adaptive), (false, Method::Adaptive)]
                {
                    let known = Settings {
                        drive,
                        noise: if described { noise } else { PoseNoise::CAMERA },
                        identifies_noise: !described,
                        method,
                        attribution: Attribution::Played,
                        ..Settings::default()
                    };
                    let settings = complete(known, |it| it == Quantity::MaxLinear);
                    let real = Drive { lag: 0.1, dead_time: 0.03, ..settings.drive };
                    let scenario = Scenario {
                        settings,
                        plant: PlantModel {
                            drive: real,
                            slip: Slip::preset(floor).ok_or("no such floor")?,
                            noise,
                        },
                        link: LinkModel {
                            sensor_delay: 0.05,
                            ..LinkModel::ordinary(Rtt::Constant(0.04))
                        },
                        task: Task {
                            waypoints: vec![Point::new(2.0, 0.0), Point::new(0.0, 0.0)],
                            tolerance: settings.steering.tolerance,
                            calibration: Some(Calibration::default()),
                            ..Task::thesis()
                        },
                        start: Pose::default(),
                        region: None,
                        frame: 1.0 / hz,
                        time_limit: 200.0,
                    };
                    let (mut times, mut deviations, mut arrived) = (Vec::new(), Vec::new(), 0);
                    let mut off = (0.0, 0.0);
                    let mut held = [0; 2];
                    let mut sds = 0.0;
                    for seed in 0..runs {
                        let mut truth = std::collections::VecDeque::new();
                        let mut last = 0.0;
                        let show = |row: &umwelt_core::episode::TraceRow,
                                    controller: &Controller| {
                            truth.push_back((row.time, row.pose.point()));
                            let Some(pose) = controller.pose() else { return };
                            let taken = pose.taken.seconds();
                            if taken <= last {
                                return;
                            }
                            last = taken;
                            while truth.front().is_some_and(|it: &(f64, Point)| it.0 < taken - 1e-9)
                            {
                                truth.pop_front();
                            }
                            if let Some((at, point)) = truth.front()
                                && (at - taken).abs() < 1e-6
                            {
                                off.0 += point.distance(pose.pose.point()).powi(2);
                                off.1 += 1.0;
                            }
                        };
                        let (outcome, controller) =
                            scenario.drive(Controller::new(settings), seed, show)?;
                        arrived += u32::from(outcome.arrived);
                        times.push(outcome.time);
                        deviations.push(outcome.max_deviation);
                        if let Some(belief) = controller.noise_belief() {
                            let truth = [noise.position, noise.heading];
                            for ((held, it), truth) in
                                held.iter_mut().zip(belief.identified()).zip(truth)
                            {
                                *held +=
                                    u32::from((it.interval.0..=it.interval.1).contains(&truth));
                            }
                            sds += belief.noise().position;
                        }
                    }
                    times.sort_by(f64::total_cmp);
                    deviations.sort_by(f64::total_cmp);
                    let at =
                        |values: &[f64], p: f64| values[(p * (values.len() - 1) as f64) as usize];
                    println!(
                        "{:6.1} mm {hz:6.1} {floor:9} {described:6} {:10} {arrived:4}/{runs} {:6.1} s {:6.1} {:6.1}   {:6.2} {:6.2}   {:6.2}  {held:?}",
                        1e3 * noise.position,
                        method.name(),
                        at(&times, 0.5),
                        1e3 * at(&deviations, 0.5),
                        1e3 * at(&deviations, 0.9),
                        1e3 * (off.0 / off.1 as f64).sqrt(),
                        1e3 * noise.position * 2f64.sqrt(),
                        1e3 * sds / runs as f64,
                    );
                }
            }
        }
    }
    Ok(())
}
