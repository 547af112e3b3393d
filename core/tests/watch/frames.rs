//! Frames and wheels that are not as they should be.

use super::harness::{Run, Show, Wheels, World, amr, burger, mini, rover};
use std::f64::consts::{FRAC_PI_2, PI};
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::kinematics::Drive;
use umwelt_core::watch::{Alarm, Condition, Fit};

/// What a camera makes of a pose.
type Mirror = fn(Pose) -> Pose;

fn shown(map: impl Fn(Pose) -> Pose + 'static) -> Show {
    Box::new(move |_, _, pose| Some(map(pose)))
}

fn turned(by: f64) -> Show {
    shown(move |pose| Pose::new(pose.x, pose.y, pose.heading.radians() + by))
}

fn swapped() -> Wheels {
    Box::new(|_, WheelSpeeds { left, right }| WheelSpeeds { left: right, right: left })
}

fn inverted(left_sign: f64, right_sign: f64) -> Wheels {
    Box::new(move |_, WheelSpeeds { left, right }| WheelSpeeds {
        left: left_sign * left,
        right: right_sign * right,
    })
}

/// Each robot with a point to go to that lies ahead and to the side, and how far it may get: 0.3 m for the 0.1 m class,
/// for larger ones what a second at full speed and the ramp take.
fn robots() -> [(&'static str, Drive, (f64, f64), f64); 4] {
    [
        ("rover", rover(), (0.4, 0.3), 0.3),
        ("burger", burger(), (0.8, 0.6), 0.45),
        ("mini", mini(), (0.2, 0.15), 0.3),
        ("amr", amr(), (16.0, 12.0), 8.0),
    ]
}

fn fit(run: &Run) -> Option<Fit> {
    match run.alarm() {
        Some((_, Alarm::FrameMismatch { fit, .. })) => Some(fit),
        _ => None,
    }
}

fn assert_found(run: &Run, fits: &[Fit], what: &str) {
    assert!(fit(run).is_some_and(|fit| fits.contains(&fit)), "{what}: {}", run.report());
    assert!(run.rests_from().is_some(), "{what}: {}", run.report());
    let (turned, _) = run.turned();
    assert!(turned <= 13.0, "{what}: {}", run.report());
}

#[test]
fn a_heading_off_is_named_before_the_robot_is_far_away() {
    for (name, drive, to, far) in robots() {
        for rate in [10.0, 30.0] {
            for (off, expected) in [
                (PI, Fit::HalfTurn),
                (FRAC_PI_2, Fit::QuarterLeft),
                (-FRAC_PI_2, Fit::QuarterRight),
            ] {
                let run = World { rate, show: turned(off), ..World::new(drive, &[to]) }.run(25.0);
                let what = format!("{name} at {rate} Hz, off by {off}");
                assert_found(&run, &[expected], &what);
                assert!(run.away() <= far, "{what}: {}", run.report());
            }
        }
    }
}

#[test]
fn mirrored_and_swapped_axes_are_noticed() {
    let mirrors: [(&str, Mirror, &[Fit]); 4] = [
        // Pose and heading, as of a camera seen from below: it turns the other way.
        ("y", |p| Pose::new(p.x, -p.y, -p.heading.radians()), &[Fit::TurnsReversed]),
        (
            "x and y",
            |p| Pose::new(p.y, p.x, FRAC_PI_2 - p.heading.radians()),
            &[Fit::TurnsReversed],
        ),
        // The positions alone.
        (
            "y of positions",
            |p| Pose::new(p.x, -p.y, p.heading.radians()),
            &[Fit::PositionMirroredY, Fit::QuarterLeft, Fit::QuarterRight, Fit::HalfTurn],
        ),
        (
            "x of positions",
            |p| Pose::new(-p.x, p.y, p.heading.radians()),
            &[Fit::PositionMirroredX, Fit::HalfTurn, Fit::QuarterRight, Fit::QuarterLeft],
        ),
    ];
    for (name, drive, to, far) in robots() {
        for (what, mirror, fits) in &mirrors {
            let run = World { show: shown(*mirror), ..World::new(drive, &[to]) }.run(25.0);
            let what = format!("{name}, mirrored in {what}");
            assert_found(&run, fits, &what);
            assert!(run.away() <= far, "{what}: {}", run.report());
        }
    }
}

#[test]
fn wheels_swapped_or_inverted_are_noticed() {
    for (name, drive, to, far) in robots() {
        let wrong: [(&str, Wheels, Fit); 4] = [
            ("swapped", swapped(), Fit::TurnsReversed),
            ("both inverted", inverted(-1.0, -1.0), Fit::TurnsReversed),
            ("left inverted", inverted(-1.0, 1.0), Fit::OneInverted),
            ("right inverted", inverted(1.0, -1.0), Fit::OneInverted),
        ];
        for (what, wheels, expected) in wrong {
            let run = World { wheels, ..World::new(drive, &[to]) }.run(40.0);
            let what = format!("{name}, {what}");
            assert_found(&run, &[expected], &what);
            assert!(run.away() <= far, "{what}: {}", run.report());
        }
    }
}

/// Straight ahead nothing has to be turned first.
#[test]
fn straight_ahead_wrong_wheels_are_noticed_too() {
    let wrong: [(&str, Wheels); 4] = [
        ("swapped", swapped()),
        ("both inverted", inverted(-1.0, -1.0)),
        ("left inverted", inverted(-1.0, 1.0)),
        ("right inverted", inverted(1.0, -1.0)),
    ];
    for (what, wheels) in wrong {
        let run = World { wheels, ..World::new(rover(), &[(1.0, 0.0)]) }.run(40.0);
        // Who happens to see his goal straight ahead arrives with swapped wheels as well.
        let is_found = run.condition() == Some(Condition::FrameMismatch);
        assert!(is_found || run.arrived.is_some(), "{what}: {}", run.report());
        assert!(run.turned().0 <= 13.0 && run.away() <= 1.02, "{what}: {}", run.report());
    }
}
