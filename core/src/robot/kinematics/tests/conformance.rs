//! What holds of the motion model of any kind: a kind more is a line more at the end.

use crate::geometry::{Displacement, Pose, Twist, WheelSpeeds};
use crate::kinematics::{Drive, Errors, Kind, MotionModel, SkidSteer, integrate};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

/// Drives of a kind.
fn drives(kind: impl Strategy<Value = Kind>) -> impl Strategy<Value = Drive> {
    (kind, 0.01..0.2f64, 0.05..1.0f64, -0.05..0.05f64, 0.2..8.0f64).prop_map(
        |(kind, wheel_radius, track_width, unequal, max_wheel_speed)| Drive {
            wheel_radius,
            track_width,
            unequal,
            max_wheel_speed,
            kind,
            ..Drive::default()
        },
    )
}

fn differential() -> impl Strategy<Value = Kind> {
    Just(Kind::Differential)
}

fn skid_steer() -> impl Strategy<Value = Kind> {
    (-0.6..0.6f64, -0.1..0.1f64).prop_map(|(turn_by_speed, sideways)| {
        Kind::SkidSteer(SkidSteer { turn_by_speed, sideways })
    })
}

fn twists() -> impl Strategy<Value = Twist> {
    (-1.0..1.0f64, -9.0..9.0f64).prop_map(|(linear, angular)| Twist { linear, angular })
}

fn poses() -> impl Strategy<Value = Pose> {
    (-2.0..2.0f64, -2.0..2.0f64, -3.0..3.0f64).prop_map(|(x, y, heading)| Pose::new(x, y, heading))
}

fn errors() -> impl Strategy<Value = Errors> {
    (-0.5..0.5f64, -0.3..0.3f64, -0.5..0.5f64, -0.5..0.5f64)
        .prop_map(|(forward, lateral, turn, drift)| Errors { forward, lateral, turn, drift })
}

fn near(one: Pose, other: Pose, tolerance: f64) -> bool {
    one.point().distance(other.point()) < tolerance
        && one.heading.minus(other.heading).abs() < tolerance
}

fn fastest(drive: &Drive, twist: Twist) -> f64 {
    let WheelSpeeds { left, right } = drive.inverse(twist);
    left.abs().max(right.abs())
}

/// The tests that every kind passes.
macro_rules! conforms {
    ($kind:ident) => {
        mod $kind {
            use super::*;

            proptest! {
                /// Guards against: wheels commanded for another twist than the one that is planned with.
                #[test]
                fn a_twist_is_what_its_wheels_make(drive in drives(super::$kind()), twist in twists()) {
                    let wheels = drive.inverse(twist);
                    let back = drive.forward(wheels);
                    prop_assert!((back.linear - twist.linear).abs() < 1e-9);
                    prop_assert!((back.angular - twist.angular).abs() < 1e-9);
                    let again = drive.inverse(back);
                    prop_assert!((again.left - wheels.left).abs() < 1e-6);
                    prop_assert!((again.right - wheels.right).abs() < 1e-6);
                }

                /// Guards against: a robot at rest that creeps.
                #[test]
                fn zero_is_rest(drive in drives(super::$kind()), pose in poses(), errors in errors()) {
                    prop_assert_eq!(drive.forward(WheelSpeeds::ZERO), Twist::ZERO);
                    prop_assert_eq!(drive.inverse(Twist::ZERO), WheelSpeeds::ZERO);
                    prop_assert!(near(drive.next(pose, 0.0, 0.0, &errors), pose, 1e-15));
                    prop_assert_eq!(drive.of_middle(Displacement::default()), Displacement::default());
                }

                /// Guards against: a wheel commanded faster than it can be, or another curve than was wanted.
                #[test]
                fn limits_hold_and_keep_the_curve(drive in drives(super::$kind()), twist in twists()) {
                    let limited = drive.limited(twist);
                    prop_assert!(limited.linear.abs() <= drive.max_linear + 1e-12);
                    prop_assert!(limited.angular.abs() <= drive.max_angular + 1e-12);
                    prop_assert!(fastest(&drive, limited) <= drive.max_wheel_speed * (1.0 + 1e-12));
                    prop_assert!((limited.linear * twist.angular - limited.angular * twist.linear).abs() < 1e-9);
                    let is_at_a_limit = limited.linear.abs() >= drive.max_linear * (1.0 - 1e-9)
                        || limited.angular.abs() >= drive.max_angular * (1.0 - 1e-9)
                        || fastest(&drive, limited) >= drive.max_wheel_speed * (1.0 - 1e-6);
                    prop_assert!(limited == twist || is_at_a_limit, "slower than it need be: {limited:?}");
                }

                /// Guards against: a change of speed on the way to an allowed one that asks for more than the wheels can do.
                #[test]
                fn between_what_the_wheels_can_do_they_are_commanded_no_more(
                    drive in drives(super::$kind()),
                    (from, to) in (twists(), twists()),
                    duration in 1e-6..0.03f64,
                ) {
                    let drive = Drive { unequal: 0.0, ..drive };
                    let (from, to) = (drive.limited(from), drive.limited(to));
                    let reached = drive.reach(from, to, duration);
                    let fastest = fastest(&drive, reached);
                    prop_assert!(fastest <= drive.max_wheel_speed * (1.0 + 1e-9), "{fastest}: {reached:?}");
                    prop_assert!(drive.change_time(from, reached) <= duration + 1e-9, "{reached:?}");
                }

                /// Guards against: a robot that never gets from one allowed speed to another.
                #[test]
                fn what_is_allowed_is_reached(drive in drives(super::$kind()), from in twists(), to in twists()) {
                    let drive = Drive { unequal: 0.0, ..drive };
                    let (mut at, to) = (drive.limited(from), drive.limited(to));
                    for _ in 0..100 {
                        at = drive.reach(at, to, 0.03);
                    }
                    prop_assert!((at.linear - to.linear).abs() < 1e-9, "{at:?} {to:?}");
                    prop_assert!((at.angular - to.angular).abs() < 1e-9, "{at:?} {to:?}");
                }

                /// Guards against: a pose that depends on how time is cut.
                #[test]
                fn two_halves_are_the_whole(
                    drive in drives(super::$kind()),
                    (pose, errors) in (poses(), errors()),
                    (length, turn) in (-0.5..0.5f64, -3.0..3.0f64),
                ) {
                    let half = |pose| drive.next(pose, length / 2.0, turn / 2.0, &errors);
                    let whole = drive.next(pose, length, turn, &errors);
                    prop_assert!(near(half(half(pose)), whole, 1e-9));
                    let (arc, half) = (integrate(Twist::new(length, turn), 1.0), integrate(Twist::new(length, turn), 0.5));
                    let halves = drive.of_middle(half).then(drive.of_middle(half));
                    prop_assert!(near(pose.then(halves), pose.then(drive.of_middle(arc)), 1e-9));
                }

                /// Guards against: a simulated robot that moves otherwise than the same robot is predicted to.
                #[test]
                fn without_errors_the_middle_goes_where_the_arc_of_its_centre_leads(
                    drive in drives(super::$kind()),
                    pose in poses(),
                    twist in twists(),
                    duration in 0.0..0.5f64,
                ) {
                    let arc = integrate(twist, duration);
                    let (length, turn) = (twist.linear * duration, twist.angular * duration);
                    let next = drive.next(pose, length, turn, &Errors::default());
                    prop_assert!(near(next, pose.then(drive.of_middle(arc)), 1e-9));
                    let back = drive.of_centre(drive.of_middle(arc));
                    prop_assert!((back.forward - arc.forward).abs() < 1e-12);
                    prop_assert!((back.lateral - arc.lateral).abs() < 1e-12);
                    prop_assert!(near(drive.centre_of(next), drive.centre_of(pose).then(arc), 1e-9));
                }
            }

            /// The exact motion is what small steps of the three speeds sum to: ahead, to the left, around.
            #[test]
            fn the_motion_is_what_small_steps_sum_to() {
                let mut runner = proptest::test_runner::TestRunner::deterministic();
                let drive = drives(super::$kind()).new_tree(&mut runner).expect("a drive").current();
                let errors = Errors { forward: 0.1, lateral: -0.05, turn: -0.2, drift: 0.3 };
                let (start, length, turn, steps) = (Pose::new(0.3, -0.2, 2.0), 0.4, 1.5, 100_000);
                let turned = turn * (1.0 + errors.turn) + length * errors.drift;
                let ahead = length * (1.0 + errors.forward);
                let aside = length * errors.lateral + drive.sideways() * turned;
                let [ahead, aside, around] = [ahead, aside, turned].map(|it| it / f64::from(steps));
                let mut pose = start;
                for _ in 0..steps {
                    let (sin, cos) = (pose.heading.radians() + around / 2.0).sin_cos();
                    let heading = pose.heading.radians() + around;
                    let (x, y) = (ahead * cos - aside * sin, ahead * sin + aside * cos);
                    pose = Pose::new(pose.x + x, pose.y + y, heading);
                }
                assert!(near(drive.next(start, length, turn, &errors), pose, 1e-8));
            }
        }
    };
}

conforms!(differential);
conforms!(skid_steer);

proptest! {
    /// Guards against: a robot described as skid-steer with nothing to say that drives otherwise than before, by one bit.
    #[test]
    fn skid_steer_without_its_numbers_is_differential(
        drive in drives(differential()),
        (from, to) in (twists(), twists()),
        (pose, errors) in (poses(), errors()),
        (length, turn) in (-0.5..0.5f64, -3.0..3.0f64),
    ) {
        let none = Drive { kind: Kind::SkidSteer(SkidSteer::default()), ..drive };
        let wheels = drive.inverse(to);
        prop_assert_eq!(none.inverse(to), wheels);
        prop_assert_eq!(none.forward(wheels), drive.forward(wheels));
        prop_assert_eq!(none.reach(from, to, 0.03), drive.reach(from, to, 0.03));
        prop_assert_eq!(none.next(pose, length, turn, &errors), drive.next(pose, length, turn, &errors));
        prop_assert_eq!(none.limited(to), drive.limited(to));
        let arc = integrate(to, 0.1);
        prop_assert_eq!(none.of_middle(arc), arc);
    }

    /// Guards against: a small description that makes a large difference.
    #[test]
    fn skid_steer_tends_to_differential(
        drive in drives(differential()),
        twist in twists(),
        (pose, errors) in (poses(), errors()),
        (length, turn) in (-0.5..0.5f64, -3.0..3.0f64),
        small in -1e-6..1e-6f64,
    ) {
        let skid = SkidSteer { turn_by_speed: small, sideways: small };
        let nearly = Drive { kind: Kind::SkidSteer(skid), ..drive };
        let apart = 1e-4;
        let (one, other) = (nearly.forward(drive.inverse(twist)), twist);
        prop_assert!((one.angular - other.angular).abs() < apart);
        let (one, other) = (nearly.limited(twist), drive.limited(twist));
        prop_assert!((one.linear - other.linear).abs() < apart && (one.angular - other.angular).abs() < apart);
        let next = |drive: &Drive| drive.next(pose, length, turn, &errors);
        prop_assert!(near(next(&nearly), next(&drive), apart));
    }
}
