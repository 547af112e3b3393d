//! What a square finds, held against what the simulated robot is.

use super::robot::{Robot, floor};
use crate::exchange::PoseNoise;
use crate::kinematics::Drive;
use crate::plant::Slip;
use crate::square::{Ending, Report, Systematic};
use crate::task::Square;
use std::sync::Arc;

fn driven(robot: Robot, what: &str) -> (Arc<Report>, Systematic) {
    let run = robot.run();
    let report =
        run.report.unwrap_or_else(|| panic!("{what}: no report, {:?}", run.controller.progress()));
    assert_eq!(report.ending, Ending::Driven, "{what}: {report:?}");
    let found = report.systematic.unwrap_or_else(|| panic!("{what}: {report:?}"));
    (report, found)
}

/// Without slip and noise nothing is left but the planner: what is commanded is the square.
#[test]
fn a_robot_as_described_returns_to_where_it_began() {
    for (lag, dead_time) in [(0.0, 0.0), (0.15, 0.1)] {
        let drive = Drive { lag, dead_time, ..Drive::default() };
        let mut robot = Robot::new(drive, Slip::NONE);
        (robot.plant.noise, robot.settings.noise) = (PoseNoise::NONE, PoseNoise::NONE);
        let (report, found) = driven(robot, "as described");
        assert_eq!(report.returns.len(), 2);
        assert!(found.figure < 1e-3, "{report:?}");
        assert!((found.length_ratio - 1.0).abs() < 1e-3, "{report:?}");
    }
}

#[test]
fn a_track_off_by_3_percent_is_found_to_a_tenth_of_that() {
    for seed in 0..4 {
        for track in [0.97, 1.0, 1.03] {
            let robot =
                Robot { seed, ..Robot::new(Drive::default(), floor(0.0, 1.0 / track - 1.0, 0.0)) };
            let (_, found) = driven(robot, &format!("track {track}, seed {seed}"));
            assert!((found.track_width / 0.1 - track).abs() < 0.003, "{found:?}");
            assert!((found.wheel_ratio - 1.0).abs() < 0.002, "{found:?}");
        }
    }
}

#[test]
fn wheels_unequal_by_2_percent_are_found_to_a_tenth_of_that() {
    for seed in 0..4 {
        for ratio in [0.98, 1.02_f64] {
            // The robot turns by (v_r - v_l)/b where it drives (v_r + v_l)/2.
            let drift = 2.0 * (ratio - 1.0) / (ratio + 1.0) / 0.1;
            let robot = Robot { seed, ..Robot::new(Drive::default(), floor(0.0, 0.0, drift)) };
            let (_, found) = driven(robot, &format!("wheels {ratio}, seed {seed}"));
            assert!((found.wheel_ratio - ratio).abs() < 0.002, "{found:?}");
            assert!((found.track_width / 0.1 - 1.0).abs() < 0.003, "{found:?}");
            assert!((found.length_ratio - 1.0).abs() < 0.003, "{found:?}");
        }
    }
}

/// Larger wheels drive farther and turn farther: the track that explains the turns is smaller, the one that goes with the
/// larger radius is the real one.
#[test]
fn wheels_of_another_radius_are_told_from_another_track() {
    let robot = Robot::new(Drive::default(), floor(0.03, 0.03, 0.0));
    let (_, found) = driven(robot, "radius 1.03");
    assert!((found.wheel_radius / 0.03 - 1.03).abs() < 0.003, "{found:?}");
    assert!((found.track_width / 0.1 - 1.0 / 1.03).abs() < 0.003, "{found:?}");
    assert!((found.track_width_with_radius / 0.1 - 1.0).abs() < 0.005, "{found:?}");
}

#[test]
fn runs_are_averaged() {
    let square = Square { runs: 3, side: Some(0.5), ..Square::default() };
    let robot = Robot { square, ..Robot::new(Drive::default(), floor(0.0, -0.03, 0.1)) };
    let (report, found) = driven(robot, "three runs");
    assert_eq!(report.returns.iter().filter(|it| it.is_left).count(), 3);
    assert_eq!(report.returns.len(), 6);
    let mean =
        report.returns.iter().filter(|it| it.is_left).map(|it| it.error.x).sum::<f64>() / 3.0;
    assert!((found.left.x - mean).abs() < 1e-12);
}

#[test]
fn robots_and_cameras_of_all_kinds() {
    let coin = Drive {
        wheel_radius: 0.005,
        track_width: 0.02,
        max_wheel_speed: 20.0,
        max_linear: 0.08,
        min_linear: 0.005,
        max_angular: 4.0,
        min_angular: 0.3,
        max_linear_acceleration: 0.5,
        max_angular_acceleration: 20.0,
        ..Drive::default()
    };
    let truck = Drive {
        wheel_radius: 0.1,
        track_width: 1.3,
        max_wheel_speed: 25.0,
        max_linear: 2.0,
        min_linear: 0.05,
        max_angular: 0.7,
        max_angular_acceleration: 1.0,
        ..Drive::default()
    };
    let late = Drive { lag: 0.2, dead_time: 0.15, ..Drive::default() };
    for (name, drive) in [("coin", coin), ("truck", truck), ("late", late)] {
        for (rate, delay) in [(10.0, 0.02), (100.0, 0.06)] {
            let robot = Robot::new(drive, floor(0.0, -0.03, 0.0));
            let robot = Robot { rate, delays: (delay, delay), ..robot };
            let (_, found) = driven(robot, &format!("{name} at {rate} Hz"));
            let track = found.track_width / drive.track_width;
            assert!((track - 1.0 / 0.97).abs() < 0.006, "{name}: {found:?}");
        }
    }
}
