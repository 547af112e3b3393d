//! What fusing poses is worth, and how well their noise is identified: `measure_poses [RUNS]` drives simulated robots by noisy
//! trackers at several rates, with the noise described and not, and prints time, deviation, how far the robot is from where
//! it is believed to be, and how often the 90 % intervals of the noise hold the truth.

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::collections::VecDeque;
use std::error::Error;
use umwelt_core::controller::Controller;
use umwelt_core::derived::{Quantity, complete};
use umwelt_core::episode::{Scenario, TraceRow};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

/// Two metres there and back over a link of 90 ms, seen `rate` times a second with this noise, which is described or not.
fn scenario(
    (method, is_described): (Method, bool),
    noise: PoseNoise,
    rate: f64,
    slip: Slip,
) -> Scenario {
    let described =
        Drive { wheel_radius: 0.033, track_width: 0.16, max_linear: 0.22, ..Drive::default() };
    let known = Settings {
        drive: described,
        noise: if is_described { noise } else { PoseNoise::CAMERA },
        identifies_noise: !is_described,
        method,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let settings = complete(known, |it| it == Quantity::MaxLinear);
    let drive = Drive { lag: 0.1, dead_time: 0.03, ..settings.drive };
    Scenario {
        settings,
        plant: PlantModel { drive, slip, noise, ..PlantModel::default() },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
        task: Task {
            waypoints: vec![Point::new(2.0, 0.0), Point::new(0.0, 0.0)],
            tolerance: settings.steering.tolerance,
            calibration: Some(Calibration::default()),
            ..Task::thesis()
        },
        start: Pose::default(),
        region: None,
        frame: 1.0 / rate,
        time_limit: 200.0,
    }
}

/// How far the robot was from where it was believed to be when its poses were taken: sum of squares in m^2, and how many.
#[derive(Default)]
struct Off {
    truth: VecDeque<(f64, Point)>,
    last: f64,
    square: f64,
    count: f64,
}

impl Off {
    fn take(&mut self, row: &TraceRow, controller: &Controller) {
        self.truth.push_back((row.time, row.pose.point()));
        let Some(believed) = controller.pose() else { return };
        let taken = believed.taken.seconds();
        if taken <= self.last {
            return;
        }
        self.last = taken;
        while self.truth.front().is_some_and(|(time, _)| *time < taken - 1e-9) {
            self.truth.pop_front();
        }
        if let Some((time, point)) = self.truth.front()
            && (time - taken).abs() < 1e-6
        {
            self.square += point.distance(believed.pose.point()).powi(2);
            self.count += 1.0;
        }
    }
}

/// Drives the scenario so often and prints a line.
fn measure(scenario: &Scenario, runs: u64, about: &str) -> Result<(), Box<dyn Error>> {
    let (mut times, mut deviations, mut held) = (Vec::new(), Vec::new(), [0_u64; 2]);
    let mut off = Off::default();
    let truth = [scenario.plant.noise.position, scenario.plant.noise.heading];
    for seed in 0..runs {
        (off.truth, off.last) = (VecDeque::new(), 0.0);
        let controller = Controller::new(scenario.settings);
        let show = |row: &TraceRow, controller: &Controller| off.take(row, controller);
        let (outcome, controller) = scenario.drive(controller, seed, show)?;
        times.push(if outcome.arrived { outcome.time } else { f64::INFINITY });
        deviations.push(outcome.max_deviation);
        let identified = controller.noise_belief().map(|belief| belief.identified());
        for (index, it) in identified.into_iter().flatten().enumerate() {
            held[index] += u64::from((it.interval.0..=it.interval.1).contains(&truth[index]));
        }
    }
    times.sort_by(f64::total_cmp);
    deviations.sort_by(f64::total_cmp);
    let at = |values: &[f64], part: f64| values[(part * (values.len() - 1) as f64) as usize];
    let (time, median) = (at(&times, 0.5), 1e3 * at(&deviations, 0.5));
    let p90 = 1e3 * at(&deviations, 0.9);
    let off = 1e3 * (off.square / off.count).sqrt();
    let holds = match scenario.settings.method {
        Method::Adaptive => {
            let [position, heading] = held.map(|held| 1e2 * held as f64 / runs as f64);
            format!("{position:.0} %, {heading:.0} %")
        }
        _ => "-".to_owned(),
    };
    println!("| {about} | {time:.1} s | {median:.1} mm | {p90:.1} mm | {off:.2} mm | {holds} |");
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(40), |text| text.parse())?;
    println!(
        "| noise | poses | floor | method | noise is | time | deviation, median | p90 | off | noise held |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (position, heading) in [(0.0005, 0.003), (0.003, 0.01), (0.01, 0.017)] {
        for rate in [10.0, 30.0, 100.0] {
            for floor in ["hard", "dusty"] {
                let slip = Slip::preset(floor).ok_or("no such floor")?;
                for (method, is_described) in
                    [(Method::Bayesian, true), (Method::Adaptive, true), (Method::Adaptive, false)]
                {
                    let noise = PoseNoise { position, heading };
                    let scenario = scenario((method, is_described), noise, rate, slip);
                    let said = if is_described { "described" } else { "identified" };
                    let about = format!(
                        "{} mm | {rate} Hz | {floor} | `{}` | {said}",
                        1e3 * position,
                        method.name()
                    );
                    measure(&scenario, runs, &about)?;
                }
            }
        }
    }
    Ok(())
}
