//! What a recording says of a drive, for people and as JSON.

use super::super::quantity::{self, UNKNOWN};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use umwelt_core::drive::{self, Comparison, ErrorsAhead, Identified, LONGEST, Recording};

/// An interval of the delay wider than this in s is wide: control wants to know it to some 10 ms.
const WIDE: f64 = 0.02;

/// A delay that ends nearer than this in s to what is looked for at all is at that end.
const AT_END: f64 = 0.01;

/// Dead times below this in s are none: every motor driver takes as long.
const NO_DEAD_TIME: f64 = 0.001;

/// Times with their uncertainty in s. The interval holds with 90 %.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Seconds {
    mean_s: f64,
    sd_s: f64,
    low_s: f64,
    high_s: f64,
}

/// A ratio with its uncertainty, likewise.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Ratio {
    mean: f64,
    sd: f64,
    low: f64,
    high: f64,
}

/// Errors of predicted poses.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Errors {
    heading_p50_rad: f64,
    heading_p90_rad: f64,
    position_p50_m: f64,
    position_p90_m: f64,
}

/// Poses of the second half, predicted by what the first half says.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Predicted {
    ahead_s: f64,
    poses: usize,
    identified: Errors,
    lag_0: Errors,
}

/// What was read and what it says.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Report {
    poses: usize,
    poses_left_out: usize,
    poses_per_s: f64,
    commands: usize,
    commands_per_s: f64,
    span_s: f64,
    delay_s: Seconds,
    lag_s: Seconds,
    dead_time_s: Seconds,
    turn_ratio: Ratio,
    forward_ratio: Ratio,
    stretches: u64,
    not_understood: u64,
    predicted: Option<Predicted>,
    /// About the delay by least squares, below 0 where clocks differ; where the numbers above were looked for.
    rough_delay_s: Option<f64>,
    notes: Vec<String>,
}

impl From<drive::Quantity> for Seconds {
    fn from(it: drive::Quantity) -> Self {
        Self { mean_s: it.mean, sd_s: it.sd, low_s: it.interval.0, high_s: it.interval.1 }
    }
}

impl From<drive::Quantity> for Ratio {
    fn from(it: drive::Quantity) -> Self {
        Self { mean: it.mean, sd: it.sd, low: it.interval.0, high: it.interval.1 }
    }
}

impl From<ErrorsAhead> for Errors {
    fn from(it: ErrorsAhead) -> Self {
        Self {
            heading_p50_rad: it.heading.p50,
            heading_p90_rad: it.heading.p90,
            position_p50_m: it.position.p50,
            position_p90_m: it.position.p90,
        }
    }
}

impl From<Comparison> for Predicted {
    fn from(it: Comparison) -> Self {
        Self {
            ahead_s: it.identified.ahead,
            poses: it.identified.poses,
            identified: it.identified.into(),
            lag_0: it.at_once.into(),
        }
    }
}

impl Report {
    pub(super) fn new(
        recording: &Recording,
        poses_left_out: usize,
        identified: &Identified,
    ) -> Self {
        let Recording { poses, commands } = recording;
        let estimate = identified.belief.estimate();
        let interval = recording.interval().unwrap_or(f64::INFINITY);
        let span = |first: f64, last: f64| (last - first).max(0.0);
        let seen = poses.first().zip(poses.last());
        let seen = seen.map_or(0.0, |(it, last)| span(it.taken.seconds(), last.taken.seconds()));
        let said = commands.first().zip(commands.last());
        let said = said.map_or(0.0, |(it, last)| span(it.0.seconds(), last.0.seconds()));
        let (turn_ratio, forward_ratio) = identified.belief.ratios();
        let mut report = Self {
            poses: poses.len(),
            poses_left_out,
            poses_per_s: 1.0 / interval,
            commands: commands.len(),
            commands_per_s: if said > 0.0 { (commands.len() - 1) as f64 / said } else { 0.0 },
            span_s: seen,
            delay_s: estimate.sum.into(),
            lag_s: estimate.lag.into(),
            dead_time_s: estimate.dead_time.into(),
            turn_ratio: turn_ratio.into(),
            forward_ratio: forward_ratio.into(),
            stretches: estimate.stretches,
            not_understood: estimate.not_understood,
            predicted: identified.comparison.map(Predicted::from),
            rough_delay_s: identified.rough,
            notes: Vec::new(),
        };
        report.notes = report.notes();
        report
    }

    /// What to know before one believes the numbers.
    fn notes(&self) -> Vec<String> {
        let (low, high) = (self.delay_s.low_s, self.delay_s.high_s);
        let mut notes = Vec::new();
        let rough = self.rough_delay_s.unwrap_or(low);
        if self.not_understood > self.stretches {
            notes.push(
                "most of the motion is not understood: are the clocks the same, the axes right, the wheels not swapped? \
                 `umwelt robot check` names what is wrong with a robot",
            );
        }
        if self.stretches == 0 {
            notes.push("nothing was learned: the numbers are what is presumed of any drive");
        } else if rough < AT_END {
            notes.push(
                "the robot moves with its commands or before: the clock of the poses seems to be behind; add to it, as \
                 --shift-poses 0.3, and take that off the dead time again",
            );
        } else if rough > LONGEST - AT_END {
            notes.push(
                "the robot moves later than is looked for: the clock of the poses seems to be ahead; take off it, as \
                 --shift-poses -0.3, and add that to the dead time again",
            );
        } else if high - low > WIDE {
            notes.push(
                "the recording says little of the delay: it has few starts and stops, or poses are rare or noisy; drive \
                 some ten starts and stops, best turns in place",
            );
        } else if self.dead_time_s.high_s < NO_DEAD_TIME {
            notes.push(
                "there is no dead time at all: where the drive has some, the clock of the poses is behind; see whether \
                 --shift-poses 0.3 predicts better",
            );
        }
        notes.into_iter().map(str::to_owned).collect()
    }
}

/// The report for people.
pub(super) fn text(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let Report { poses, commands, span_s, .. } = report;
    let _ = writeln!(
        text,
        "read\n  poses      {poses}, {:.0} per second for {}\n  commands   {commands}, {:.0} per second",
        report.poses_per_s,
        quantity::span(*span_s),
        report.commands_per_s
    );
    if report.poses_left_out > 0 {
        let _ =
            writeln!(text, "  left out   {} poses that jump there and back", report.poses_left_out);
    }
    let _ = writeln!(text, "identified, with 90 % within");
    for (name, it, what) in [
        ("delay", &report.delay_s, "  dead time and lag together"),
        ("lag", &report.lag_s, ""),
        ("dead time", &report.dead_time_s, ""),
    ] {
        let (low, high) = (1e3 * it.low_s, 1e3 * it.high_s);
        let mean = quantity::milliseconds(it.mean_s);
        let _ = writeln!(text, "  {name:<9}  {mean:>7}  {low:5.0} .. {high:.0} ms{what}");
    }
    for (name, it) in [("drives", &report.forward_ratio), ("turns", &report.turn_ratio)] {
        let [mean, low, high] = [it.mean, it.low, it.high].map(|it| 100.0 * it);
        let of = "of what is commanded";
        let _ = writeln!(text, "  {name:<9}  {mean:5.1} %  {low:5.1} .. {high:.1} %  {of}");
    }
    let (stretches, not_understood) = (report.stretches, report.not_understood);
    let _ = writeln!(text, "  stretches  {stretches} taken in, {not_understood} not understood");
    let Some(predicted) = &report.predicted else {
        let _ = writeln!(text, "predicted  {UNKNOWN}: too little motion to try it out");
        return with_notes(text, report);
    };
    let Predicted { ahead_s, poses, identified, lag_0 } = predicted;
    let _ = writeln!(
        text,
        "predicted {ahead_s:.2} s ahead, second half by what the first half says ({poses} poses)"
    );
    for (name, ours, theirs, unit) in [
        ("heading", identified.heading_p90_rad, lag_0.heading_p90_rad, "rad"),
        ("position", identified.position_p90_m, lag_0.position_p90_m, "m"),
    ] {
        let change = 100.0 * (ours / theirs - 1.0);
        let _ = writeln!(
            text,
            "  {name:<9}  p90 {ours:.4} {unit} with the drive as identified, {theirs:.4} {unit} with lag 0 ({change:+.0} %)"
        );
    }
    with_notes(text, report)
}

fn with_notes(mut text: String, report: &Report) -> String {
    for note in &report.notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}
