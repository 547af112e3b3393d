//! Quantities in words, each with its unit.

use umwelt_api::robot::{Pose, Robot, State};
use umwelt_api::task::{Progress, Stage};
use umwelt_api::watch::Watch;

/// Where nothing is known.
pub(super) const UNKNOWN: &str = "-";

pub(super) fn or_unknown<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| UNKNOWN.to_owned(), text)
}

/// A result of the robots that arrived; without any there is none.
pub(super) fn of_arrivals(arrived: f64, text: String) -> String {
    if arrived > 0.0 { text } else { UNKNOWN.to_owned() }
}

pub(super) fn metres(value: f64) -> String {
    format!("{value:.3} m")
}

pub(super) fn radians(value: f64) -> String {
    format!("{value:.3} rad")
}

pub(super) fn millimetres(metres: f64) -> String {
    format!("{:.1} mm", 1e3 * metres)
}

pub(super) fn milliseconds(seconds: f64) -> String {
    format!("{:.0} ms", 1e3 * seconds)
}

/// A probability; small ones matter too.
pub(super) fn percent(ratio: f64) -> String {
    if ratio < 0.01 { format!("{:.3} %", 1e2 * ratio) } else { format!("{:.1} %", 1e2 * ratio) }
}

/// A time span, as exact as people want to know.
pub(super) fn span(seconds: f64) -> String {
    match seconds {
        s if s < 60.0 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{:.0} min", (s / 60.0).floor()),
        s if s < 172_800.0 => format!("{:.0} h", (s / 3600.0).floor()),
        s => format!("{:.0} days", (s / 86_400.0).floor()),
    }
}

pub(super) fn pose(pose: &Pose) -> String {
    let Pose { x_m, y_m, heading_rad, .. } = pose;
    format!("x {}, y {}, heading {}", metres(*x_m), metres(*y_m), radians(*heading_rad))
}

/// Whether a robot is heard from, as `lost, last seen 12.0 s ago, stopped`.
pub(super) fn presence(robot: &Robot) -> String {
    let mut text = state(robot.state).to_owned();
    if robot.state != State::Connected
        && let Some(seconds) = robot.last_seen_s_ago
    {
        text = format!("{text}, last seen {} ago", span(seconds));
    }
    if robot.stopped {
        text.push_str(", stopped");
    }
    if robot.held {
        text.push_str(", held by the robot itself");
    }
    text
}

/// What the watch finds, and what to do about it, as `stuck, at rest: commanded ...; free the robot`.
pub(super) fn watch(watch: &Watch) -> String {
    let rests = if watch.rests { ", at rest" } else { "" };
    format!("{}{rests}: {}; {}", watch.state.name(), watch.seen, watch.remedy)
}

pub(super) fn state(state: State) -> &'static str {
    match state {
        State::Never => "never seen",
        State::Connected => "connected",
        State::Lost => "lost",
        State::Failed => "failed",
    }
}

pub(super) fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Idle => "idle",
        Stage::Calibrating => "calibrating",
        Stage::Turning => "turning",
        Stage::Driving => "driving",
        Stage::Stopping => "stopping",
        Stage::Arrived => "arrived",
    }
}

/// What a robot does about its task, as `driving 1/2`; nothing without one.
pub(super) fn short_progress(progress: &Progress) -> String {
    match progress.stage {
        Stage::Calibrating if progress.legs == 0 => "checking".to_owned(),
        Stage::Arrived if progress.legs == 0 => "checked".to_owned(),
        Stage::Idle | Stage::Calibrating => stage(progress.stage).to_owned(),
        Stage::Turning | Stage::Driving | Stage::Stopping | Stage::Arrived => {
            let leg = (progress.leg + 1).min(progress.legs);
            format!("{} {leg}/{}", stage(progress.stage), progress.legs)
        }
    }
}

/// The same in full.
pub(super) fn progress(progress: &Progress) -> String {
    let Progress { leg, legs, deviation_m, max_deviation_m, elapsed_s, .. } = *progress;
    let doing = match progress.stage {
        Stage::Idle => return "no task".to_owned(),
        Stage::Calibrating | Stage::Arrived if legs == 0 => return short_progress(progress),
        Stage::Calibrating => return "calibrating".to_owned(),
        Stage::Turning => format!("turning to waypoint {} of {legs}", leg + 1),
        Stage::Driving => format!("driving to waypoint {} of {legs}", leg + 1),
        Stage::Stopping => format!("stopping at waypoint {} of {legs}", leg + 1),
        Stage::Arrived => {
            let deviation = millimetres(max_deviation_m);
            return format!("arrived after {elapsed_s:.1} s, largest deviation {deviation}");
        }
    };
    let (deviation, largest) = (millimetres(deviation_m), millimetres(max_deviation_m));
    let limit = progress
        .limited_by
        .map_or_else(String::new, |limit| format!(", speed limited by {}", limit.name()));
    format!("{doing}, {elapsed_s:.1} s, deviation {deviation} (largest {largest}){limit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_as_exact_as_they_are_short() {
        let texts = [0.04, 12.34, 61.0, 7199.0, 86_400.0, 864_000.0].map(span);
        assert_eq!(texts, ["0.0 s", "12.3 s", "1 min", "1 h", "24 h", "10 days"]);
    }

    #[test]
    fn progress_counts_waypoints_from_one() {
        let driving = Progress {
            stage: Stage::Driving,
            leg: 0,
            legs: 2,
            deviation_m: 0.001,
            max_deviation_m: 0.0041,
            elapsed_s: 12.0,
            limited_by: None,
            watch: None,
        };
        let slow = Progress { limited_by: Some(umwelt_api::watch::Limit::Variance), ..driving };
        assert!(progress(&slow).ends_with(", speed limited by variance"));
        assert_eq!(short_progress(&driving), "driving 1/2");
        assert_eq!(
            progress(&driving),
            "driving to waypoint 1 of 2, 12.0 s, deviation 1.0 mm (largest 4.1 mm)"
        );
        let arrived = Progress { stage: Stage::Arrived, leg: 2, ..driving };
        assert_eq!(short_progress(&arrived), "arrived 2/2");
        assert_eq!(progress(&arrived), "arrived after 12.0 s, largest deviation 4.1 mm");
    }
}
