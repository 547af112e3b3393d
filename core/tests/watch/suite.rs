//! What is commanded and not seen ends in rest and a named state: robots of several sizes, cameras of several rates, and
//! what goes wrong with them.

mod frames;
mod harness;
mod other;
mod slow;

use harness::{Run, World, amr, burger, mini, rover};
use umwelt_core::geometry::{Pose, Twist, WheelSpeeds};
use umwelt_core::kinematics::Drive;
use umwelt_core::watch::Condition;

/// Robots with a long way to go, each with its full speed in m/s and its stopping time in s.
fn robots() -> [(&'static str, Drive, f64); 4] {
    [
        ("rover", rover(), 2.5),
        ("burger", burger(), 4.0),
        ("mini", mini(), 1.5),
        ("amr", amr(), 40.0),
    ]
}

/// Latest time in s from the onset to the beginning of the ramp to rest.
const LATEST: f64 = 1.5;

fn stopping_time(drive: &Drive) -> f64 {
    drive.stopping_time(Twist::new(drive.max_linear, 0.0))
}

/// Wheels that do not turn from `onset` s on.
fn blocked(onset: f64) -> harness::Wheels {
    Box::new(move |t, speeds| if t >= onset { WheelSpeeds::ZERO } else { speeds })
}

/// Wheels that stand below `band` rad/s.
fn dead_band(band: f64) -> harness::Wheels {
    let wheel = move |speed: f64| if speed.abs() < band { 0.0 } else { speed };
    Box::new(move |_, speeds| WheelSpeeds { left: wheel(speeds.left), right: wheel(speeds.right) })
}

fn assert_rests(run: &Run, condition: &[Condition], onset: f64, within: f64, what: &str) {
    let found = run.condition();
    assert!(found.is_some_and(|found| condition.contains(&found)), "{what}: {}", run.report());
    let rest = run.rests_from().unwrap_or(f64::INFINITY);
    assert!(rest <= onset + within, "{what}: rest at {rest} s: {}", run.report());
    assert_eq!(run.controller.progress().watch, found, "{what}");
}

#[test]
fn blocked_wheels_end_in_rest() {
    for (name, drive, far) in robots() {
        for rate in [10.0, 30.0, 100.0] {
            let onset = 5.0;
            let run = World { rate, wheels: blocked(onset), ..World::new(drive, &[(far, 0.0)]) }
                .run(12.0);
            // What the ramp takes of a fast robot cannot be shorter.
            let within = 2.0_f64.max(LATEST + stopping_time(&drive));
            assert_rests(&run, &[Condition::Stuck], onset, within, &format!("{name} at {rate} Hz"));
        }
    }
}

#[test]
fn a_frozen_tracker_ends_in_rest() {
    for (name, drive, far) in robots() {
        for (rate, noise) in [(10.0, 0.0005), (30.0, 0.0005), (30.0, 0.0), (200.0, 0.0005)] {
            let onset = 5.0;
            let mut held: Option<Pose> = None;
            let show: harness::Show = Box::new(move |_, t, pose| {
                Some(if t >= onset { *held.get_or_insert(pose) } else { pose })
            });
            let noise = (noise, 6.0 * noise);
            let run = World { rate, noise, show, ..World::new(drive, &[(far, 0.0)]) }.run(12.0);
            let within = 2.0_f64.max(LATEST + stopping_time(&drive));
            let what = format!("{name} at {rate} Hz, noise {noise:?}");
            assert_rests(&run, &[Condition::Frozen], onset, within, &what);
        }
    }
}
