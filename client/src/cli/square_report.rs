//! The report of a square, for people.

use super::quantity::{metres, millimetres};
use std::fmt::Write;
use umwelt_api::RobotId;
use umwelt_api::square::{Ending, Error, Report, Systematic};

/// The return errors, the figure, and what of wheels and track explains it.
pub(super) fn text(id: &RobotId, report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    match &report.systematic {
        Some(found) => {
            let (figure, side) = (millimetres(found.figure_m), metres(report.side_m));
            let _ = writeln!(text, "{id}: the figure is {figure}, on a square of {side}");
        }
        None => {
            let _ = writeln!(text, "{id}: no figure, {}", reason(report));
        }
    }
    if !report.returns.is_empty() {
        let _ = writeln!(text, "return errors");
    }
    for run in &report.returns {
        let (name, heading) = (run.direction.name(), run.heading_rad.to_degrees());
        let _ = writeln!(text, "  {name:<6}  {}, heading {heading:+.1} deg", place(run.error));
    }
    if let Some(found) = &report.systematic {
        if report.returns.len() > 2 {
            let _ = writeln!(text, "centres");
            for (name, centre) in [("left", found.left), ("right", found.right)] {
                let _ = writeln!(text, "  {name:<6}  {}", place(centre));
            }
        }
        let _ = writeln!(text, "explained by");
        for (name, value) in explained(report, found) {
            let _ = writeln!(text, "  {name:<6}  {value}");
        }
    }
    text
}

/// Why there is no figure, and what to do about it.
pub(super) fn reason(report: &Report) -> &'static str {
    match report.ending {
        Ending::Driven => {
            "what was driven is no square: check the robot (umwelt robot check), and describe it nearer to what it is"
        }
        Ending::TooFewPoses => {
            "too few poses were seen at rest: see the log of the agent; five a second or more are needed"
        }
        Ending::Interrupted => {
            "its runs were interrupted again and again: by a link that is away for long, or by what the robot itself allows"
        }
        Ending::TooFar => {
            "the robot was seen farther from its start than the square takes it: check it first (umwelt robot check)"
        }
        Ending::Other => "for a reason that this program does not know: update it",
    }
}

fn place(error: Error) -> String {
    format!("{:+.1} mm ahead, {:+.1} mm to the left", 1e3 * error.x_m, 1e3 * error.y_m)
}

fn explained(report: &Report, found: &Systematic) -> [(&'static str, String); 3] {
    let percent = |ratio: f64| format!("{:+.2} %", 100.0 * (ratio - 1.0));
    let alpha = found.alpha_rad.to_degrees();
    let turns = if alpha < 0.0 { "goes too far" } else { "falls short" };
    let (described_track, described_radius) =
        (report.described_track_width_m, report.described_wheel_radius_m);
    let track = format!(
        "{:.4} m, described {described_track:.4} m ({}): a quarter turn {turns} by {:.2} deg",
        found.track_width_m,
        percent(found.track_width_m / described_track),
        alpha.abs(),
    );
    let beta = found.beta_rad.to_degrees();
    let (side, larger) =
        if beta < 0.0 { ("right", 1.0 / found.wheel_ratio) } else { ("left", found.wheel_ratio) };
    let wheel = if beta < 0.0 { "left" } else { "right" };
    let wheels = format!(
        "the {wheel} one is larger by {:.2} %: a side bends to the {side} by {:.2} deg",
        100.0 * (larger - 1.0),
        beta.abs(),
    );
    let longer = if found.length_ratio < 1.0 { "shorter" } else { "longer" };
    let radius = format!(
        "sides are {:.2} % {longer} than commanded, as with wheels of {:.5} m, described {described_radius:.5} m; with these the track is {:.4} m",
        100.0 * (found.length_ratio - 1.0).abs(),
        found.wheel_radius_m,
        found.track_width_with_radius_m,
    );
    [("track", track), ("wheels", wheels), ("radius", radius)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn report(systematic: serde_json::Value, ending: &str) -> Report {
        let returned = |direction: &str| {
            json!({"direction": direction, "error": {"x_m": 0.1, "y_m": -0.02},
                "heading_rad": 0.1, "side_m": 1.0})
        };
        serde_json::from_value(json!({"ending": ending, "side_m": 1.0,
            "returns": [returned("left"), returned("right")], "systematic": systematic,
            "described_track_width_m": 0.1, "described_wheel_radius_m": 0.03, "span_s": 120.0}))
        .unwrap()
    }

    #[test]
    fn what_explains_the_figure_is_said_with_units() {
        let found = json!({"figure_m": 0.1392, "left": {"x_m": 0.1, "y_m": -0.02}, "right": {"x_m": 0.1, "y_m": -0.02},
            "alpha_rad": -0.0454, "beta_rad": 0.2, "track_width_m": 0.0971, "wheel_ratio": 1.02,
            "length_ratio": 1.03, "wheel_radius_m": 0.0309, "track_width_with_radius_m": 0.1});
        let text = text(&"a".parse().unwrap(), &report(found, "driven"));
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[0], "a: the figure is 139.2 mm, on a square of 1.000 m");
        assert_eq!(lines[2], "  left    +100.0 mm ahead, -20.0 mm to the left, heading +5.7 deg");
        assert!(lines[5].contains("0.0971 m, described 0.1000 m (-2.90 %)"), "{text}");
        assert!(lines[5].ends_with("a quarter turn goes too far by 2.60 deg"), "{text}");
        assert!(lines[6].contains("the right one is larger by 2.00 %"), "{text}");
        assert!(lines[7].contains("sides are 3.00 % longer than commanded"), "{text}");
        assert!(!text.contains("centres"));
    }

    #[test]
    fn without_a_figure_the_reason_is_said() {
        for (ending, said) in [
            ("too-few-poses", "log of the agent"),
            ("driven", "no square"),
            ("of-tomorrow", "update it"),
        ] {
            let text = text(&"a".parse().unwrap(), &report(json!(null), ending));
            assert!(text.contains("no figure") && text.contains(said), "{text}");
            assert!(!text.contains("explained"));
        }
    }
}
