//! Robots whose wheels or track are not as described: they move as they should once that is identified.

#![allow(clippy::unwrap_used)] // a test that cannot go on fails

use umwelt_core::controller::Controller;
use umwelt_core::derived::complete;
use umwelt_core::drive::ScaleEstimate;
use umwelt_core::episode::{Outcome, Scenario};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip, SlipChannel};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

const SEEDS: u64 = 5;

/// A robot with this drive, described as that of the thesis, which calibrates and drives two legs.
fn scenario(drive: Drive) -> Scenario {
    let known = Settings {
        noise: PoseNoise::CAMERA,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let waypoints = vec![Point::new(1.8, 0.0), Point::new(1.8, 0.4)];
    let drive = Drive { lag: 0.1, dead_time: 0.03, ..drive };
    Scenario {
        settings: complete(known, |_| false),
        plant: PlantModel {
            drive,
            slip: Slip::HARD,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
        task: Task { waypoints, calibration: Some(Calibration::default()), ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 120.0,
    }
}

fn runs(scenario: &Scenario) -> Vec<(Outcome, Controller)> {
    let runs: Vec<_> = (0..SEEDS).map(|seed| scenario.run_with(seed, |_| {}).unwrap()).collect();
    assert!(runs.iter().all(|(outcome, _)| outcome.arrived));
    runs
}

/// Mean time in s and mean of the largest deviations in m.
fn cost(runs: &[(Outcome, Controller)]) -> (f64, f64) {
    let mean = |of: fn(&Outcome) -> f64| {
        runs.iter().map(|(outcome, _)| of(outcome)).sum::<f64>() / runs.len() as f64
    };
    (mean(|it| it.time), mean(|it| it.max_deviation))
}

/// Guards against: wheels or a track that are told wrong cost time or accuracy once the robot has calibrated.
#[test]
fn a_calibrated_robot_drives_as_if_its_wheels_had_been_told() {
    let described = Drive::default();
    let told = cost(&runs(&scenario(described)));
    for drive in [
        Drive { wheel_radius: 0.024, ..described },
        Drive { wheel_radius: 0.036, ..described },
        Drive { wheel_radius: 0.06, ..described },
        Drive { track_width: 0.103, ..described },
        Drive { unequal: 0.02, ..described },
        Drive { wheel_radius: 0.024, track_width: 0.103, unequal: -0.02, ..described },
    ] {
        let runs = runs(&scenario(drive));
        let (time, deviation) = cost(&runs);
        assert!(
            time < 1.05 * told.0 && deviation < 1.5 * told.1 + 0.001,
            "{drive:?}: {time} s, {deviation} m, told {told:?}"
        );
        for (_, controller) in &runs {
            // The hard floor has 0.4 % and 1 % of its own.
            let [forward, turn, drift] =
                controller.drive_estimate().unwrap().scale.map(|it| it.together.mean);
            let of_radius = drive.wheel_radius / described.wheel_radius;
            let of_turn = of_radius * described.track_width / drive.track_width;
            assert!(
                (forward / (1.004 * of_radius - 1.0) - 1.0).abs() < 0.1 || forward.abs() < 0.01
            );
            assert!((1.0 + turn - 1.01 * of_turn).abs() < 0.01 * of_turn, "{drive:?}: {turn}");
            assert!((drift * drive.track_width / of_radius - drive.unequal).abs() < 0.002);
        }
    }
}

/// Guards against: wheels twice as large as told drive a robot at twice the speed that it may have.
#[test]
fn the_largest_speed_is_what_the_robot_does() {
    let scenario = scenario(Drive { wheel_radius: 0.06, ..Drive::default() });
    let (_, rows) = scenario.trace(1).unwrap();
    let driving = rows.iter().filter(|row| row.stage == umwelt_core::task::Stage::Driving);
    let rows: Vec<_> = driving.filter(|row| row.leg == 0).collect();
    let fastest = rows.windows(40).map(|it| {
        let (from, to) = (it[0], it[39]);
        from.pose.point().distance(to.pose.point()) / (to.time - from.time)
    });
    let fastest = fastest.fold(0.0, f64::max);
    assert!((0.12..0.135).contains(&fastest), "{fastest} m/s");
}

/// Drives one task on each of these floors, the environment being reset between them; what is believed of forward motion
/// at the end of each.
fn over_floors(drive: Drive, floors: &[f64]) -> Vec<ScaleEstimate> {
    let mut controller: Option<Controller> = None;
    floors
        .iter()
        .map(|&forward| {
            let mut scenario = scenario(drive);
            let forward = SlipChannel::new(forward, 0.01).unwrap();
            scenario.plant.slip = Slip { forward, ..Slip::NONE };
            scenario.task.calibration = None;
            let mut next = controller.take().unwrap_or_else(|| Controller::new(scenario.settings));
            next.restart_clock();
            if next.drive_estimate().unwrap().stretches > 0 {
                next.reset_belief();
            }
            let (_, after) = scenario.drive(next, 1, |_, _| {}).unwrap();
            let estimate = after.drive_estimate().unwrap().scale[0];
            controller = Some(after);
            estimate
        })
        .collect()
}

/// Guards against: a floor is taken for the robot's wheels, or a split is shown that no one can know.
#[test]
fn wheels_and_floor_part_on_the_second_floor() {
    let small = Drive { wheel_radius: 0.95 * 0.03, ..Drive::default() };
    let wheels = over_floors(small, &[0.0, 0.0]);
    let floor = over_floors(Drive::default(), &[-0.05, 0.0]);
    for first in [wheels[0], floor[0]] {
        assert!((first.together.mean + 0.05).abs() < 0.003, "{first:?}");
        let (low, high) = first.robot.interval;
        assert!(low < -0.05 && high > 0.0, "either may be all of it: {first:?}");
    }
    assert!((wheels[0].robot.mean - floor[0].robot.mean).abs() < 0.003);
    let [wheels, floor] = [wheels[1], floor[1]];
    assert!((wheels.together.mean + 0.05).abs() < 0.003 && floor.together.mean.abs() < 0.003);
    assert!(wheels.robot.mean < -0.037 && wheels.floor.mean > -0.013, "{wheels:?}");
    assert!(floor.robot.mean > -0.025 && floor.robot.sd < 0.045, "{floor:?}");
}

/// Guards against: what was accepted into the description is corrected a second time.
#[test]
fn an_accepted_scale_is_described_from_then_on() {
    let scenario = scenario(Drive { wheel_radius: 0.024, ..Drive::default() });
    let (_, mut controller) = scenario.run_with(1, |_| {}).unwrap();
    let before = controller.drive_estimate().unwrap();
    let accepted = 1.0 + before.scale[0].together.mean;
    let drive = scenario.settings.drive;
    let drive = Drive { wheel_radius: drive.wheel_radius * accepted, ..drive };
    controller.replace_settings(Settings { drive, ..scenario.settings });
    let after = controller.drive_estimate().unwrap();
    assert!(after.scale[0].together.mean.abs() < 1e-9 && after.sum == before.sum);
    let turn = (1.0 + before.scale[1].together.mean) / accepted - 1.0;
    assert!((after.scale[1].together.mean - turn).abs() < 1e-9);
}

/// Guards against: other wheels are mounted and described, and what was known of the old ones drives the robot at twice its
/// speed.
#[test]
fn what_is_known_of_wheels_goes_with_them() {
    let scenario = scenario(Drive::default());
    let (_, mut controller) = scenario.run_with(1, |_| {}).unwrap();
    let before = controller.drive_estimate().unwrap();
    let drive = Drive { wheel_radius: 0.06, ..scenario.settings.drive };
    controller.replace_settings(Settings { drive, ..scenario.settings });
    let after = controller.drive_estimate().unwrap();
    assert_eq!((after.scale[0].together.mean, after.sum), (0.0, before.sum));
    assert!(after.scale[0].together.sd > 0.1);
    // The largest speed alone is another matter.
    let drive = Drive { max_linear: 0.1, ..drive };
    controller.replace_settings(Settings { drive, ..scenario.settings });
    assert_eq!(controller.drive_estimate().unwrap(), after);
}
