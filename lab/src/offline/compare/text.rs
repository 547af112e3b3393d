//! The outcome for people.

use super::Outcome;
use std::fmt::Write;
use umwelt_api::comparison::{Claim, Entry, EnvironmentReport, Estimate};

/// The outcome in some lines.
pub(super) fn of(outcome: &Outcome) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(outcome, &mut text);
    text
}

fn write(outcome: &Outcome, text: &mut String) -> std::fmt::Result {
    let Outcome { spec, report, .. } = outcome;
    writeln!(
        text,
        "scenario {}, seed {}, {} trials each; {} episodes in {:.1} s on {} threads",
        spec.scenario,
        spec.seed,
        report.trials,
        outcome.episodes,
        outcome.wall_time_s,
        outcome.threads
    )?;
    for EnvironmentReport { environment, entries } in &report.environments {
        writeln!(text, "\n{environment}: mean (95 %), 90 % quantile")?;
        writeln!(
            text,
            "  {:<21} {:>9} {:>25} {:>8} {:>22} {:>7}",
            "", "arrived %", "time s", "90 %", "deviation mm", "90 %"
        )?;
        for Entry { contender, arrived, time_s, deviation_m, .. } in entries {
            // Without an arrival there is no result.
            let known = |text: String| if arrived.mean > 0.0 { text } else { "-".to_owned() };
            writeln!(
                text,
                "  {contender:<21} {:>9.1} {:>25} {:>8} {:>22} {:>7}",
                1e2 * arrived.mean,
                known(interval(time_s.mean, 1.0, 2)),
                known(format!("{:.2}", time_s.p90.mean)),
                known(interval(deviation_m.mean, 1e3, 1)),
                known(format!("{:.1}", 1e3 * deviation_m.p90.mean))
            )?;
        }
    }
    if !report.claims.is_empty() {
        writeln!(text, "\nwhat the thesis claims")?;
    }
    for Claim { environment, contender, against, verdict, .. } in &report.claims {
        writeln!(text, "  {contender} against {against} in {environment}: {verdict}")?;
    }
    Ok(())
}

/// A mean with its interval.
fn interval(Estimate { mean, low, high }: Estimate, unit: f64, decimals: usize) -> String {
    let [mean, low, high] = [mean, low, high].map(|it| format!("{:.decimals$}", unit * it));
    format!("{mean} ({low} to {high})")
}
