//! The report of a comparison, in tables and in the words of the verdicts.

use super::super::quantity::{UNKNOWN, of_arrivals, or_unknown};
use super::super::table::{Column, Table};
use std::fmt::Write;
use umwelt_api::comparison::{Entry, EnvironmentReport, Finding, Recognition, Report};

pub(super) const ABOUT: &str = "\
Every method drove the same trials; a table for each environment.
  METHOD      its name and how many slots of 30 ms a reply has
  ARRIVED     share of the trials in which the robot arrived within the time limit
  TIME        from the end of the calibration to the arrival, in half and in 90 % of the trials; the limit if it did not
              - where it never arrived
  DEVIATION   the largest of the true position, in half and in 90 % of the trials
  COVERED     share of the samples within the 90 % interval that was predicted for each: 90 % is right
  RECOGNISED  samples after which it believed for good to be where it was, in half of the trials; never: in fewer
The last lines say how much less (or more) `bayesian` deviates than `statistic` and how much sooner (or later) it
arrives, on the mean and with 95 % intervals, beside what the thesis claims. --json has every interval.

Example:
  umwelt comparison show comparison-12";

/// The whole report.
pub(super) fn text(report: &Report) -> String {
    let mut text = String::new();
    for environment in &report.environments {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}:\n{}", environment.environment, entries(environment));
    }
    text + &claims(report)
}

fn entries(environment: &EnvironmentReport) -> String {
    let mut table = Table::new([
        Column::Text("METHOD"),
        Column::Number("ARRIVED"),
        Column::Number("TIME 50 %"),
        Column::Number("90 %"),
        Column::Number("DEVIATION 50 %"),
        Column::Number("90 %"),
        Column::Number("COVERED"),
        Column::Number("RECOGNISED"),
    ]);
    for entry in &environment.entries {
        let Entry { contender, arrived, time_s, deviation_m, recognition, coverage, .. } = entry;
        let percent = |share: f64| format!("{:.1} %", 1e2 * share);
        let millimetres = |metres: f64| format!("{:.1} mm", 1e3 * metres);
        let known = |text| of_arrivals(arrived.mean, text);
        table.row([
            contender.clone(),
            percent(arrived.mean),
            known(format!("{:.1} s", time_s.median.mean)),
            known(format!("{:.1} s", time_s.p90.mean)),
            known(millimetres(deviation_m.median.mean)),
            known(millimetres(deviation_m.p90.mean)),
            or_unknown(*coverage, |it| percent(it.mean)),
            recognised(*recognition),
        ]);
    }
    table.to_string()
}

/// After how many samples a method knew where it was.
fn recognised(recognition: Option<Recognition>) -> String {
    match recognition {
        None => UNKNOWN.to_owned(),
        Some(Recognition { median_samples: Some(samples), .. }) => samples.to_string(),
        Some(_) => "never".to_owned(),
    }
}

fn claims(report: &Report) -> String {
    if report.claims.is_empty() {
        return "what the thesis claims was not tested: that takes bayesian and statistic with as many slots\n"
            .to_owned();
    }
    let mut text = String::new();
    for claim in &report.claims {
        let _ =
            writeln!(text, "{} against {}, {}:", claim.contender, claim.against, claim.environment);
        for Finding { words, .. } in &claim.findings {
            let _ = writeln!(text, "  {words}");
        }
        if claim.findings.is_empty() {
            // A server of an earlier version says it in one text.
            let _ = writeln!(text, "  {}", claim.verdict);
        }
    }
    text
}
