//! What a horizon is worth, in simulated time: completion time and maximum deviation of the thesis's round trip over
//! each link, with one slot per horizon (the thesis) and with twenty.
//!
//! `cargo run --release -p umwelt-core --example link_table -- [SEEDS] [FLOOR]` (default 400 seeds on `hard`).
//! Deviation is that of the true position; every seed is a robot with a camera of 0.5 mm and 3 mrad.

#![allow(clippy::print_stdout, reason = "an example prints")]

use umwelt_core::episode::{Scenario, TIME_LIMIT};
use umwelt_core::geometry::Pose;
use umwelt_core::link::{LinkModel, PRESETS};
use umwelt_core::plant::{PlantModel, SLIP_PRESETS, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(400), |seeds| seeds.parse())?;
    let floor = arguments.next().unwrap_or_else(|| "hard".to_owned());
    let slip = Slip::preset(&floor).ok_or(format!("a floor is one of {SLIP_PRESETS:?}"))?;
    println!("| slots | link | arrived | median time s | median deviation mm | p90 mm | max mm |");
    println!("|--:|---|--:|--:|--:|--:|--:|");
    for slots in [1, 20] {
        for name in PRESETS {
            let settings = Settings { slots, noise: PoseNoise::CAMERA, ..Settings::default() };
            let scenario = Scenario {
                settings,
                plant: PlantModel {
                    drive: settings.drive,
                    slip,
                    noise: settings.noise,
                    ..PlantModel::default()
                },
                link: LinkModel::preset(name).ok_or("no such link")?,
                task: Task::thesis(),
                start: Pose::default(),
                region: None,
                frame: umwelt_core::episode::FRAME,
                time_limit: TIME_LIMIT,
            };
            let (mut times, mut deviations, mut arrived) = (Vec::new(), Vec::new(), 0);
            for seed in 0..seeds {
                let outcome = scenario.run(seed)?;
                arrived += u64::from(outcome.arrived);
                times.push(outcome.time);
                deviations.push(outcome.max_deviation * 1e3);
            }
            let time = quantile(&mut times, 0.5);
            let [half, most, all] = [0.5, 0.9, 1.0].map(|share| quantile(&mut deviations, share));
            println!(
                "| {slots} | {name} | {arrived}/{seeds} | {time:.2} | {half:.2} | {most:.2} | {all:.1} |"
            );
        }
    }
    Ok(())
}

/// The value below which `share` of `values` lie, nearest rank; 0 without values.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (values.len().saturating_sub(1) as f64 * share).round() as usize;
    values.get(rank).copied().unwrap_or(0.0)
}
