//! What the log says of a robot: one line for every change of its own, with the field `robot`.
//!
//! Changes that people ask for are said where they ask (`http::routes`), with the field `peer`.

use umwelt_api::RobotId;
use umwelt_api::event::Kind;
use umwelt_api::robot::State;
use umwelt_core::check::Report;
use umwelt_core::square;

/// Says what happened to a robot by itself.
pub(super) fn change(robot: &RobotId, kind: &Kind) {
    match kind {
        Kind::Link { state: State::Connected } => tracing::info!(%robot, "robot connected"),
        Kind::Link { state: State::Lost } => tracing::info!(%robot, "robot lost"),
        Kind::Arrived { elapsed_s, max_deviation_m } => {
            tracing::info!(%robot, elapsed_s, max_deviation_m, "robot arrived");
        }
        Kind::Held => tracing::info!(%robot, "robot holds by itself"),
        Kind::Released => tracing::info!(%robot, "robot no longer holds by itself"),
        Kind::Watch(found) if found.rests => {
            let (state, seen, remedy) = (found.state.name(), &found.seen, &found.remedy);
            tracing::warn!(%robot, state, seen, remedy, "watch stopped robot");
        }
        Kind::Watch(found) => {
            let (state, seen, remedy) = (found.state.name(), &found.seen, &found.remedy);
            tracing::warn!(%robot, state, seen, remedy, "watch found something");
        }
        Kind::WatchOver { state } => {
            tracing::info!(%robot, state = state.name(), "watch released robot");
        }
        _ => {}
    }
}

/// Says what a check of the robot came to.
pub(super) fn checked(robot: &RobotId, report: &Report) {
    if report.is_well() {
        tracing::info!(%robot, "robot checked: all is well");
    }
    for finding in &report.findings {
        let (fault, seen, remedy) = (finding.fault().name(), finding.seen(), finding.remedy());
        tracing::warn!(%robot, fault, seen, remedy, "robot checked: something is wrong");
    }
}

/// Says what a square of the robot came to.
pub(super) fn calibrated(robot: &RobotId, report: &square::Report) {
    match &report.systematic {
        Some(found) => {
            let (figure_m, track_width_m) = (found.figure, found.track_width);
            let (wheel_ratio, length_ratio) = (found.wheel_ratio, found.length_ratio);
            tracing::info!(%robot, figure_m, track_width_m, wheel_ratio, length_ratio, "robot drove its square");
        }
        None => {
            let (ending, runs) = (report.ending, report.returns.len());
            tracing::warn!(%robot, ?ending, runs, "the robot's square came to no figure");
        }
    }
}

/// Says that an agent took over a robot that another one drove.
pub(super) fn taken_over(robot: &RobotId, epoch: u64) {
    tracing::info!(%robot, epoch, "robot taken over");
}
