//! Faults of the tracker: frame, units, stamps, rate and noise.

use super::robot::{Robot, coin, rover, truck};
use crate::check::{Clock, Fault, Finding};
use crate::exchange::PoseNoise;
use std::f64::consts::{FRAC_PI_2, PI};

fn seen(show: impl Fn([f64; 3]) -> [f64; 3] + Copy + 'static, fault: Fault) {
    for drive in [rover(), coin(), truck()] {
        for rate in [10.0, 33.0] {
            let show = Box::new(move |_, pose| Some(show(pose)));
            let faults = Robot { show, rate, ..Robot::new(drive) }.faults();
            assert_eq!(faults, [fault], "{fault:?} {} {rate}", drive.track_width);
        }
    }
}

#[test]
fn heading_off() {
    seen(|[x, y, h]| [x, y, h + PI], Fault::HalfTurn);
    seen(|[x, y, h]| [x, y, h + FRAC_PI_2], Fault::QuarterTurn);
    seen(|[x, y, h]| [x, y, h - FRAC_PI_2], Fault::QuarterTurn);
    seen(|[x, y, h]| [x, y, h + 0.7], Fault::HeadingOff);
}

#[test]
fn positions_mirrored_or_exchanged_and_the_heading_not() {
    seen(|[x, y, h]| [-x, y, h], Fault::MirroredX);
    seen(|[x, y, h]| [x, -y, h], Fault::MirroredY);
    seen(|[x, y, h]| [y, x, h], Fault::Exchanged);
}

#[test]
fn positions_and_heading_mirrored_look_like_swapped_wheels() {
    seen(|[x, y, h]| [-x, y, PI - h], Fault::Swapped);
    seen(|[x, y, h]| [x, -y, -h], Fault::Swapped);
    seen(|[x, y, h]| [y, x, FRAC_PI_2 - h], Fault::Swapped);
}

#[test]
fn a_heading_that_counts_clockwise() {
    seen(|[x, y, h]| [x, y, -h], Fault::Clockwise);
    seen(|[x, y, h]| [x, y, FRAC_PI_2 - h], Fault::Clockwise);
}

#[test]
fn other_units() {
    seen(|[x, y, h]| [1000.0 * x, 1000.0 * y, h], Fault::Millimetres);
    seen(|[x, y, h]| [100.0 * x, 100.0 * y, h], Fault::Centimetres);
    seen(|[x, y, h]| [x, y, h.to_degrees()], Fault::Degrees);
    seen(|[x, y, h]| [x, y, h.to_degrees().rem_euclid(360.0)], Fault::Degrees);
}

#[test]
fn a_heading_that_stays() {
    seen(|[x, y, _]| [x, y, 0.3], Fault::HeadingFixed);
}

#[test]
fn stamps_of_another_clock() {
    let stamps: [fn(f64) -> f64; 3] = [|t| t - 1.0, |t| t + 0.2, |t| 0.97 * t];
    for stamp in stamps {
        assert_eq!(Robot { stamp, ..Robot::new(rover()) }.faults(), [Fault::OtherClock]);
    }
    let report = Robot { stamp: |t| t - 1.0, ..Robot::new(rover()) }.run().report.unwrap();
    let [Finding::OtherClock(Clock::Old(age))] = report.findings[..] else { panic!("{report:?}") };
    assert!((age - 1.03).abs() < 0.1, "{age}");
}

#[test]
fn poses_that_do_not_come_or_no_longer() {
    let none = Box::new(|_, _| None);
    let run = Robot { show: none, ..Robot::new(rover()) }.run();
    assert_eq!((run.faults(), run.away), (vec![Fault::NoPoses], 0.0));
    let until: super::robot::Show = Box::new(|t, pose| (t < 6.0).then_some(pose));
    let run = Robot { show: until, ..Robot::new(rover()) }.run();
    assert_eq!(run.faults(), [Fault::NoPoses]);
    assert!(run.rests && run.ended.is_some_and(|at| at < 9.0), "{:?}", run.ended);
}

#[test]
fn too_few_poses() {
    for rate in [3.0, 1.2] {
        assert_eq!(Robot { rate, ..Robot::new(rover()) }.faults(), [Fault::TooFewPoses], "{rate}");
    }
}

#[test]
fn noise_that_is_not_described() {
    let noise = PoseNoise { position: 0.004, heading: 0.005 };
    let report = Robot { noise, ..Robot::new(rover()) }.run().report.unwrap();
    let [Finding::Noise { seen, .. }] = report.findings[..] else { panic!("{report:?}") };
    assert!((0.6..1.5).contains(&(seen.position / 0.004)), "{seen:?}");
}

#[test]
fn a_tracker_that_repeats_one_pose() {
    let show: super::robot::Show = Box::new(|_, _| Some([1.0, 2.0, 0.3]));
    assert_eq!(Robot { show, ..Robot::new(rover()) }.faults(), [Fault::DoesNotMove]);
}
