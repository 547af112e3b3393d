//! What an evolution found, in tables.

use super::super::quantity::{UNKNOWN, millimetres, of_arrivals, percent};
use super::super::table::{Column, Table};
use umwelt_api::evolution::{Champion, Entry, Estimate, Ranking};
use umwelt_api::robot::ChannelPrior;

pub(super) const ABOUT: &str = "\
The champion stands beside what it has to beat, all on the same fresh seeds: the best of the first generation, the
weak default prior and a flat one.
  FITNESS               1 is that of a fixed model; weighted mean over the environments
  WITHIN                where the mean is with 95 % probability
  CHAMPION MINUS THIS   paired by seed; where its interval includes zero, no difference is shown
  TIME, DEVIATION       - where no robot arrived

Example:
  umwelt evolution show evolution-12";

/// The whole report.
pub(super) fn text(champion: &Champion) -> String {
    let notes: String = champion.notes.iter().map(|note| format!("note: {note}\n")).collect();
    format!(
        "on {} fresh trials in each environment, intervals hold with 95 %:\n{}\n{}{notes}\nthe champion's prior:\n{}",
        champion.trials,
        entries(champion),
        environments(champion),
        prior(champion)
    )
}

fn within(estimate: Estimate) -> String {
    format!("{:.3} .. {:.3}", estimate.low, estimate.high)
}

/// The verdict in a few words; the server's own is longer.
fn verdict(entry: &Entry) -> String {
    let words = match (entry.difference, entry.champion_is) {
        (None, _) => return String::new(),
        (_, Some(Ranking::NoDifference)) => "includes zero: no difference shown",
        (_, Some(Ranking::Better)) => "the champion is better",
        (_, Some(Ranking::Worse)) => "the champion is worse",
        // A server of an earlier version says it in words alone.
        (_, None) => return entry.verdict.clone(),
    };
    if entry.champion_worse_in.is_empty() {
        words.to_owned()
    } else {
        format!("{words}; worse in {}", entry.champion_worse_in.join(", "))
    }
}

fn entries(champion: &Champion) -> String {
    let mut table = Table::new([
        Column::Text("PRIOR"),
        Column::Number("FITNESS"),
        Column::Number("WITHIN"),
        Column::Number("CHAMPION MINUS THIS"),
        Column::Number("WITHIN"),
        Column::Text("VERDICT"),
    ]);
    for entry in &champion.entries {
        let unknown = || UNKNOWN.to_owned();
        table.row([
            entry.name.clone(),
            format!("{:.3}", entry.fitness.mean),
            within(entry.fitness),
            entry.difference.map_or_else(unknown, |it| format!("{:.3}", it.mean)),
            entry.difference.map_or_else(unknown, within),
            verdict(entry),
        ]);
    }
    table.to_string()
}

fn environments(champion: &Champion) -> String {
    let mut table = Table::new([
        Column::Text("ENVIRONMENT"),
        Column::Text("PRIOR"),
        Column::Number("FITNESS"),
        Column::Number("WITHIN"),
        Column::Number("TIME"),
        Column::Number("DEVIATION"),
        Column::Number("ARRIVED"),
    ]);
    let count = champion.entries.first().map_or(0, |entry| entry.environments.len());
    for index in 0..count {
        let results = champion
            .entries
            .iter()
            .filter_map(|entry| Some((entry.name.as_str(), entry.environments.get(index)?)));
        for (place, (prior, result)) in results.enumerate() {
            table.row([
                if place == 0 { result.environment.clone() } else { String::new() },
                prior.to_owned(),
                format!("{:.3}", result.fitness.mean),
                within(result.fitness),
                of_arrivals(result.arrived, format!("{:.1} s", result.time_s)),
                of_arrivals(result.arrived, millimetres(result.deviation_m)),
                percent(result.arrived),
            ]);
        }
    }
    table.to_string()
}

fn prior(champion: &Champion) -> String {
    let prior = &champion.prior;
    let (forward, lateral, turn, drift) = (prior.forward, prior.lateral, prior.turn, prior.drift);
    channels([("forward", forward), ("lateral", lateral), ("turn", turn), ("drift", drift)])
}

/// The numbers of a prior, channel by channel.
pub(in super::super) fn channels(channels: [(&str, ChannelPrior); 4]) -> String {
    let mut table = Table::new([
        Column::Text("CHANNEL"),
        Column::Number("MU"),
        Column::Number("K"),
        Column::Number("R"),
        Column::Number("S"),
        Column::Number("SD"),
    ]);
    for (name, ChannelPrior { mu, k, r, s }) in channels {
        // The variance has an expectation above two degrees of freedom only.
        let sd = (r > 2.0).then(|| (s / (r - 2.0)).sqrt());
        table.row([
            name.to_owned(),
            format!("{mu:.4}"),
            format!("{k:.3}"),
            format!("{r:.3}"),
            format!("{s:.3e}"),
            sd.map_or_else(|| UNKNOWN.to_owned(), |sd| format!("{sd:.4}")),
        ]);
    }
    table.to_string()
}
