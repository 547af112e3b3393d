//! The outcome for people.

use super::Outcome;
use std::fmt::Write;
use umwelt_api::evolution::{EnvironmentResult, Estimate};
use umwelt_api::robot::ChannelPrior;

/// The outcome in some lines.
pub(super) fn of(outcome: &Outcome) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(outcome, &mut text);
    text
}

fn write(outcome: &Outcome, text: &mut String) -> std::fmt::Result {
    let Outcome { spec, champion, fitness, .. } = outcome;
    let (preset, seed, optimizer) = (outcome.preset.name(), outcome.seed, spec.optimizer.name());
    let environments =
        spec.environments.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    writeln!(text, "preset {preset}, seed {seed}, {optimizer}: {environments}")?;
    writeln!(
        text,
        "{} generations of {} individuals, {} trials each; {} episodes in {:.1} s on {} threads\n",
        spec.generations,
        spec.population,
        spec.trials,
        outcome.episodes,
        outcome.wall_time_s,
        outcome.threads
    )?;
    writeln!(text, "champion: fitness {}, 1 being a fixed model", interval(*fitness))?;
    writeln!(text, "  {:<8} {:>10} {:>10} {:>10} {:>10}", "", "mu", "k", "r", "s")?;
    let prior = &champion.prior;
    for (name, ChannelPrior { mu, k, r, s }) in [
        ("forward", prior.forward),
        ("lateral", prior.lateral),
        ("turn", prior.turn),
        ("drift", prior.drift),
    ] {
        writeln!(text, "  {name:<8} {mu:>10.4} {k:>10.4} {r:>10.4} {s:>10.6}")?;
    }
    writeln!(text, "\non {} fresh trials in each environment", champion.trials)?;
    for entry in &champion.entries {
        writeln!(text, "  {:<17} fitness {}", entry.name, interval(entry.fitness))?;
        for EnvironmentResult { environment, fitness, time_s, deviation_m, arrived } in
            &entry.environments
        {
            let driven = if *arrived > 0.0 {
                format!("time {time_s:.2} s, deviation {:.1} mm", 1e3 * deviation_m)
            } else {
                "time -, deviation -".to_owned()
            };
            writeln!(
                text,
                "    {:<15} fitness {}, {driven}, arrived {:.1} %",
                environment.as_str(),
                interval(*fitness),
                100.0 * arrived
            )?;
        }
    }
    for note in &champion.notes {
        writeln!(text, "note: {note}")?;
    }
    writeln!(text, "\nthe champion's fitness minus theirs, on the same seeds")?;
    for entry in outcome.others() {
        writeln!(text, "  {:<17} {}", entry.name, entry.verdict)?;
    }
    Ok(())
}

/// A mean with its interval.
fn interval(Estimate { mean, low, high }: Estimate) -> String {
    format!("{mean:.3} ({low:.3} to {high:.3})")
}
