//! The demo: a server, a fleet of simulated robots on different floors, a bad link, and the thesis's round trip.
//!
//! `cargo run --release --example fleet -- --help`

mod run;
mod show;
mod sweep;

use clap::{Parser, ValueEnum};
use std::process::ExitCode;
use umwelt_core::link::PRESETS;

/// Drives a fleet of simulated robots through a round trip, over real HTTP on the loopback interface.
///
/// Starts a server on a free port and one agent per robot, each on another floor (hard, dusty, slippery, in turn) with a
/// camera's noise and the chosen link in between. Each robot first learns its environment (ten rotations, 0.3 m straight),
/// then drives (0, 0) -> (0.2, 0) -> (-0.5, 0) m. A live table shows what the server knows; a summary ends it.
///
/// Examples:
///   fleet                                  three robots over the thesis's bad link
///   fleet --slots 1                        the thesis itself: one command per reply
///   fleet --link wifi-bursty --robots 10   seconds of silence now and then
///   fleet --robots 10 --sweep              the table of docs/results.md: clean, normal, bad x 1 and 20 slots
#[derive(Clone, Debug, Parser)]
#[command(name = "fleet", verbatim_doc_comment, max_term_width = 100)]
struct Options {
    /// How many robots.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=200))]
    robots: u16,
    /// The link between each robot and the server.
    #[arg(long, default_value = "bad", value_parser = PRESETS)]
    link: String,
    /// How the environment is identified.
    #[arg(long, value_enum, default_value = "bayesian")]
    method: Method,
    /// What errors are measured against: the commands as sent (the thesis) or as the robot reports to have played them.
    #[arg(long, value_enum, default_value = "sent")]
    attribution: Attribution,
    /// Commands per reply; 1 is the thesis.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=67))]
    slots: u16,
    /// Seed of floors, cameras and links.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print the summary as one JSON document on standard output.
    #[arg(long)]
    json: bool,
    /// Drive the fleet over clean, normal and bad with 1 and 20 slots, five seeds each from `--seed` on, and print the
    /// table. The fleets of one line drive at the same time. Takes four minutes.
    #[arg(long, conflicts_with_all = ["link", "slots"])]
    sweep: bool,
    /// Give up after this many seconds.
    #[arg(long, default_value_t = 300)]
    timeout: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Method {
    FixedNormal,
    FixedBad,
    Statistic,
    Bayesian,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Attribution {
    Sent,
    Played,
}

#[tokio::main]
async fn main() -> ExitCode {
    let options = Options::parse();
    let done = if options.sweep {
        sweep::run(&options).await
    } else {
        match run::fleet(&options, &[options.seed], options.slots, &options.link).await {
            Ok(summary) => show::summary(&summary, options.json).map(|()| summary.all_arrived()),
            Err(error) => Err(error),
        }
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("not every robot arrived within {} s", options.timeout);
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
