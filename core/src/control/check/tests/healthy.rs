//! A robot with nothing wrong gets numbers and no finding, whatever its size, its tracker, its floor and its link.

use super::robot::{POOR, Robot, coin, poor, rover, truck};
use crate::check::Report;
use crate::exchange::PoseNoise;
use crate::kinematics::Drive;
use std::sync::Arc;

fn well(robot: Robot, what: &str) -> Arc<Report> {
    let run = robot.run();
    let report = run.report.clone().unwrap_or_else(|| panic!("{what}: no report"));
    assert!(report.is_well(), "{what}: {report:?}");
    assert!(run.rests, "{what}");
    assert!(run.ended.is_some_and(|at| at < 30.0), "{what}: {:?}", run.ended);
    report
}

#[test]
fn every_size_under_a_poor_camera_at_10_and_33_hz() {
    for (name, drive) in [("rover", rover()), ("coin", coin()), ("truck", truck())] {
        for rate in [10.0, 33.0] {
            for seed in 0..10 {
                let what = format!("{name} at {rate} Hz, seed {seed}");
                let report = well(poor(drive, rate, seed), &what);
                let numbers = report.numbers;
                let (forward, turn) = (numbers.forward.unwrap(), numbers.turn.unwrap());
                assert!((forward - 1.0).abs() < 0.06, "{what}: forward {forward}");
                assert!((turn - 1.0).abs() < 0.06, "{what}: turn {turn}");
                let delay = numbers.delay.unwrap();
                assert!(delay.abs() < 0.1, "{what}: delay {delay}");
                let noise = numbers.noise.unwrap();
                assert!(
                    (0.5..2.0).contains(&(noise.position / POOR.position)),
                    "{what}: {noise:?}"
                );
                assert!((numbers.poses_per_second - rate).abs() < 1.5, "{what}: {numbers:?}");
            }
        }
    }
}

#[test]
fn slip_of_8_percent() {
    for drive in [rover(), coin(), truck()] {
        for (seed, floor) in [(0, (0.92, 0.92)), (1, (1.0, 0.85)), (2, (1.08, 1.08))] {
            let robot = Robot { floor, slip: 0.08, ..poor(drive, 10.0, seed) };
            let report = well(robot, &format!("{floor:?}"));
            assert!((report.numbers.forward.unwrap() - floor.0).abs() < 0.08);
            assert!((report.numbers.turn.unwrap() - floor.1).abs() < 0.08);
        }
    }
}

#[test]
fn a_link_of_any_delay() {
    for (seed, delay) in [(0, 0.1), (1, 0.3), (2, 0.6)] {
        let mut robot =
            Robot { delays: (0.03, delay / 2.0, delay / 2.0), ..poor(rover(), 10.0, seed) };
        robot.settings.loop_delay = delay + 0.1;
        let report = well(robot, &format!("link {delay}"));
        assert!(report.numbers.delay.unwrap().abs() < 0.1, "{delay}: {:?}", report.numbers);
    }
}

#[test]
fn a_delay_that_is_described_is_measured_and_no_fault() {
    for delay in [0.1, 0.25, 0.4, 0.6] {
        for drive in [rover(), coin(), truck()] {
            let drive = Drive { dead_time: delay, ..drive };
            let report = well(poor(drive, 10.0, 3), &format!("dead time {delay}"));
            let seen = report.numbers.delay.unwrap();
            assert!((seen - delay).abs() < 0.06, "{delay}: {seen}");
        }
        let drive = Drive { lag: delay / 2.0, dead_time: delay / 2.0, ..rover() };
        let report = well(poor(drive, 10.0, 4), &format!("lag and dead time {delay}"));
        let seen = report.numbers.delay.unwrap();
        assert!((seen - delay).abs() < 0.08, "{delay}: {seen}");
    }
}

#[test]
fn no_noise_at_all_and_any_heading() {
    for heading in [0.0, 1.57, 3.1, -2.3] {
        let start = crate::geometry::Pose::new(0.0, 0.0, heading);
        let robot = Robot { noise: PoseNoise::NONE, start, ..Robot::new(rover()) };
        let report = well(robot, &format!("heading {heading}"));
        assert!((report.numbers.forward.unwrap() - 1.0).abs() < 0.01);
        assert!(report.numbers.delay.unwrap().abs() < 0.06, "{:?}", report.numbers);
    }
}

/// It stays where it was put, and nothing is learned.
#[test]
fn it_stays_within_its_room_and_learns_nothing() {
    for (drive, room) in [(rover(), 0.3), (coin(), 0.3), (truck(), 2.6)] {
        let run = poor(drive, 10.0, 1).run();
        assert!(run.away < room, "{}", run.away);
        let fresh = crate::controller::Controller::new(*run.controller.settings());
        assert_eq!(run.controller.belief().channels(), fresh.belief().channels());
        assert_eq!(run.controller.watch_state(), None);
    }
}

/// A stop in the middle is heeded, and the check begins anew after it.
#[test]
fn a_stop_ends_the_wiggle_and_a_resume_begins_it_anew() {
    let mut robot = poor(rover(), 10.0, 1);
    robot.orders = vec![(8.0, |it| it.stop()), (80.0, |it| it.resume())];
    let run = robot.run();
    assert!(run.report.as_ref().is_some_and(|report| report.is_well()), "{:?}", run.report);
    assert!(run.ended.is_some_and(|at| at > 100.0), "{:?}", run.ended);
}
