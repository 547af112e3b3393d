//! What skid steer has of its own.

use crate::geometry::{Displacement, Pose, Twist, WheelSpeeds};
use crate::kinematics::{Drive, Kind, MotionModel, SkidSteer, TURN_RATIO, integrate};
use std::f64::consts::FRAC_PI_2;

fn drive(turn_by_speed: f64, sideways: f64) -> Drive {
    Drive { kind: Kind::SkidSteer(SkidSteer { turn_by_speed, sideways }), ..Drive::default() }
}

/// Guards against: a speed that makes the turn larger ahead and smaller in reverse.
#[test]
fn the_same_difference_of_the_wheels_turns_by_speed_either_way() {
    let drive = drive(0.5, 0.0);
    let turning = |speed: f64| {
        let wheels = WheelSpeeds { left: speed - 1.0, right: speed + 1.0 };
        drive.forward(wheels).angular
    };
    let at_rest = turning(0.0);
    // 4 rad/s of a wheel of 0.03 m are 0.12 m/s.
    for speed in [4.0, -4.0] {
        assert!((turning(speed) / at_rest - 1.06).abs() < 1e-12);
    }
}

#[test]
fn turn_ratio_is_one_plus_turn_by_speed_times_speed_within_what_is_meant() {
    let skid = SkidSteer { turn_by_speed: -0.4, sideways: 0.0 };
    assert!((skid.turn_ratio(0.5) - 0.8).abs() < 1e-15);
    assert_eq!((skid.turn_ratio(9.0), skid.turn_ratio(-9.0)), (TURN_RATIO.0, TURN_RATIO.0));
}

/// Guards against: sideways motion of the wrong sign; the middle of a robot that turns left about a centre behind it goes
/// to the left.
#[test]
fn in_place_the_middle_goes_around_the_turning_centre() {
    let drive = drive(0.0, 0.05);
    let quarter = integrate(Twist::new(0.0, 1.0), FRAC_PI_2);
    let moved = Pose::default().then(drive.of_middle(quarter));
    assert!((moved.x + 0.05).abs() < 1e-12 && (moved.y - 0.05).abs() < 1e-12);
    let small = drive.of_middle(Displacement { turn: 1e-6, ..Displacement::default() });
    assert!((small.lateral / 1e-6 - 0.05).abs() < 1e-6);
}
