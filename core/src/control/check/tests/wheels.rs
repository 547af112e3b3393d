//! Faults of wheels and drive.

use super::robot::{Robot, Wheels, coin, rover, truck};
use crate::check::{Fault, Finding};
use crate::geometry::WheelSpeeds;
use crate::kinematics::Drive;

fn with(drive: Drive, wheels: Wheels) -> Vec<Fault> {
    Robot { wheels, ..Robot::new(drive) }.faults()
}

#[test]
fn each_mistake_of_the_wheels_has_its_name() {
    let cases: [(Fault, Wheels); 7] = [
        (Fault::Swapped, |it| WheelSpeeds { left: it.right, right: it.left }),
        (Fault::LeftInverted, |it| WheelSpeeds { left: -it.left, ..it }),
        (Fault::RightInverted, |it| WheelSpeeds { right: -it.right, ..it }),
        (Fault::BothInverted, |it| it.scaled(-1.0)),
        (Fault::HalfTurn, |it| WheelSpeeds { left: -it.right, right: -it.left }),
        (Fault::LeftStands, |it| WheelSpeeds { left: 0.0, ..it }),
        (Fault::RightStands, |it| WheelSpeeds { right: 0.0, ..it }),
    ];
    for (fault, wheels) in cases {
        for drive in [rover(), coin(), truck()] {
            assert_eq!(with(drive, wheels), [fault], "{fault:?} {}", drive.track_width);
        }
    }
}

#[test]
fn a_robot_that_does_not_move() {
    for drive in [rover(), coin(), truck()] {
        assert_eq!(with(drive, |_| WheelSpeeds::ZERO), [Fault::DoesNotMove]);
    }
}

/// Motors that need a speed described too small: it stands where it should turn in place.
#[test]
fn a_robot_that_does_not_turn_in_place() {
    let coarse = |it: WheelSpeeds| {
        let turns = |speed: f64| if speed.abs() < 1.0 { 0.0 } else { speed };
        WheelSpeeds { left: turns(it.left), right: turns(it.right) }
    };
    assert_eq!(with(rover(), coarse), [Fault::DoesNotTurn]);
}

#[test]
fn another_wheel_radius_and_another_track_have_their_numbers() {
    for drive in [rover(), coin(), truck()] {
        for factor in [0.2, 0.6, 1.5, 3.0] {
            let real = Drive { wheel_radius: factor * drive.wheel_radius, ..drive };
            let run = Robot { real, ..Robot::new(drive) }.run();
            let report = run.report.unwrap();
            let [Finding::WheelRadius { as_with, .. }] = report.findings[..] else {
                panic!("{factor}: {report:?}");
            };
            assert!((as_with / real.wheel_radius - 1.0).abs() < 0.08, "{factor}: {as_with}");
            let real = Drive { track_width: factor * drive.track_width, ..drive };
            let run = Robot { real, ..Robot::new(drive) }.run();
            let report = run.report.unwrap();
            let [Finding::TrackWidth { as_with, .. }] = report.findings[..] else {
                panic!("{factor}: {report:?}");
            };
            assert!((as_with / real.track_width - 1.0).abs() < 0.08, "{factor}: {as_with}");
        }
    }
}

#[test]
fn a_dead_time_that_is_not_described_is_measured() {
    for delay in [0.3, 0.45, 0.6, 1.0] {
        for drive in [rover(), coin(), truck()] {
            let real = Drive { dead_time: delay, ..drive };
            let report = Robot { real, ..Robot::new(drive) }.run().report.unwrap();
            let [Finding::Delay { seen, described: 0.0 }] = report.findings[..] else {
                panic!("{delay}: {report:?}");
            };
            assert!((seen - delay).abs() < 0.06, "{delay}: {seen}");
        }
    }
}

/// Wheels far larger than described: the check ends where it has gone too far.
#[test]
fn a_robot_that_goes_too_far_is_brought_to_rest() {
    let real = Drive { wheel_radius: 10.0 * rover().wheel_radius, ..rover() };
    let run = Robot { real, ..Robot::new(rover()) }.run();
    assert_eq!(run.faults(), [Fault::TooFar]);
    assert!(run.rests && run.away < 1.6, "{}", run.away);
}
