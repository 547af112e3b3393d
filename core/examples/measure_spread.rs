//! How fast a belief finds the spread of a floor, and whether its intervals hold: one prior per channel against a mixture.
//!
//! `cargo run --release -p umwelt-core --example measure_spread -- [RUNS] [SEED]` (default 4000 runs, seed 1). In each run a
//! robot drives 0.13 m/s through consecutive windows of 120 ms on a floor whose forward ratio has the mean -0.05 and the
//! spread of the row, seen by a camera of 0.5 mm. Shown are the median and the 90 % quantile of the spread as it is shown
//! after so many windows; how many samples, camera and all, lay within the 90 % interval that was predicted for each (the
//! first ten of every run are not asked); and how often the interval that is shown after the last window holds the next
//! ratio over 100 ms, seen without a camera.

#![allow(clippy::print_stdout, reason = "an example prints")]

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;
use umwelt_core::identification::estimate::Channel;
use umwelt_core::identification::{Belief, Sample};
use umwelt_core::settings::{Method, PoseNoise, Prior};
use umwelt_core::time::RobotTime;

/// Time in s of a window, and the motion in m that it makes at 0.13 m/s.
const WINDOW: (f64, f64) = (0.12, 0.0156);

const MEAN: f64 = -0.05;
const FLOORS: [f64; 4] = [0.005, 0.006, 0.05, 0.25];
const WINDOWS: [u32; 5] = [5, 10, 30, 90, 400];

/// Samples of a run before intervals are asked.
const BEFORE: u64 = 10;

/// What one run shows: the spread after each of [`WINDOWS`], samples within and asked, whether the next ratio is held.
struct Run {
    spreads: Vec<f64>,
    within: u64,
    asked: u64,
    held: bool,
}

fn run(method: Method, spread: f64, seed: u64) -> Run {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut normal = || random.sample::<f64, _>(StandardNormal);
    let mut belief = Belief::new(method, &Prior::default(), true);
    let (noise, (duration, motion)) = (PoseNoise::CAMERA.position, WINDOW);
    let (weight, mut before) = (duration / 0.1, noise * normal());
    let mut run = Run { spreads: Vec::new(), within: 0, asked: 0, held: false };
    for window in 1..=WINDOWS[WINDOWS.len() - 1] {
        let after = noise * normal();
        let ratio = MEAN + spread / weight.sqrt() * normal() + (after - before) / motion;
        let pose_variance = noise * noise;
        let sample = Sample { ratio, weight, motion, pose_variance, other_variance: 0.0 };
        let start = RobotTime::new(f64::from(window) * duration);
        let known = belief.channel(Channel::Forward);
        if known.samples() >= BEFORE {
            run.asked += 1;
            run.within += u64::from(known.expects(&belief.model().forward, &sample, start));
        }
        belief.update(&[Some(sample), None, None, None], start, start + duration);
        if WINDOWS.contains(&window) {
            let [shown, ..] = belief.estimates(None).channels;
            run.spreads.push(shown.sd.unwrap_or(f64::INFINITY));
            let next = MEAN + spread * normal();
            run.held =
                shown.predictive_interval.is_some_and(|(low, high)| low <= next && next <= high);
        }
        before = after;
    }
    run
}

fn main() -> Result<(), std::num::ParseIntError> {
    let mut arguments = std::env::args().skip(1);
    let runs: u64 = arguments.next().map_or(Ok(4000), |runs| runs.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |seed| seed.parse())?;
    println!(
        "{runs} runs, seed {seed}: spread shown in %, median / 90 % quantile; intervals that hold"
    );
    let windows = WINDOWS.map(|windows| windows.to_string()).join(" | ");
    println!("| floor | belief | {windows} | each sample | next ratio |");
    println!("|---|---|--:|--:|--:|--:|--:|--:|--:|");
    for spread in FLOORS {
        for (method, name) in [(Method::Bayesian, "one"), (Method::Adaptive, "mixture")] {
            let all: Vec<Run> =
                (0..runs).map(|index| run(method, spread, (seed << 32) + index)).collect();
            let shown = (0..WINDOWS.len()).map(|at| {
                let mut spreads: Vec<f64> = all.iter().map(|run| run.spreads[at]).collect();
                spreads.sort_by(f64::total_cmp);
                let quantile = |of: usize| 100.0 * spreads[spreads.len() * of / 10];
                format!("{:.2} / {:.2}", quantile(5), quantile(9))
            });
            let shown = shown.collect::<Vec<_>>().join(" | ");
            let sum = |of: fn(&Run) -> u64| all.iter().map(of).sum::<u64>() as f64;
            println!(
                "| {:.1} % | {name} | {shown} | {:.1} % | {:.1} % |",
                100.0 * spread,
                100.0 * sum(|it| it.within) / sum(|it| it.asked),
                100.0 * sum(|it| u64::from(it.held)) / sum(|_| 1),
            );
        }
    }
    Ok(())
}
