//! The report of a check, for people.

use super::quantity::{self, UNKNOWN};
use std::fmt::Write;
use umwelt_api::RobotId;
use umwelt_api::robot_check::Report;

/// What is wrong, each with its remedy, and the numbers.
pub(super) fn text(id: &RobotId, report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    if report.is_well() {
        let _ = writeln!(text, "{id}: all is well");
    }
    for finding in &report.findings {
        let _ = writeln!(text, "{id}: {}", finding.name.name());
        let _ = writeln!(text, "  seen    {}", finding.seen);
        let _ = writeln!(text, "  remedy  {}", finding.remedy);
    }
    let known = |value: Option<f64>, text: &dyn Fn(f64) -> String| {
        value.map_or_else(|| UNKNOWN.to_owned(), text)
    };
    let _ = writeln!(text, "numbers");
    let noise = known(report.noise_position_m, &quantity::millimetres);
    let heading = known(report.noise_heading_rad, &|rad| format!("{rad:.4} rad"));
    let delay = known(report.delay_s, &|s| format!("{s:.2} s"));
    let described = report.described_delay_s;
    let percent = |ratio: f64| format!("{:.0} % of what is commanded", 100.0 * ratio);
    let lines = [
        ("poses", format!("{:.1} per second", report.poses_per_second)),
        ("noise", format!("{noise} and {heading} at rest")),
        ("delay", format!("{delay} from command to motion, described {described:.2} s")),
        ("drives", known(report.forward_ratio, &percent)),
        ("turns", known(report.turn_ratio, &percent)),
    ];
    for (name, value) in lines {
        let _ = writeln!(text, "  {name:<6}  {value}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_finding_has_its_remedy_and_what_is_not_known_is_said_so() {
        let report = json!({"findings": [{"name": "no-poses", "seen": "no pose came", "remedy": "see the log"}],
            "described_delay_s": 0.1, "poses_per_second": 0.0, "span_s": 5.0});
        let text = text(&"a".parse().unwrap(), &serde_json::from_value(report).unwrap());
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[..3], ["a: no-poses", "  seen    no pose came", "  remedy  see the log"]);
        assert_eq!(lines[6], "  delay   - from command to motion, described 0.10 s");
        assert!(!text.contains("all is well"));
    }
}
