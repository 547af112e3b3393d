//! Robots whose link is not described: it is identified, and what they do follows it.

#![allow(clippy::unwrap_used)] // a test that cannot go on fails

use umwelt_core::controller::Controller;
use umwelt_core::derived::{Quantity, complete};
use umwelt_core::episode::Scenario;
use umwelt_core::exchange::{Delivery, Observation, Request};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::horizon::SLOT;
use umwelt_core::link::{LinkModel, Rtt, parse_trace};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::Task;
use umwelt_core::time::RobotTime;

const SEEDS: u64 = 4;

/// A robot of which nothing is described but its camera, on two legs with a corner between them.
fn scenario(rtt: Rtt) -> Scenario {
    let known = Settings { noise: PoseNoise::CAMERA, ..Settings::default() };
    let settings = complete(known, |_| false);
    let waypoints = vec![Point::new(0.8, 0.0), Point::new(0.8, 0.4)];
    Scenario {
        settings,
        plant: PlantModel {
            drive: settings.drive,
            slip: Slip::HARD,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(rtt) },
        task: Task { waypoints, calibration: None, ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 120.0,
    }
}

fn slowest(scenario: &Scenario) -> f64 {
    let time = |seed| {
        let outcome = scenario.run(seed).unwrap();
        assert!(outcome.arrived, "seed {seed}: {outcome:?}");
        outcome.time
    };
    (0..SEEDS).map(time).fold(0.0, f64::max)
}

/// Guards against: a loop that is slower than expected is never learned, and the robot stops and turns at every pose.
#[test]
fn a_steady_round_trip_costs_no_more_than_its_time() {
    let least = slowest(&scenario(Rtt::Constant(0.0)));
    for rtt in [0.1, 0.3, 0.5, 0.7, 1.0] {
        let time = slowest(&scenario(Rtt::Constant(rtt)));
        assert!(time <= 1.15 * least + 3.0 * rtt, "{time} s at {rtt} s, {least} s at 0");
    }
}

/// Guards against: the first replies over an unknown link teach that the floor is bad.
#[test]
fn a_slow_link_teaches_nothing_of_the_floor() {
    for rtt in [0.3, 0.7, 1.0] {
        let (_, controller) = scenario(Rtt::Constant(rtt)).run_with(1, |_| {}).unwrap();
        let estimates = controller.estimates();
        let forward = &estimates.channels[0];
        assert!(forward.samples > 20 && forward.mean.abs() < 0.03, "{rtt} s: {forward:?}");
        assert_eq!(estimates.link.late, 0, "{rtt} s");
    }
}

/// Guards against: a robot that changes to a slow route in the middle of a leg plans for the old one for ever.
#[test]
fn another_route_is_followed() {
    let change = Rtt::Trace(parse_trace("t_s,rtt_ms\n0,50\n4,400\n200,400\n").unwrap());
    let scenario = scenario(change);
    let (outcome, controller) = scenario.run_with(1, |_| {}).unwrap();
    assert!(outcome.arrived && outcome.time < 20.0, "{outcome:?}");
    let median = controller.estimates().link.median.unwrap();
    assert!((median - 0.45).abs() < 0.05, "{median}");
    assert!(controller.estimates().channels[0].mean.abs() < 0.05);
}

/// Guards against: a described delay that is overruled, or a robot of an earlier version that drives otherwise.
#[test]
fn what_is_described_is_not_followed() {
    let mut described = scenario(Rtt::Constant(0.7));
    let said =
        |quantity| matches!(quantity, Quantity::LoopDelay | Quantity::Watchdog | Quantity::Slots);
    described.settings =
        Settings { loop_delay: 0.75, slots: 67, ..complete(described.settings, said) };
    let known = slowest(&described);
    assert!(known <= slowest(&scenario(Rtt::Constant(0.7))), "{known}");
    described.settings.loop_delay = 0.23;
    let wrong = described.run(1).unwrap();
    assert!(!wrong.arrived || wrong.time > 1.5 * known, "{wrong:?} against {known} s");
}

fn request(sequence: u64, sent: f64, taken: f64) -> Request {
    let (sent, taken) = (RobotTime::new(sent), RobotTime::new(taken));
    let mut request = Request { sequence, sent, ..Request::EMPTY };
    request.observations.push(Observation { pose: Pose::default(), taken });
    request
}

/// Guards against: one packet late on the way up counts as four, with all that waited behind it on its connection.
#[test]
fn requests_that_were_overtaken_are_late_once() {
    let mut controller = Controller::new(complete(Settings::default(), |_| false));
    let mut sequence = 0;
    let step = |controller: &mut Controller, sequence: u64, deliveries: &[(u64, f64)]| {
        let sent = sequence as f64 * SLOT;
        let mut request = request(sequence, sent, sent - 0.05);
        for &(sequence, loop_delay) in deliveries {
            request.deliveries.push(Delivery { sequence, loop_delay });
        }
        controller.step(&request);
    };
    for _ in 0..60 {
        sequence += 1;
        let delivered = [(sequence - 1, 0.15)];
        step(&mut controller, sequence, if sequence > 1 { &delivered } else { &[] });
    }
    // Four wait on a stalled connection while the next one goes over a fresh one; they all come when the fifth has.
    let held: Vec<u64> = (sequence + 1..=sequence + 4).collect();
    step(&mut controller, sequence + 5, &[]);
    let mut deliveries = Vec::new();
    for &late in &held {
        let sent = late as f64 * SLOT;
        controller.late(&request(late, sent, sent - 0.05));
        // All replies arrive at the same moment.
        deliveries.push((late, (sequence + 20) as f64 * SLOT - (sent - 0.05)));
    }
    step(&mut controller, sequence + 21, &deliveries);
    assert_eq!(controller.estimates().link.late, 1);
}

/// Guards against: a camera that stamps late, whose poses are taken for newer than they are.
#[test]
fn a_sensor_delay_is_taken_off_the_stamps() {
    let settings = Settings { sensor_delay: 0.2, ..Settings::default() };
    let mut controller = Controller::new(complete(settings, |_| false));
    let mut stamped = request(1, 10.0, 9.95);
    controller.step(&stamped);
    assert!((controller.pose().unwrap().taken.seconds() - 9.75).abs() < 1e-9);
    stamped = request(2, 10.03, 9.98);
    stamped.deliveries.push(Delivery { sequence: 1, loop_delay: 0.1 });
    controller.step(&stamped);
    assert!((controller.estimates().link.median.unwrap() - 0.3).abs() < 1e-9);
}

/// Guards against: a robot that glides through its waypoint counts as there, because zero is commanded.
#[test]
fn a_robot_that_is_seen_to_glide_has_not_arrived() {
    let mut controller = Controller::new(complete(Settings::default(), |_| false));
    let task = Task { waypoints: vec![Point::new(0.0, 0.0)], calibration: None, ..Task::thesis() };
    controller.set_task(task);
    // It stands on the waypoint by its commands, and is seen to pass it at 60 mm/s for 0.3 s.
    let (mut arrived, still_from) = (None, 0.3);
    for sequence in 1..40 {
        let sent = sequence as f64 * SLOT;
        let taken: f64 = sent - SLOT;
        let mut request = request(sequence, sent, taken);
        request.observations[0].pose = Pose::new(0.06 * taken.min(still_from) - 0.009, 0.0, 0.0);
        controller.step(&request);
        if controller.has_arrived() && arrived.is_none() {
            arrived = Some(taken);
        }
    }
    let arrived = arrived.expect("it rests in the end");
    assert!(
        (still_from + 2.0 * SLOT..1.0).contains(&arrived),
        "arrived with the pose of {arrived} s"
    );
}
