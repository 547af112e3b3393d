//! Faults injected into a server and a fleet of robots, and what must hold all the same.
//!
//! `cargo run --release -p umwelt-tests --example faults -- --help`

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use umwelt_tests::faults::{self, Plan};

/// Injects faults into a server and robots that drive, and counts what must not be.
///
/// Starts a server as a process on a data directory of its own and an agent as a process for each robot, which drives to
/// and fro behind a link of its own. In this process each robot truly moves, is seen by a camera, and is judged. Faults
/// come to several robots and to the server at the same time: SIGKILL, SIGSTOP and SIGTERM to the server, a full disk
/// (with the program prlimit), a held store, SIGKILL to agents, cut, half-open and silent links, requests overtaken and
/// repeated, a frozen and a dark tracker, blocked wheels. Meanwhile operators stop and resume robots, give them tasks,
/// and change priors, environments and robots that stand around.
///
/// 0 must be: acknowledged facts lost; robots that move after an acknowledged stop and before a resume; lines of wheel
/// speeds beyond a limit of the drive; robots that drive blind for more than 2 s beyond what they do by themselves;
/// agents and servers that end by themselves or do not end when told to; robots that do not go on after a fault.
///
/// The schedule follows from the seed and is said on standard error as it is followed; where exactly a fault falls is up
/// to the machine. 300 injections with 20 robots take about a quarter of an hour. docs/faults.md says how to read it.
///
/// Exit status: 0 all of that is 0, 1 it is not, 2 the call was wrong.
///
/// Examples:
///   faults                              20 robots, 300 injections
///   faults --robots 6 --injections 36   two rounds of all kinds, some minutes
///   faults --seed 7 --json              another schedule; the counters as one JSON document on standard output
#[derive(Clone, Debug, Parser)]
#[command(name = "faults", verbatim_doc_comment, max_term_width = 100)]
struct Options {
    /// How many robots drive.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=200))]
    robots: u16,
    /// How many faults are injected; kinds come in rounds of all 18.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    injections: u16,
    /// Seed of the schedule, the floors and the cameras.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print the counters as one JSON document on standard output, not as a table.
    #[arg(long)]
    json: bool,
    /// Say nothing on standard error meanwhile.
    #[arg(long)]
    quiet: bool,
}

#[tokio::main]
async fn main() -> ExitCode {
    let Options { robots, injections, seed, json, quiet } = Options::parse();
    let (robots, injections) = (robots.into(), injections.into());
    let report = faults::run(Plan { robots, injections, seed, is_quiet: quiet }).await;
    let text = if json {
        serde_json::to_string_pretty(&report).unwrap_or_else(|error| error.to_string())
    } else {
        report.to_string()
    };
    let is_said = writeln!(std::io::stdout(), "{text}").is_ok();
    if is_said && report.is_clean() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
