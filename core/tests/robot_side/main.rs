//! The robot's side plays recorded replies to the last digit as it always has, with the standard library and without:
//!
//! `cargo test -p umwelt-core --test robot_side` and the same with `--no-default-features`.
//!
//! `record.txt` is what reached a robot in some four seconds on a bad link, with an outage, a hold and a smaller speed;
//! `played.txt` is what it did. Who means to change that writes both anew: example `record_robot_side`.

mod player;

use umwelt_core::geometry::{Pose, Twist};
use umwelt_core::kinematics::{self, Drive};

/// The robot of the record.
fn drive() -> Drive {
    Drive { lag: 0.08, ..Drive::default() }
}

const RECORD: &str = include_str!("record.txt");

#[test]
fn what_is_played_is_the_same_to_the_last_digit() {
    let played = player::play(RECORD, drive());
    let golden = include_str!("played.txt");
    for (index, (played, golden)) in played.lines().zip(golden.lines()).enumerate() {
        assert_eq!(played, golden, "line {}", index + 1);
    }
    assert_eq!(played.lines().count(), golden.lines().count());
}

/// The record is of something: replies of every kind, a ramp to rest without a link, a hold that is reported.
#[test]
fn the_record_holds_what_robots_meet() {
    let played = player::play(RECORD, drive());
    for what in ["Newest", "Stale", "Held", "wheels 0.0 0.0", "(true, None)", "(false, Some(0.06))"]
    {
        assert!(played.contains(what), "no {what}");
    }
    let back: Vec<String> =
        RECORD.lines().map(player::read).map(|(at, e)| player::write(at, &e)).collect();
    assert_eq!(back.join("\n"), RECORD.trim_end(), "a record is read as it was written");
}

/// Where a robot comes to in arcs of every size: what takes sines, an exponential and a square root.
#[test]
fn elementary_functions_are_the_same_to_the_last_bit() {
    let (drive, mut pose) = (drive(), Pose::default());
    let mut bits = 0_u64;
    for step in 0..10_000 {
        let part = f64::from(step) / 10_000.0;
        let twist = Twist::new(0.13 * (part - 0.3), 2.5 * (0.7 - part));
        let command = kinematics::inverse(&drive, twist);
        let (end, mean) = kinematics::travel(&drive, command.scaled(part), command, 0.001 + part);
        pose = pose.then(kinematics::integrate(mean, 0.01 + 3.0 * part));
        let Pose { x, y, heading } = pose;
        for value in [x, y, heading.radians(), end.left, pose.point().distance(Default::default())]
        {
            bits = bits.rotate_left(5) ^ value.to_bits();
        }
    }
    assert_eq!(bits, GOLDEN_BITS);
}

/// All bits of that way folded into one number.
const GOLDEN_BITS: u64 = 8_813_150_233_758_775_356;
