//! Squares that are interrupted, and such that come to no end.

use super::robot::{Robot, floor};
use crate::geometry::WheelSpeeds;
use crate::kinematics::Drive;
use crate::square::Ending;
use crate::watch::Condition;

fn robot() -> Robot {
    Robot::new(Drive::default(), floor(0.0, -0.02, 0.0))
}

#[test]
fn a_stop_in_the_middle_begins_the_run_anew_and_not_those_before() {
    let whole = robot().run().ended.unwrap();
    let mut stopped = robot();
    stopped.orders = vec![(0.75 * whole, |it| it.stop()), (0.75 * whole + 5.0, |it| it.resume())];
    let run = stopped.run();
    let report = run.report.unwrap();
    assert_eq!((report.ending, report.returns.len()), (Ending::Driven, 2));
    let (ended, driven_again) = (run.ended.unwrap(), 0.25 * whole + 5.0);
    assert!((ended - whole - driven_again).abs() < 3.0, "{ended} {whole}");
    let track = report.systematic.unwrap().track_width;
    assert!((track / 0.1 - 1.0 / 0.98).abs() < 0.003, "{track}");
}

/// Whether it is a stop or blocked wheels: nothing of it is in the figure.
#[test]
fn a_robot_that_is_stuck_rests_and_begins_its_run_anew_once_it_is_let_go() {
    let mut blocked = robot();
    blocked.wheels = |t, speeds| if (20.0..30.0).contains(&t) { WheelSpeeds::ZERO } else { speeds };
    blocked.orders = vec![
        (29.0, |it| {
            let found = it.watch_state().map(|(alarm, rests)| (alarm.condition(), rests));
            assert_eq!(found, Some((Condition::Stuck, true)));
        }),
        (31.0, |it| it.resume()),
    ];
    let report = blocked.run().report.unwrap();
    assert_eq!(report.ending, Ending::Driven);
    let found = report.systematic.unwrap();
    assert!((found.track_width / 0.1 - 1.0 / 0.98).abs() < 0.003, "{found:?}");
}

#[test]
fn too_few_poses_at_rest_end_it() {
    let run = Robot { rate: 1.2, ..robot() }.run();
    assert_eq!(run.report.unwrap().ending, Ending::TooFewPoses);
    assert!(run.away < 1.5);
}

#[test]
fn a_robot_much_faster_than_described_is_too_far() {
    let mut wheels = robot();
    wheels.wheels = |_, it| {
        let mean = f64::midpoint(it.left, it.right);
        // Turns as commanded, and drives four times as far.
        WheelSpeeds { left: it.left + 3.0 * mean, right: it.right + 3.0 * mean }
    };
    wheels.plant.drive.max_wheel_speed = 40.0;
    let run = wheels.run();
    assert!(run.away < 3.5, "{}", run.away);
    assert_eq!(
        run.report.map(|report| report.ending),
        Some(Ending::TooFar),
        "{:?}",
        run.controller.watch_state()
    );
}

/// The task teaches as any motion does.
#[test]
fn the_floor_is_identified_meanwhile() {
    let run = robot().run();
    let fresh = crate::controller::Controller::new(*run.controller.settings());
    assert_ne!(run.controller.belief().channels(), fresh.belief().channels());
    assert!(run.controller.has_arrived());
    assert_eq!(run.controller.watch_state(), None);
}

#[test]
fn another_task_has_no_report() {
    let mut controller = robot().run().controller;
    assert!(controller.square_report().is_some());
    controller.set_task(crate::task::Task::thesis());
    assert!(controller.square_report().is_none());
}
