//! The contract has its own defaults and limits, so that who speaks it needs no core. They are core's.

use crate::{environment, prior, robot, step, task, training};
use umwelt_core::derived;
use umwelt_core::identification::{BUILT_IN_PRIORS, estimate};
use umwelt_core::settings::{self, Settings};
use umwelt_core::{exchange, horizon, kinematics, link, plant, task as core_task};

#[test]
fn what_is_left_out_is_the_same_on_the_wire_and_in_core() {
    let new = Settings {
        noise: settings::PoseNoise::CAMERA,
        method: settings::Method::Adaptive,
        attribution: settings::Attribution::Played,
        slots: 40,
        ..Settings::default()
    };
    let core = robot::Spec::from_core(&new, Some(robot::DEFAULT_PRIOR));
    assert_eq!(robot::Spec::default(), core);
    assert_eq!(robot::Drive::default(), kinematics::Drive::default().into());
    assert_eq!(robot::Noise::default(), settings::PoseNoise::CAMERA.into());
    assert_eq!(robot::Prior::default(), settings::Prior::default().into());
    assert_eq!(task::Calibration::default(), core_task::Calibration::default().into());
    assert_eq!(task::DEFAULT_TOLERANCE, core_task::TOLERANCE);
    assert_eq!(training::LatePackets::default().extra_s, link::LATE_EXTRA);
    assert_eq!(training::Silences::default(), link::Silences::NONE.into());
    let rtt = br#"{"slip": "none", "link": {"rtt": {"kind": "constant", "rtt_s": 0.1}}}"#;
    let ordinary = training::Spec::read(rtt).unwrap().to_link();
    assert_eq!(ordinary, link::LinkModel::ordinary(link::Rtt::Constant(0.1)));
}

#[test]
fn the_fields_that_follow_from_others_are_those_of_core() {
    assert_eq!(derived::Quantity::ALL.map(super::robot::path), robot::DERIVED);
}

#[test]
fn limits_and_names_are_the_same_on_the_wire_and_in_core() {
    assert_eq!(robot::MAX_SLOTS, horizon::MAX_SLOTS);
    assert_eq!(step::MAX_OBSERVATIONS, exchange::MAX_OBSERVATIONS);
    assert_eq!(step::MAX_DELIVERIES, exchange::MAX_DELIVERIES);
    assert_eq!(task::MAX_WAYPOINTS, core_task::MAX_WAYPOINTS);
    assert_eq!(training::MAX_OUTAGES, link::MAX_OUTAGES);
    assert_eq!(training::DELAY.max, link::LONGEST_DELAY);
    assert_eq!(training::SLIP_SD.max, plant::MAX_SLIP_SD);
    assert_eq!(training::SILENCE_RATE.max, 0.5 / horizon::SLOT);
    assert_eq!((training::FLOORS, training::LINKS), (plant::SLIP_PRESETS, link::PRESETS));
    assert_eq!(environment::LEVEL, estimate::LEVEL);
    assert!(BUILT_IN_PRIORS.into_iter().all(|name| prior::built_in(name).is_ok()));
}
