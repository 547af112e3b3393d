//! Robots that do not move at their smallest speed, and robots that move otherwise than described and yet arrive.

use super::dead_band;
use super::harness::{Floor, Wheels, World, amr, burger, mini, rover};
use crate::METHOD;
use umwelt_core::derived::complete;
use umwelt_core::geometry::{Twist, WheelSpeeds};
use umwelt_core::kinematics::Drive;
use umwelt_core::settings::Method;
use umwelt_core::task::Calibration;
use umwelt_core::watch::Condition;

/// Robots, the dead band of their motors in rad/s, and the sides of the corner to drive.
fn sticky() -> [(&'static str, Drive, f64, (f64, f64)); 4] {
    [
        ("rover", rover(), 1.5, (0.8, 0.3)),
        ("burger", burger(), 1.2, (0.8, 0.4)),
        ("mini", mini(), 3.0, (0.4, 0.15)),
        ("amr", amr(), 1.0, (6.0, 3.0)),
    ]
}

#[test]
fn a_dead_band_is_overcome() {
    for (name, drive, band, (ahead, aside)) in sticky() {
        for (rate, noise) in [(30.0, 0.0005), (60.0, 0.0005), (30.0, 0.0)] {
            let corner = [(ahead, 0.0), (ahead, aside)];
            let world = World::new(drive, &corner);
            let free = World { rate, noise: (noise, 6.0 * noise), ..world }.run(60.0);
            let free_time = free.arrived.unwrap_or_else(|| panic!("{name}: {}", free.report()));
            let wheels = dead_band(band);
            let run =
                World { rate, noise: (noise, 6.0 * noise), wheels, ..World::new(drive, &corner) };
            let run = run.run(60.0);
            let what = format!("{name} at {rate} Hz, noise {noise}");
            let time = run.arrived.unwrap_or_else(|| panic!("{what}: {}", run.report()));
            assert!(time <= free_time + 29.0, "{what}: {}", run.report());
        }
    }
}

/// A turn so small that the motors cannot make it is not tried for ever: the curve takes it.
#[test]
fn a_small_turn_beyond_a_wide_dead_band_does_not_hunt() {
    for seed in 1..=8 {
        for (ahead, aside) in [(0.6, 0.5), (0.6, 0.3), (0.5, -0.4)] {
            let world = World::new(burger(), &[(ahead, aside)]);
            let run = World { wheels: dead_band(2.33), seed, ..world }.run(60.0);
            assert!(run.arrived.is_some_and(|at| at <= 30.0), "{seed}: {}", run.report());
        }
    }
}

/// The same where what is left of the turn is more than the curve can take, and the way too short for the motors' speed:
/// the speed up to which they stand is sought, and a raise lasts no longer than it may.
#[test]
fn a_short_turn_of_slow_acceleration_beyond_a_dead_band_gets_on_or_rests() {
    for seed in 1..=8 {
        for (ahead, aside) in [(5.0, 4.0), (5.0, -1.0), (5.0, 1.5)] {
            let world = World::new(amr(), &[(ahead, aside)]);
            // Three times a common band leaves adaptive hunting for its waypoint by some centimetres.
            let band = if METHOD == Method::Adaptive { 1.5 } else { 3.0 };
            let run = World { wheels: dead_band(band), seed, ..world }.run(70.0);
            assert!(run.arrived.is_some(), "{seed}: {}", run.report());
        }
    }
}

/// The raise is learned: a second corner takes no raise.
#[test]
fn a_dead_band_is_learned() {
    let corners = [(0.8, 0.0), (0.8, 0.3), (0.4, 0.3), (0.4, 0.0), (0.8, 0.0)];
    let run = World { wheels: dead_band(1.5), ..World::new(rover(), &corners) }.run(90.0);
    assert!(run.arrived.is_some(), "{}", run.report());
    let raised = run.remarks().into_iter().filter(|it| *it == Condition::Raised).count();
    // What is believed of the dead band makes a raise needless before it comes.
    let least = if METHOD == Method::Adaptive { 0 } else { 1 };
    assert!((least..=4).contains(&raised), "{}", run.report());
}

/// Blocked at its smallest speed, a robot is tried faster, for at most twenty seconds.
#[test]
fn what_no_speed_overcomes_is_stuck() {
    let nothing: Wheels = Box::new(|_, _| WheelSpeeds::ZERO);
    for (name, drive, _, (ahead, aside)) in sticky() {
        let run =
            World { wheels: dead_band(1e9), ..World::new(drive, &[(ahead, aside)]) }.run(30.0);
        assert_eq!(run.condition(), Some(Condition::Stuck), "{name}: {}", run.report());
        assert!(run.rests_from().is_some_and(|rest| rest <= 24.0), "{name}: {}", run.report());
    }
    let run = World { wheels: nothing, noise: (0.0, 0.0), ..World::new(rover(), &[(0.4, 0.3)]) }
        .run(30.0);
    assert!(run.condition().is_some_and(|it| matches!(it, Condition::Stuck | Condition::Frozen)));
}

/// Guards against: a robot that is blocked, whatever its speed, is believed to have a wide dead band from then on.
#[test]
fn what_is_stuck_has_no_dead_band() {
    let mut known = World::new(rover(), &[(0.4, 0.0)]);
    // Its ramp stands at every level before it is stuck.
    known.task.calibration = Some(Calibration::default());
    let blocked: Wheels = Box::new(|_, _| WheelSpeeds::ZERO);
    let settings = complete(known.settings, |_| false);
    let mut judged = 0;
    let run = World { settings, wheels: blocked, ..known }.run_with(60.0, |controller| {
        let estimate = controller.drive_estimate().expect("it is identified");
        judged = judged.max(estimate.judgements);
    });
    assert_eq!(run.condition(), Some(Condition::Stuck), "{}", run.report());
    let believed = run.controller.drive_estimate().expect("it is identified");
    assert!(judged >= 3, "{judged}: {}", run.report());
    assert_eq!(believed.dead_band, believed.dead_band_prior);
}

/// Wheels that spin on a slope at creeping speed and climb at full.
#[test]
fn a_slope_that_only_speed_climbs_is_climbed() {
    let slope: Floor = Box::new(|_, Twist { linear, angular }| {
        Twist::new(if linear.abs() < 0.07 { 0.02 * linear } else { 0.7 * linear }, angular)
    });
    let run = World { floor: slope, ..World::new(rover(), &[(1.0, 0.0)]) }.run(60.0);
    assert!(run.arrived.is_some(), "{}", run.report());
}

/// Wheels described wrongly by a factor of two to five arrive.
#[test]
fn wheels_described_wrongly_arrive() {
    for (left, right) in [(0.2, 0.2), (0.5, 0.5), (1.5, 1.5), (0.8, 1.0), (1.0, 0.7)] {
        let wheels: Wheels = Box::new(move |_, speeds| WheelSpeeds {
            left: left * speeds.left,
            right: right * speeds.right,
        });
        let run = World { wheels, ..World::new(rover(), &[(0.5, 0.0), (0.5, 0.3)]) }.run(240.0);
        assert!(run.arrived.is_some(), "{left}, {right}: {}", run.report());
    }
}

/// A skid-steered robot turns less than its track says, and sideways about a point that is not its middle.
#[test]
fn slow_skid_steer_arrives() {
    for share in [0.3, 0.4, 0.6] {
        let skid: Floor =
            Box::new(move |_, Twist { linear, angular }| Twist::new(linear, share * angular));
        let run =
            World { floor: skid, ..World::new(rover(), &[(0.5, 0.0), (0.5, 0.3)]) }.run(120.0);
        assert!(run.arrived.is_some(), "{share}: {}", run.report());
    }
}
