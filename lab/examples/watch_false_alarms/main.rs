//! Counts what the watch says in ordinary driving, where it has nothing to say:
//! `cargo run --release -p umwelt-lab --example watch_false_alarms -- 10` drives ten simulated hours, spread over the
//! scenarios of `compare`. Ends with 1 where a robot was brought to rest.

#![expect(clippy::print_stdout, reason = "an example prints")]

mod driving;

use std::process::ExitCode;
use umwelt_lab::comparison::SCENARIOS;

fn main() -> ExitCode {
    let hours = std::env::args().nth(1).map_or(Ok(1.0), |hours| hours.parse::<f64>());
    let Ok(hours) = hours else {
        eprintln!("the argument is a number of simulated hours, 10 say");
        return ExitCode::from(2);
    };
    let seconds = 3600.0 * hours / SCENARIOS.len() as f64;
    println!(
        "{:<14} {:>6} {:>9} {:>8} {:>7} {:>8}",
        "scenario", "hours", "episodes", "arrived", "alarms", "remarks"
    );
    let mut alarms = 0;
    for scenario in SCENARIOS {
        let said = driving::drive(scenario, seconds, 1);
        alarms += said.alarms.len();
        println!(
            "{scenario:<14} {:>6.2} {:>9} {:>8} {:>7} {:>8}",
            said.driven / 3600.0,
            said.episodes,
            said.arrived,
            said.alarms.len(),
            said.remarks.len()
        );
        let remarks = said.remarks.iter().map(|what| ("remark", what));
        for (kind, (place, alarm)) in
            said.alarms.iter().map(|what| ("ALARM", what)).chain(remarks).take(20)
        {
            println!("  {kind} {}: {} ({place})", alarm.condition().name(), alarm.seen());
        }
    }
    if alarms == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
