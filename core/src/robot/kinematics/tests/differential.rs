//! Differential drive, its limits and its lag.

use crate::geometry::{Pose, Twist, WheelSpeeds};
use crate::kinematics::*;
use proptest::prelude::*;

#[test]
fn the_arc_is_what_small_steps_sum_to() {
    let twist = Twist::new(0.12, 1.1);
    let steps = 200_000;
    let mut pose = Pose::default();
    for _ in 0..steps {
        let h = 0.7 / f64::from(steps);
        let mid = pose.heading.radians() + twist.angular * h / 2.0;
        pose = Pose::new(
            pose.x + twist.linear * h * mid.cos(),
            pose.y + twist.linear * h * mid.sin(),
            pose.heading.radians() + twist.angular * h,
        );
    }
    let exact = Pose::default().then(integrate(twist, 0.7));
    assert!((pose.x - exact.x).abs() < 1e-9 && (pose.y - exact.y).abs() < 1e-9);
}

#[test]
fn following_is_what_small_steps_sum_to() {
    let (from, to) =
        (WheelSpeeds { left: 1.0, right: -2.0 }, WheelSpeeds { left: 4.0, right: 3.0 });
    let (lag, duration, steps) = (0.1, 0.07, 400_000);
    let h = duration / f64::from(steps);
    let (mut speed, mut sum) = (from.left, 0.0);
    for _ in 0..steps {
        let next = speed + (to.left - speed) / lag * h;
        sum += (speed + next) / 2.0 * h;
        speed = next;
    }
    let (end, mean) = follow(lag, from, to, duration);
    assert!((end.left - speed).abs() < 1e-6);
    assert!((mean.left - sum / duration).abs() < 1e-6);
}

proptest! {
    #[test]
    fn the_arc_tends_to_the_straight_line(v in -0.2..0.2f64, t in 0.0..1.0f64, w in -1e-3..1e-3f64) {
        let d = integrate(Twist::new(v, w), t);
        prop_assert!((d.forward - v * t).abs() < 1e-6 && d.lateral.abs() < 1e-3);
    }

    #[test]
    fn what_is_reached_keeps_the_acceleration_limit_and_gets_there(a in -0.13..0.13f64, b in -0.13..0.13f64, wa in -1.2..1.2f64, wb in -1.2..1.2f64) {
        let drive = Drive::default();
        let (mut at, to) = (Twist::new(a, wa), Twist::new(b, wb));
        for _ in 0..100 {
            let next = drive.reach(at, to, 0.03);
            prop_assert!(drive.change_time(at, next) <= 0.03 + 1e-9);
            at = next;
        }
        prop_assert_eq!(at, to);
    }

    #[test]
    fn part_way_takes_its_share_of_the_time(a in -0.13..0.13f64, b in -0.13..0.13f64, wa in -1.2..1.2f64, wb in -1.2..1.2f64, share in 0.0..1.0f64) {
        let drive = Drive::default();
        let (from, to) = (Twist::new(a, wa), Twist::new(b, wb));
        let part = drive.part_way(from, to, share);
        let (first, rest) = (drive.change_time(from, part), drive.change_time(part, to));
        let whole = drive.change_time(from, to);
        prop_assert!((first - share * whole).abs() < 1e-9 && (rest - (1.0 - share) * whole).abs() < 1e-9);
    }

    #[test]
    fn following_ends_between_where_it_was_and_the_command(a in -8.0..8.0f64, b in -8.0..8.0f64, t in 0.0..1.0f64) {
        let from = WheelSpeeds { left: a, right: b };
        let to = WheelSpeeds { left: b, right: a };
        let (end, mean) = follow(0.08, from, to, t);
        for value in [end.left, mean.left, end.right, mean.right] {
            prop_assert!(value >= a.min(b) - 1e-9 && value <= a.max(b) + 1e-9);
        }
    }
}
