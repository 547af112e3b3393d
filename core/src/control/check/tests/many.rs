//! Many robots under a poor camera: every finding is the right one.

use super::robot::{Robot, coin, poor, rover, truck};
use crate::check::Fault;
use crate::geometry::{Pose, WheelSpeeds};
use crate::kinematics::Drive;
use std::f64::consts::FRAC_PI_2;

/// Robots of each kind; 150 of them were looked at once.
const ROBOTS: u64 = 15;

/// What is wrong with a robot, if anything.
type Case = (Option<Fault>, fn(Robot) -> Robot);

fn seen(robot: Robot, show: fn([f64; 3]) -> [f64; 3]) -> Robot {
    Robot { show: Box::new(move |_, pose| Some(show(pose))), ..robot }
}

const CASES: [Case; 10] = [
    (None, |it| it),
    (Some(Fault::Degrees), |it| seen(it, |[x, y, h]| [x, y, h.to_degrees()])),
    (Some(Fault::MirroredX), |it| seen(it, |[x, y, h]| [-x, y, h])),
    (Some(Fault::QuarterTurn), |it| seen(it, |[x, y, h]| [x, y, h + FRAC_PI_2])),
    (Some(Fault::Millimetres), |it| seen(it, |[x, y, h]| [1000.0 * x, 1000.0 * y, h])),
    (Some(Fault::LeftStands), |it| Robot { wheels: |it| WheelSpeeds { left: 0.0, ..it }, ..it }),
    (Some(Fault::RightInverted), |it| Robot {
        wheels: |it| WheelSpeeds { right: -it.right, ..it },
        ..it
    }),
    (Some(Fault::Swapped), |it| Robot {
        wheels: |it| WheelSpeeds { left: it.right, right: it.left },
        ..it
    }),
    (Some(Fault::DoesNotMove), |it| Robot { wheels: |_| WheelSpeeds::ZERO, ..it }),
    (Some(Fault::Delay), |it| Robot { real: Drive { dead_time: 0.45, ..it.real }, ..it }),
];

#[test]
fn every_finding_is_the_right_one() {
    for drive in [rover(), coin(), truck()] {
        for rate in [10.0, 33.0] {
            for seed in 0..ROBOTS {
                for (fault, with) in CASES {
                    let part = |steps: u64| (seed % steps) as f64 / (steps - 1) as f64;
                    let delay = 0.1 + 0.5 * part(7);
                    let mut robot = poor(drive, rate, seed);
                    robot.settings.loop_delay = delay;
                    robot.delays = (0.03, delay / 2.0, delay / 2.0);
                    robot.start = Pose::new(0.0, 0.0, seed as f64);
                    robot.floor = (0.92 + 0.16 * part(3), 0.92 + 0.16 * part(5));
                    robot.slip = 0.08;
                    let faults = with(robot).faults();
                    let what = format!("{} m, {rate} Hz, seed {seed}", drive.track_width);
                    assert_eq!(faults, Vec::from_iter(fault), "{what}");
                }
            }
        }
    }
}
