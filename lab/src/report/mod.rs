//! The report of a comparison for people, as Markdown: what the thesis claims and what came of it, everybody's numbers,
//! and what they mean.
//!
//! Everything said here is computed from the numbers: the words for a difference whose interval includes zero are "no
//! difference is shown", whoever it is about.

mod setup;
mod why;

use crate::comparison::{BASELINE, CHAMPION, ComparisonSettings};
use std::fmt::{self, Write};
use umwelt_api::comparison::{
    Claim, DEFAULT_PRIOR, Entry, EnvironmentReport, Estimate, Figure, Quantities, Reductions,
    Report,
};

/// The report. `prior` is the name of the prior of `bayesian`; the figures are those of [`Figure`], beside it.
pub fn markdown(settings: &ComparisonSettings, prior: &str, report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut text, settings, prior, report);
    text
}

fn write(
    text: &mut String,
    settings: &ComparisonSettings,
    prior: &str,
    report: &Report,
) -> fmt::Result {
    let ComparisonSettings { scenario, trials, seed, .. } = settings;
    let evolved = if prior == DEFAULT_PRIOR {
        ", with more than one slot `thesis-20`, each evolved with as many"
    } else {
        ""
    };
    writeln!(text, "# Methods compared: scenario {scenario}\n")?;
    writeln!(
        text,
        "{trials} trials of each method in each environment, seed {seed}. All meet the same late packets and the same slip \
         (common random numbers). The number behind a method is its slots per horizon: 1 sends one command per reply, as \
         the thesis does. Intervals hold with 95 %: bootstrap over whole trials, differences paired by seed. `{CHAMPION}` \
         has the prior `{prior}`{evolved}. The same again: `umwelt-server compare --scenario {scenario} --trials {trials} --seed \
         {seed}`.\n"
    )?;
    claims(text, &report.claims)?;
    why::write(text, report)?;
    for environment in &report.environments {
        table(text, environment)?;
    }
    honesty(text)?;
    figures(text)?;
    setup::write(text, settings)
}

fn claims(text: &mut String, claims: &[Claim]) -> fmt::Result {
    writeln!(text, "## What the thesis claims, and what came of it\n")?;
    let Some(first) = claims.first() else {
        return writeln!(
            text,
            "The thesis claims for `{CHAMPION}` against `{BASELINE}`; not both drove, so nothing is said of it here.\n"
        );
    };
    writeln!(
        text,
        "For Bayesian identification with an evolved prior (`{CHAMPION}`) against samples alone (`{BASELINE}`) the thesis's \
         abstract claims {:.0} % less deviation and {:.0} % less time, from 15 runs. Reached here, `{CHAMPION}` minus \
         `{BASELINE}` as a part of `{BASELINE}`:\n",
        1e2 * first.promised_deviation,
        1e2 * first.promised_time
    )?;
    writeln!(
        text,
        "| environment | slots | deviation: mean | median | 90 % quantile | time: mean | median | 90 % quantile |\n\
         |---|--:|---|---|---|---|---|---|"
    )?;
    for claim in claims {
        let cells = |reductions: &Reductions| {
            [reductions.mean, reductions.median, reductions.p90].map(change).join(" | ")
        };
        writeln!(
            text,
            "| {} | {} | {} | {} |",
            claim.environment,
            claim.slots,
            cells(&claim.deviation_reduction),
            cells(&claim.time_reduction)
        )?;
    }
    writeln!(text)?;
    for Claim { environment, contender, against, verdict, .. } in claims {
        writeln!(text, "* **{environment}**, `{contender}` against `{against}`: {verdict}.")?;
    }
    writeln!(text)
}

/// A reduction as a change: `-12 % (-16 to -8)`, marked where it says nothing.
fn change(reduction: Option<Estimate>) -> String {
    let Some(estimate) = reduction else { return "-".to_owned() };
    let Estimate { mean, low, high } = estimate;
    let percent = |part: f64| {
        let text = format!("{:+.0}", -1e2 * part);
        if text == "-0" { "+0".to_owned() } else { text }
    };
    let nothing = if estimate.includes_zero() { ", includes zero" } else { "" };
    format!("{} % ({} to {}{nothing})", percent(mean), percent(high), percent(low))
}

fn table(text: &mut String, environment: &EnvironmentReport) -> fmt::Result {
    writeln!(text, "## Environment {}\n", environment.environment)?;
    writeln!(
        text,
        "Differences are to `{BASELINE}` with as many slots, of the means.\n\n\
         | method | arrived | time s: median | mean | p90 | deviation mm: median | mean | p90 | time minus {BASELINE} s | \
         deviation minus {BASELINE} mm | right environment after samples: median, p90 | 90 % intervals hold |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    )?;
    environment.entries.iter().try_for_each(|entry| row(text, entry))?;
    writeln!(text)
}

fn row(text: &mut String, entry: &Entry) -> fmt::Result {
    let Entry { contender, arrived, time_s, deviation_m, recognition, coverage, difference } =
        entry;
    // What no one reached is no result.
    let arrives = arrived.mean > 0.0;
    let numbers = |it: &Quantities, unit: f64, decimals: usize| {
        if !arrives {
            return "- | - | -".to_owned();
        }
        [it.median, it.mean, it.p90].map(|it| format!("{:.decimals$}", unit * it.mean)).join(" | ")
    };
    let minus = |of: Option<Estimate>, unit: f64, decimals: usize| {
        let Some(Estimate { mean, low, high }) = of.filter(|_| arrives) else {
            return "-".to_owned();
        };
        let signed = |value: f64| format!("{:+.decimals$}", unit * value);
        format!("{} ({} to {})", signed(mean), signed(low), signed(high))
    };
    let difference = difference.as_ref();
    let recognised = recognition.as_ref().map_or_else(
        || "-".to_owned(),
        |it| {
            let samples = |of: Option<u64>| of.map_or("never".to_owned(), |it| it.to_string());
            let (median, p90) = (samples(it.median_samples), samples(it.p90_samples));
            format!("{median}, {p90} ({:.0} % at the end)", 1e2 * it.share)
        },
    );
    let coverage = coverage.map_or("-".to_owned(), |it| format!("{:.1} %", 1e2 * it.mean));
    writeln!(
        text,
        "| `{contender}` | {:.1} % | {} | {} | {} | {} | {recognised} | {coverage} |",
        1e2 * arrived.mean,
        numbers(time_s, 1.0, 2),
        numbers(deviation_m, 1e3, 1),
        minus(difference.map(|it| it.time_s.mean), 1.0, 2),
        minus(difference.map(|it| it.deviation_m.mean), 1e3, 1),
    )
}

fn honesty(text: &mut String) -> fmt::Result {
    writeln!(
        text,
        "## How to read it\n\n\
         * *Time* runs from the end of the calibration to the arrival; a robot that did not arrive counts with the time \
         limit. *Deviation* is the largest distance of the true position from the current leg.\n\
         * *Right environment*: after each sample it is asked which of the scenario's environments would surprise the \
         method's belief least (Kullback-Leibler divergence from the errors that the environment shows, pooled over robots \
         of their own, to those believed). Counted are the samples after which it is the right one for good; never stands \
         for a trial in which it was not. Where floor or link change on the way there is no right one.\n\
         * *90 % intervals hold*: the share of samples within the interval that was predicted for each before it came, from \
         the tenth on. An evolved prior is made for driving and not for honesty: far more than 90 % is caution. \
         `{BASELINE}` takes the camera's noise for slip, and so counts it twice. `cargo run --release -p umwelt-lab --example \
         belief_calibration` asks it of robots whose floor is drawn from their prior, where 90 % must come out.\n"
    )
}

fn figures(text: &mut String) -> fmt::Result {
    writeln!(text, "## Figures\n")?;
    for figure in Figure::ALL {
        let about = match figure {
            Figure::Deviation => {
                "How often a trial deviates farther (thesis figures 8 and 9: without and with delay)"
            }
            Figure::Time => "How often a trial takes longer (thesis figures 10 and 11)",
            Figure::Pareto => "Time against deviation: lower and farther left is better",
        };
        let name = figure.name();
        writeln!(text, "![{about}]({name}.svg)\n\n*{about}.*\n")?;
    }
    writeln!(
        text,
        "Figures 6 and 7 of the thesis are those of the evolution that bred the prior: `umwelt-server evolve --preset \
         thesis --seed 1 --out DIR` draws them. Every trial stands in `trials.csv`.\n"
    )
}

#[cfg(test)]
mod tests;
