//! Where a calibration leaves the robot: `measure_calibration [RUNS]` simulates the thesis's task behind its calibration, over
//! the normal link, and prints how often the task begins more than 0.1 m from where the calibration began, how far in half
//! and nine of ten runs, and what the task takes.

#![allow(clippy::print_stdout, reason = "an example prints")]

use umwelt_core::episode::Scenario;
use umwelt_core::geometry::Pose;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Method, PoseNoise, Settings};
use umwelt_core::task::{Stage, Task};

/// Farther in m from where the calibration began the task does not begin where it was meant to.
const AWAY: f64 = 0.1;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    println!(
        "| method | floor | begins away | away, median | 90 % | arrived | time, median | deviation, median | 90 % |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|--:|");
    for method in [Method::Statistic, Method::Bayesian] {
        for floor in ["hard", "dusty", "slippery", "towing"] {
            let settings = Settings { method, noise: PoseNoise::CAMERA, ..Settings::default() };
            let scenario = Scenario {
                settings,
                plant: PlantModel {
                    drive: settings.drive,
                    slip: Slip::preset(floor).ok_or("no such floor")?,
                    noise: settings.noise,
                    ..PlantModel::default()
                },
                link: LinkModel::preset("normal").ok_or("no such link")?,
                task: Task::thesis(),
                start: Pose::default(),
                region: None,
                frame: umwelt_core::episode::FRAME,
                time_limit: 120.0,
            };
            let (mut away, mut times, mut deviations) = (Vec::new(), Vec::new(), Vec::new());
            for seed in 0..runs {
                let mut begins = None;
                let (outcome, _) = scenario.run_with(seed, |row| {
                    if row.stage == Stage::Calibrating {
                        begins = Some(row.pose.point());
                    }
                })?;
                away.push(begins.ok_or("it calibrates")?.distance(Pose::default().point()));
                if outcome.arrived {
                    times.push(outcome.time);
                }
                deviations.push(outcome.max_deviation);
            }
            let share = away.iter().filter(|it| **it > AWAY).count() as f64 / runs as f64;
            let arrived = times.len();
            let [half, most] = [0.5, 0.9].map(|part| 1e3 * quantile(&mut away, part));
            let [strayed, farther] = [0.5, 0.9].map(|part| 1e3 * quantile(&mut deviations, part));
            println!(
                "| {} | {floor} | {:.1} % | {half:.0} mm | {most:.0} mm | {arrived}/{runs} | {:.2} s | {strayed:.1} mm | {farther:.1} mm |",
                method.name(),
                1e2 * share,
                quantile(&mut times, 0.5),
            );
        }
    }
    Ok(())
}

/// The value below which `share` of `values` lie, nearest rank; 0 without values.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (values.len().saturating_sub(1) as f64 * share).round() as usize;
    values.get(rank).copied().unwrap_or_default()
}
