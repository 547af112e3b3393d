//! Every value of core that the wire allows.

use crate::{Range, robot, robot_check, square, step, task};
use proptest::prelude::*;
use proptest::sample::select;
use umwelt_core::actuation::Playing;
use umwelt_core::conjugate::NormalInverseChiSquared;
use umwelt_core::exchange::{Delivery, Observation, Request};
use umwelt_core::geometry::{Point, Pose, WheelSpeeds};
use umwelt_core::horizon::{Horizon, MAX_SLOTS, SLOT};
use umwelt_core::kinematics::{Drive, Kind, SkidSteer};
use umwelt_core::local::LocalLimits;
use umwelt_core::settings::{self, Settings};
use umwelt_core::task as core_task;
use umwelt_core::time::RobotTime;

pub(super) const MAX: u64 = robot::MAX_INTEGER;

pub(super) fn within(range: Range) -> impl Strategy<Value = f64> {
    // Both ends are allowed values, and the likeliest to be lost.
    prop_oneof![8 => range.min..=range.max, 1 => Just(range.min), 1 => Just(range.max)]
}

fn belief() -> impl Strategy<Value = NormalInverseChiSquared> {
    (within(robot::MU), within(robot::WEIGHT), within(robot::WEIGHT), within(robot::SUM_OF_SQUARES))
        .prop_map(|(mu, k, r, s)| NormalInverseChiSquared::new(mu, k, r, s).unwrap())
}

pub(super) fn prior() -> impl Strategy<Value = settings::Prior> {
    (belief(), belief(), belief(), belief()).prop_map(|(forward, lateral, turn, drift)| {
        settings::Prior { forward, lateral, turn, drift }
    })
}

fn drive() -> impl Strategy<Value = Drive> {
    (
        0.01..1.0f64,
        0.6..2.0f64,
        10.0..100.0f64,
        0.05..0.1f64,
        0.001..0.05f64,
        1.0..9.0f64,
        0.01..1.0f64,
        0.1..9.0f64,
        0.1..9.0f64,
        (within(robot::LAG), within(robot::LAG), kind()),
    )
        .prop_map(
            |(
                wheel_radius,
                track_width,
                max_wheel_speed,
                max_linear,
                min_linear,
                max_angular,
                min_angular,
                max_linear_acceleration,
                max_angular_acceleration,
                (lag, dead_time, kind),
            )| Drive {
                wheel_radius,
                unequal: 0.0,
                track_width: track_width * wheel_radius,
                max_wheel_speed,
                max_linear,
                min_linear,
                max_angular,
                min_angular,
                max_linear_acceleration,
                max_angular_acceleration,
                lag,
                dead_time,
                kind,
            },
        )
}

/// Of wheels whose fastest speed is 100 m/s at most.
fn kind() -> impl Strategy<Value = Kind> {
    let most = robot::TURN_CHANGE / 100.0;
    let skid = (-most..=most, within(robot::SIDEWAYS)).prop_map(|(turn_by_speed, sideways)| {
        Kind::SkidSteer(SkidSteer { turn_by_speed, sideways })
    });
    prop_oneof![2 => Just(Kind::Differential), 1 => skid]
}

pub(super) fn settings() -> impl Strategy<Value = Settings> {
    let attribution = select(vec![settings::Attribution::Sent, settings::Attribution::Played]);
    let watchdog = prop_oneof![Just(0.0), robot::MIN_WATCHDOG..=robot::WATCHDOG.max];
    let predictor = prop_oneof![
        Just(settings::PredictorKind::Moments),
        (1..=10_000usize, within(robot::CELL), 0..=MAX).prop_map(|(agents, cell, seed)| {
            settings::PredictorKind::MonteCarlo { agents, cell, seed }
        }),
    ];
    let noise = (within(robot::POSITION_NOISE), within(robot::HEADING_NOISE))
        .prop_map(|(position, heading)| settings::PoseNoise { position, heading });
    let variance = (within(robot::POSITION_VARIANCE), within(robot::HEADING_VARIANCE))
        .prop_map(|(position, heading)| settings::VarianceLimits { position, heading });
    let steering = (
        within(robot::ALPHA),
        within(robot::STOP_RADIUS),
        within(task::TOLERANCE),
        0.001..1.0f64,
        1.0..3.0f64,
    )
        .prop_map(|(alpha, stop_radius, tolerance, turn_tolerance, turn_beyond)| {
            settings::SteeringSettings {
                alpha,
                stop_radius,
                tolerance,
                turn_tolerance,
                turn_beyond,
            }
        });
    let prior = prior();
    let choices = (select(settings::Method::ALL.to_vec()), attribution, any::<bool>());
    let delays = (within(robot::LOOP_DELAY), within(robot::SENSOR_DELAY));
    let times = (1..=MAX_SLOTS, delays, watchdog);
    (drive(), noise, choices, times, predictor, variance, steering, prior).prop_map(
        |(
            drive,
            noise,
            (method, attribution, drift),
            (slots, (loop_delay, sensor_delay), watchdog),
            predictor,
            variance,
            steering,
            prior,
        )| Settings {
            drive,
            noise,
            method,
            prior,
            attribution,
            drift,
            slots,
            slot: SLOT,
            loop_delay,
            follows_link: settings::FollowsLink::default(),
            identifies_lag: false,
            identifies_noise: false,
            identifies_dead_band: false,
            sensor_delay,
            watchdog,
            predictor,
            variance,
            steering,
        },
    )
}

fn drawn_square() -> impl Strategy<Value = core_task::Square> {
    let side = prop::option::of(within(square::SIDE));
    (side, 1..=core_task::MAX_RUNS, within(square::SPEED_SHARE))
        .prop_map(|(side, runs, speed)| core_task::Square { side, runs, speed })
}

pub(super) fn task() -> impl Strategy<Value = core_task::Task> {
    let point =
        (within(task::COORDINATE), within(task::COORDINATE)).prop_map(|(x, y)| Point::new(x, y));
    let calibration =
        (
            0..=1000u32,
            within(task::ROTATION_SPEED),
            within(task::ROTATION_TIME),
            within(task::PAUSE),
            within(task::STRAIGHT),
        )
            .prop_map(|(rotations, angular, rotate, pause, straight)| {
                core_task::Calibration { rotations, angular, rotate, pause, straight }
            });
    let check = (
        within(robot_check::SPEED_SHARE),
        within(robot_check::REST),
        within(robot_check::MOTION),
        within(robot_check::MOTION),
        within(robot_check::PAUSE),
    )
        .prop_map(|(speed, rest, turn, drive, pause)| core_task::Check {
            speed,
            rest,
            turn,
            drive,
            pause,
        });
    (
        prop::collection::vec(point, 1..20),
        within(task::TOLERANCE),
        any::<bool>(),
        prop::option::of(calibration),
        prop::option::of(within(task::MAX_DEVIATION)),
        prop::option::weighted(0.2, check),
        prop::option::weighted(0.2, drawn_square()),
    )
        .prop_map(
            |(waypoints, tolerance, reverse, calibration, max_deviation, check, square)| {
                let square = square.filter(|_| check.is_none());
                let is_way = check.is_none() && square.is_none();
                core_task::Task {
                    waypoints: if is_way { waypoints } else { Vec::new() },
                    tolerance,
                    reverse,
                    calibration: calibration.filter(|_| is_way),
                    max_deviation,
                    check,
                    square,
                }
            },
        )
}

pub(super) fn request() -> impl Strategy<Value = Request> {
    let pose = (within(task::COORDINATE), within(task::COORDINATE), -9.0..9.0f64)
        .prop_map(|(x, y, h)| Pose::new(x, y, h));
    let poses = prop::collection::vec((pose, 0.001..1.0f64), 0..=32);
    let deliveries = prop::collection::vec((0..MAX, within(step::DELIVERY_DELAY)), 0..=16);
    let playing = prop::option::of((0..=MAX, 0.0..9.0f64));
    let limits = (any::<bool>(), prop::option::of(within(step::MAX_SPEED)));
    (1..=MAX, within(step::TIME), poses, deliveries, playing, limits).prop_map(
        |(sequence, sent, poses, deliveries, playing, (hold, max_speed))| {
            let sent = RobotTime::new(sent.max(step::TIME.min + 100.0));
            let mut taken = sent - 50.0;
            let observations = poses.into_iter().map(|(pose, later)| {
                taken += later;
                Observation { pose, taken }
            });
            Request {
                sequence,
                connection: 0,
                sent,
                observations: observations.collect(),
                deliveries: deliveries
                    .into_iter()
                    .map(|(of, loop_delay)| Delivery { sequence: of % sequence, loop_delay })
                    .collect(),
                playing: playing.map(|(horizon, ago)| Playing { horizon, since: sent - ago }),
                limits: LocalLimits { hold, max_speed },
            }
        },
    )
}

pub(super) fn horizon() -> impl Strategy<Value = Horizon> {
    let speeds = prop::collection::vec(
        (within(step::WHEEL_SPEED), within(step::WHEEL_SPEED)),
        1..=MAX_SLOTS,
    );
    (0..=MAX, 0..=MAX, within(step::TIME), within(step::SLOT), within(robot::WATCHDOG), speeds)
        .prop_map(|(sequence, answers, start, slot, watchdog, speeds)| Horizon {
            sequence,
            answers,
            start: RobotTime::new(start),
            slot,
            watchdog,
            speeds: speeds.into_iter().map(|(left, right)| WheelSpeeds { left, right }).collect(),
        })
}
