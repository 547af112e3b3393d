//! Chooses the constants that the sources of a peer leave open: tries a small grid of them on seeds of which nothing is
//! reported, over every link of a scenario.
//!
//! `cargo run --release -p umwelt-lab --example tune_peers -- PEER [SCENARIO] [SEEDS]` (defaults: `thesis`, 100 seeds).
//! The rule: all robots arrive; the median time, mean over the links, is within 5 % of the best; of those, the least
//! score: the deviation that 90 % stay within, geometric mean over the links. `-` before PEER drives the tuned one alone.

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::time::Instant;
use umwelt_core::controller::Controller;
use umwelt_core::controller::compensation::{
    Compensation, DelayModel, PathFollower, PoseEstimator,
};
use umwelt_core::episode::{EpisodeError, Scenario};
use umwelt_core::settings::{Attribution, Settings};
use umwelt_lab::comparison::ComparisonSettings;
use umwelt_lab::peers::{
    EkfPacket, EkfTuning, GpMpcTuning, GpTuning, MpcTuning, NoCompensation, SlidingTuning,
    StaleTuning, without_identification,
};

/// Seeds of tuning begin here: comparisons draw theirs from all 64 bits, everything else counts from zero.
const FIRST_SEED: u64 = 1_000_000;

/// Time in s that an episode may take beyond the limit: its calibration.
const CALIBRATION_TIME: f64 = 60.0;

/// What a robot may take longer than the fastest one tried.
const SLOWER: f64 = 1.05;

/// The results of one choice on one link.
struct Row {
    arrived: usize,
    time: f64,
    deviations: [f64; 3],
}

/// What is tried, on which seeds.
struct Trials {
    comparison: ComparisonSettings,
    seeds: u64,
    /// (label, rows by link).
    tried: Vec<(String, Vec<Row>)>,
}

impl Trials {
    /// Drives every link with the peer that `make` makes for the settings of all.
    fn run<E: PoseEstimator, D: DelayModel, F: PathFollower>(
        &mut self,
        label: String,
        slots: usize,
        make: impl Fn(&Settings) -> (Settings, Compensation<E, D, F>),
    ) -> Result<(), EpisodeError> {
        let begun = Instant::now();
        let ComparisonSettings { environments, controller, time_limit, .. } = &self.comparison;
        let mut rows = Vec::new();
        for environment in environments {
            let (settings, _) = make(&Settings { slots, ..*controller });
            let scenario = Scenario {
                time_limit: time_limit + CALIBRATION_TIME,
                ..self.comparison.episode(environment, settings)
            };
            let (mut times, mut deviations, mut arrived) = (Vec::new(), Vec::new(), 0);
            for seed in FIRST_SEED..FIRST_SEED + self.seeds {
                let controller = Controller::with(settings, make(&settings).1);
                let (outcome, _) = scenario.drive(controller, seed, |_, _| {})?;
                let in_time = outcome.arrived && outcome.time <= *time_limit;
                arrived += usize::from(in_time);
                times.push(if in_time { outcome.time } else { *time_limit });
                deviations.push(outcome.max_deviation * 1e3);
            }
            let time = quantile(&mut times, 0.5);
            let deviations = [0.5, 0.9, 1.0].map(|share| quantile(&mut deviations, share));
            rows.push(Row { arrived, time, deviations });
        }
        let driven = self.seeds as f64 * rows.len() as f64;
        let cost = begun.elapsed().as_secs_f64() * 1e3 / driven;
        let cells = rows.iter().map(|row| {
            let Row { arrived, time, deviations: [half, most, all] } = row;
            format!("{arrived} | {time:.2} | {half:.2} | {most:.2} | {all:.1}")
        });
        let (cells, score) = (cells.collect::<Vec<_>>().join(" | "), score(&rows));
        println!("| {label} | {cells} | {score:.2} | {cost:.1} |");
        self.tried.push((label, rows));
        Ok(())
    }

    /// The choice by the rule.
    fn chosen(&self) -> Option<&str> {
        let mean = |rows: &[Row], of: fn(&Row) -> f64| {
            rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64
        };
        let time = |rows: &[Row]| mean(rows, |row| row.time);
        let arrive = |rows: &[Row]| rows.iter().all(|row| row.arrived as u64 == self.seeds);
        let able = || self.tried.iter().filter(|(_, rows)| arrive(rows));
        let fastest = able().map(|(_, rows)| time(rows)).fold(f64::INFINITY, f64::min);
        let quick = able().filter(|(_, rows)| time(rows) <= SLOWER * fastest);
        quick
            .min_by(|one, other| score(&one.1).total_cmp(&score(&other.1)))
            .map(|(label, _)| label.as_str())
    }
}

/// Deviation in mm that all but a tenth stay within, geometric mean over the links: each counts by its own measure.
fn score(rows: &[Row]) -> f64 {
    let logarithms = rows.iter().map(|row| row.deviations[1].ln());
    (logarithms.sum::<f64>() / rows.len().max(1) as f64).exp()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let peer = arguments.next().ok_or("which peer?")?;
    let name = arguments.next().unwrap_or_else(|| "thesis".to_owned());
    let seeds = arguments.next().map_or(Ok(100), |seeds| seeds.parse())?;
    let comparison = ComparisonSettings::scenario(&name).ok_or("no such scenario")?;
    println!("{name}, {seeds} seeds each; deviations in mm, cost in ms per episode\n");
    let column = "arrived | time s | median | 90 % | max";
    let columns: Vec<_> =
        comparison.environments.iter().map(|it| format!("{}: {column}", it.name)).collect();
    println!("| | {} | score | cost |", columns.join(" | "));
    println!("|---|{}--:|", "--:|".repeat(5 * columns.len() + 1));
    let mut trials = Trials { comparison, seeds, tried: Vec::new() };
    match peer.as_str() {
        "no-compensation" | "-no-compensation" => {
            trials.run(peer, 1, |settings| {
                (without_identification(settings), NoCompensation::compensation())
            })?;
        }
        "stop-when-stale" => stop_when_stale(&mut trials)?,
        "ekf-packet" => ekf_packet(&mut trials)?,
        "sliding-mode" => sliding_mode(&mut trials)?,
        "gp-mpc" => gp_mpc(&mut trials)?,
        "-stop-when-stale" => trials.run(peer, 1, |settings| {
            let tuning = StaleTuning::default();
            (tuning.settings(settings), tuning.compensation())
        })?,
        "-ekf-packet" => trials.run(peer, EkfPacket::SLOTS, |settings| {
            let tuning = EkfTuning::default();
            (tuning.settings(settings), tuning.compensation(settings))
        })?,
        "-sliding-mode" => trials.run(peer, 1, |settings| {
            let tuning = SlidingTuning::default();
            (tuning.settings(settings), tuning.compensation(settings))
        })?,
        "-gp-mpc" => trials.run(peer, 1, |settings| {
            let tuning = GpMpcTuning::default();
            (tuning.settings(settings), tuning.compensation(settings))
        })?,
        _ => return Err("no such peer".into()),
    }
    println!("\nchosen: {}", trials.chosen().unwrap_or("none: some do not arrive"));
    Ok(())
}

fn stop_when_stale(trials: &mut Trials) -> Result<(), EpisodeError> {
    for watchdog in [0.10, 0.22, 0.30] {
        for stale in [0.05, 0.10, 0.25] {
            trials.run(format!("watchdog {watchdog} stale {stale}"), 1, |settings| {
                let tuning = StaleTuning { watchdog, stale };
                (tuning.settings(settings), tuning.compensation())
            })?;
        }
    }
    Ok(())
}

const ATTRIBUTIONS: [(&str, Attribution); 2] =
    [("sent", Attribution::Sent), ("played", Attribution::Played)];

fn ekf_packet(trials: &mut Trials) -> Result<(), EpisodeError> {
    for (name, attribution) in ATTRIBUTIONS {
        for share in [0.02, 0.05, 0.1, 0.2] {
            for drift in [0.03, 0.1, 0.3] {
                for floor in [(0.0, 0.0), (0.0002, 0.001), (0.001, 0.005)] {
                    let label = format!("{name} share {share} drift {drift} floor {floor:?}");
                    trials.run(label, EkfPacket::SLOTS, |settings| {
                        let tuning = EkfTuning { share, drift, floor, attribution };
                        (tuning.settings(settings), tuning.compensation(settings))
                    })?;
                }
            }
        }
    }
    Ok(())
}

fn sliding_mode(trials: &mut Trials) -> Result<(), EpisodeError> {
    let one = |trials: &mut Trials, tuning: SlidingTuning| {
        trials.run(format!("{tuning:?}"), 1, |settings| {
            (tuning.settings(settings), tuning.compensation(settings))
        })
    };
    let base = SlidingTuning::default();
    for (_, attribution) in ATTRIBUTIONS {
        for ahead in [1, 4, 8] {
            for margin in [0.0, 2.0, 4.0, 8.0, 12.0, 16.0] {
                one(trials, SlidingTuning { attribution, ahead, margin, ..base })?;
            }
        }
    }
    for slope in [4.0, 8.0, 16.0] {
        for proportional in [0.5, 1.0, 2.0] {
            for (reaching, layer) in [(0.05, 0.05), (0.1, 0.1), (0.2, 0.1), (0.2, 0.05)] {
                one(trials, SlidingTuning { slope, proportional, reaching, layer, ..base })?;
            }
        }
    }
    Ok(())
}

fn gp_mpc(trials: &mut Trials) -> Result<(), EpisodeError> {
    let one = |trials: &mut Trials, label: String, tuning: GpMpcTuning| {
        trials.run(label, 1, |settings| (tuning.settings(settings), tuning.compensation(settings)))
    };
    let base = GpMpcTuning::default();
    for (name, attribution) in ATTRIBUTIONS {
        for length in [0.3, 1.0, 3.0] {
            for (rate, turn) in [(0.002, 0.02), (0.005, 0.05), (0.02, 0.2)] {
                let position = GpTuning { signal: rate, length };
                let heading = GpTuning { signal: turn, length };
                let label = format!("{name} signal {rate} {turn} length {length}");
                one(trials, label, GpMpcTuning { position, heading, attribution, ..base })?;
            }
        }
    }
    for step in [0.07, 0.1] {
        for cross in [1.0, 3.0, 10.0] {
            for heading in [0.3, 1.0, 3.0] {
                for change in [0.03, 0.3] {
                    let control = MpcTuning { step, cross, heading, change };
                    one(trials, format!("{control:?}"), GpMpcTuning { control, ..base })?;
                }
            }
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
