//! Where the claims hold, where not, and why, as far as the numbers say.

use crate::comparison::{BASELINE, CHAMPION};
use std::fmt::{self, Write};
use umwelt_api::comparison::{Claim, Entry, EnvironmentReport, Estimate, Reductions, Report};

pub(super) fn write(text: &mut String, report: &Report) -> fmt::Result {
    if report.claims.is_empty() {
        return Ok(());
    }
    writeln!(text, "### Where it holds, and where not\n")?;
    let deviation = |claim: &Claim| (claim.deviation_reduction, claim.promised_deviation);
    let time = |claim: &Claim| (claim.time_reduction, claim.promised_time);
    sorted(text, "Deviation", &report.claims, deviation)?;
    sorted(text, "Time", &report.claims, time)?;
    writeln!(text, "\n### Why\n")?;
    for environment in &report.environments {
        for claim in report.claims.iter().filter(|it| it.environment == environment.environment) {
            of_claim(text, environment, claim)?;
        }
        of_horizons(text, environment)?;
    }
    writeln!(text)
}

/// How much of a promise a mean keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kept {
    Whole,
    Part,
    Nothing,
    Opposite,
}

impl Kept {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Whole, "the whole claim or more is reached"),
        (Self::Part, "better than the baseline, by less than is claimed"),
        (Self::Nothing, "no difference is shown: the interval includes zero"),
        (Self::Opposite, "the opposite: worse than the baseline"),
    ];

    fn of(mean: Option<Estimate>, promised: f64) -> Self {
        match mean {
            None => Self::Nothing,
            Some(estimate) if estimate.includes_zero() => Self::Nothing,
            Some(Estimate { mean, .. }) if mean >= promised => Self::Whole,
            Some(Estimate { mean, .. }) if mean > 0.0 => Self::Part,
            Some(_) => Self::Opposite,
        }
    }
}

/// The claims sorted by how far they are kept.
fn sorted(
    text: &mut String,
    what: &str,
    claims: &[Claim],
    of: impl Fn(&Claim) -> (Reductions, f64),
) -> fmt::Result {
    for (kept, words) in Kept::ALL {
        let is_kept = |claim: &&Claim| {
            let (reductions, promised) = of(claim);
            Kept::of(reductions.mean, promised) == kept
        };
        let places: Vec<String> = claims.iter().filter(is_kept).map(place).collect();
        if !places.is_empty() {
            writeln!(text, "* {what} (means): {words} in {}.", places.join("; "))?;
        }
    }
    Ok(())
}

fn place(claim: &Claim) -> String {
    format!("{} with {}", claim.environment, of_slots(claim.slots))
}

fn of_slots(slots: u64) -> String {
    if slots == 1 { "1 slot".to_owned() } else { format!("{slots} slots") }
}

fn find<'a>(environment: &'a EnvironmentReport, label: &str) -> Option<&'a Entry> {
    environment.entries.iter().find(|it| it.contender == label)
}

/// Median time in s and median deviation in mm.
fn medians(entry: &Entry) -> (f64, f64) {
    (entry.time_s.median.mean, 1e3 * entry.deviation_m.median.mean)
}

fn of_claim(text: &mut String, environment: &EnvironmentReport, claim: &Claim) -> fmt::Result {
    let both = (find(environment, &claim.contender), find(environment, &claim.against));
    let (Some(champion), Some(baseline)) = both else { return Ok(()) };
    let ((time, deviation), (time_before, deviation_before)) =
        (medians(champion), medians(baseline));
    write!(
        text,
        "* **{}**: `{}` takes {time:.1} s and strays by {deviation:.1} mm, `{}` {time_before:.1} s and \
         {deviation_before:.1} mm (medians).",
        place(claim),
        claim.contender,
        claim.against,
    )?;
    let deviates = Kept::of(claim.deviation_reduction.mean, f64::INFINITY);
    let takes = Kept::of(claim.time_reduction.mean, f64::INFINITY);
    let words = match (deviates, takes) {
        (Kept::Part, Kept::Opposite) => {
            " It buys accuracy with time: the variance that it believes in keeps the robot slow, and a slow robot strays \
             less far before a late command is corrected."
        }
        (Kept::Part, Kept::Part) => " It is better in both.",
        (Kept::Nothing, Kept::Opposite) => {
            " It is slow and gains nothing: the caution of its prior is not needed here."
        }
        (Kept::Opposite, Kept::Opposite) => " It is worse in both.",
        (Kept::Nothing, Kept::Nothing) => {
            " Nothing tells them apart: the samples of the calibration say what a prior could."
        }
        (Kept::Opposite, Kept::Part) => " It buys time with accuracy.",
        _ => "",
    };
    text.push_str(words);
    if let Some(coverage) = champion.coverage
        && coverage.low > 0.92
    {
        write!(
            text,
            " Its 90 % intervals held {:.1} % of what came: it believes the errors to be larger than they are.",
            1e2 * coverage.mean
        )?;
    }
    if let Some(oracle) = find(environment, &format!("oracle/{}", claim.slots)) {
        let (time, deviation) = medians(oracle);
        write!(
            text,
            " `oracle`, which knows the floor, takes {time:.1} s and strays by {deviation:.1} mm: more than that \
             identifying the floor cannot bring to this controller."
        )?;
    }
    let slots = format!("/{}", claim.slots);
    let better: Vec<String> = environment
        .entries
        .iter()
        .filter(|it| it.contender.ends_with(&slots))
        .filter(|it| {
            let (its_time, its_deviation) = medians(it);
            its_time < time && its_deviation < deviation
        })
        .map(|it| format!("`{}`", it.contender))
        .collect();
    if better.is_empty() {
        writeln!(
            text,
            " Nobody with as many slots is both faster and nearer to the path by the medians."
        )
    } else {
        writeln!(
            text,
            " With as many slots both faster and nearer to the path, by the medians: {}.",
            better.join(", ")
        )
    }
}

/// What a longer horizon brings to those who sent one command per reply.
fn of_horizons(text: &mut String, environment: &EnvironmentReport) -> fmt::Result {
    for name in [BASELINE, CHAMPION] {
        let longest = environment
            .entries
            .iter()
            .filter_map(|it| Some((it, it.contender.strip_prefix(name)?.strip_prefix('/')?)))
            .filter_map(|(it, slots)| Some((it, slots.parse::<u64>().ok()?)))
            .max_by_key(|(_, slots)| *slots);
        let (Some((long, slots)), Some(one)) = (longest, find(environment, &format!("{name}/1")))
        else {
            continue;
        };
        if slots < 2 {
            continue;
        }
        let ((time, deviation), (time_of_one, deviation_of_one)) = (medians(long), medians(one));
        let (p90, p90_of_one) = (1e3 * long.deviation_m.p90.mean, 1e3 * one.deviation_m.p90.mean);
        write!(
            text,
            "* **{}**: with {} instead of one command per reply `{name}` goes from {time_of_one:.1} s and \
             {deviation_of_one:.1} mm (90 %: {p90_of_one:.1}) to {time:.1} s and {deviation:.1} mm (90 %: {p90:.1})",
            environment.environment,
            of_slots(slots),
        )?;
        if deviation < 0.5 * deviation_of_one && time < time_of_one {
            text.push_str(
                ": what the link does is made up for by commands that are there already, not by identification",
            );
        }
        text.push_str(".\n");
    }
    Ok(())
}
