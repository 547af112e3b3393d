//! Recordings of simulated robots that are driven about.

use super::*;
use crate::control::drive::DriveEstimate;
use crate::exchange::PoseNoise;
use crate::geometry::Pose;
use crate::kinematics::{Drive, inverse};
use crate::plant::{Plant, PlantModel, Slip};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;

const TRACK: f64 = 0.1;
const CAMERA: PoseNoise = PoseNoise::CAMERA;

/// How a robot is driven and recorded.
#[derive(Clone, Copy)]
struct Driven {
    /// Poses and commands per second.
    rates: [f64; 2],
    /// What each command varies by, in rad/s.
    shake: f64,
    /// Every so many poses one jumps.
    jump: u64,
    /// How far the clock of the poses is ahead in s.
    offset: f64,
    floor: &'static str,
    seed: u64,
}

const PLAIN: Driven = Driven {
    rates: [100.0, 20.0],
    shake: 0.0,
    jump: u64::MAX,
    offset: 0.0,
    floor: "hard",
    seed: 1,
};

/// A minute of a robot with a lag of 0.1 s and a dead time of 0.04 s.
fn recorded(how: Driven) -> Recording {
    let drive = Drive { lag: 0.1, dead_time: 0.04, track_width: TRACK, ..Drive::default() };
    let model = PlantModel {
        drive,
        slip: Slip::preset(how.floor).unwrap(),
        noise: CAMERA,
        ..PlantModel::default()
    };
    let mut plant = Plant::new(model, Pose::default(), how.seed).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(how.seed);
    let mut recording = Recording::default();
    let (mut wanted, mut until, mut sent) = (Twist::ZERO, 1.0, Twist::ZERO);
    let (mut next_pose, mut next_command, mut taken) = (0.0, 0.0, 0_u64);
    while plant.time() < 60.0 {
        let time = plant.time();
        if time >= next_pose {
            // Never the same time between two.
            next_pose += random.random_range(0.7..1.3) / how.rates[0];
            taken += 1;
            let mut pose = plant.observe();
            if taken.is_multiple_of(how.jump) {
                pose = Pose::new(pose.x + 0.3, pose.y, pose.heading.radians() + 0.3);
            }
            recording.poses.push(Observation { pose, taken: RobotTime::new(time + how.offset) });
        }
        if time >= next_command {
            next_command += 1.0 / how.rates[1];
            if time >= until {
                until = time + random.random_range(0.5..2.5);
                let angular = random.random_range(-1.2..1.2);
                wanted = [Twist::ZERO, Twist::new(0.0, angular), Twist::new(0.08, angular)]
                    [random.random_range(0..3)];
            }
            let mut shaken = || how.shake * random.sample::<f64, _>(StandardNormal);
            let is_rest = wanted == Twist::ZERO;
            let shaken = Twist::new(0.1 * shaken(), shaken());
            sent = Twist::new(wanted.linear + shaken.linear, wanted.angular + shaken.angular);
            sent = if is_rest { Twist::ZERO } else { sent };
            recording.commands.push((RobotTime::new(time), sent));
        }
        plant.advance(inverse(&drive, sent), next_pose.min(next_command) - time);
    }
    recording
}

fn identified(mut recording: Recording) -> Identified {
    recording.leave_out_jumps(CAMERA);
    recording.identify(CAMERA, TRACK, 0.26, |_| ())
}

fn estimate(how: Driven) -> DriveEstimate {
    identified(recorded(how)).belief.estimate()
}

/// Guards against: a drive that is not known to what control needs after a minute, or not worth knowing.
#[test]
fn a_recorded_minute_tells_dead_time_and_lag_and_that_predicts_the_heading() {
    for rate in [100.0, 10.0] {
        for seed in 1..6 {
            let found = identified(recorded(Driven { rates: [rate, 20.0], seed, ..PLAIN }));
            let it = found.belief.estimate();
            let off = (it.sum.mean - 0.14).abs();
            assert!(off < 0.003 && (it.lag.mean - 0.1).abs() < 0.01, "{rate} {seed}: {it:?}");
            let errors = found.comparison.unwrap();
            let (ours, theirs) = (errors.identified.heading.p90, errors.at_once.heading.p90);
            assert!(ours < 0.55 * theirs, "{rate} {seed}: {ours} {theirs}");
            let (ours, theirs) = (errors.identified.position.p90, errors.at_once.position.p90);
            assert!(ours < 0.8 * theirs, "{rate} {seed}: {ours} {theirs}");
            assert!((errors.identified.ahead - 0.26).abs() < 0.5 / rate);
        }
    }
}

/// Guards against: a recording as they are is not understood, or settles beside the truth.
#[test]
fn slip_jumps_commands_that_shake_and_clocks_that_differ_are_no_delay() {
    let messy = Driven { rates: [100.0, 70.0], shake: 0.05, jump: 200, floor: "dusty", ..PLAIN };
    for seed in 1..6 {
        for offset in [0.0, 0.3, -0.03] {
            let it = estimate(Driven { offset, seed, ..messy });
            let off = it.sum.mean - (0.14 + offset);
            assert!(off.abs() < 0.01, "{seed} {offset}: {it:?}");
            assert_eq!(it.not_understood, 0);
        }
    }
}

#[test]
fn poses_before_their_commands_are_noticed() {
    let found = identified(recorded(Driven { offset: -0.3, ..PLAIN }));
    assert!((found.rough.unwrap() + 0.16).abs() <= 0.02, "{:?}", found.rough);
}

/// Guards against: a start or a fast turn between two poses is taken for a jump.
#[test]
fn poses_that_jump_there_and_back_are_left_out_and_no_others() {
    for rate in [100.0, 10.0] {
        let mut smooth = recorded(Driven { rates: [rate, 20.0], ..PLAIN });
        assert_eq!(smooth.leave_out_jumps(CAMERA), 0);
        let mut jumping = recorded(Driven { rates: [rate, 20.0], jump: 50, ..PLAIN });
        let jumps = jumping.poses.len() / 50;
        assert_eq!(jumping.leave_out_jumps(CAMERA), jumps);
    }
}

/// The naive way: everything from the first command on, for every pair of poses anew.
#[test]
fn errors_ahead_are_those_of_poses_predicted_one_by_one() {
    let recording = recorded(Driven { rates: [10.0, 20.0], ..PLAIN });
    let followed = Followed { dead_time: 0.05, lag: 0.0, forward: 0.9, turn: 1.1, drift: 0.2 };
    let from = RobotTime::new(50.0);
    let errors = recording.errors_ahead(&followed, from, 0.3).unwrap();
    let in_force = |time: f64| {
        let last = recording.commands.iter().rev().find(|it| it.0.seconds() <= time);
        last.map_or(Twist::ZERO, |(_, twist)| *twist)
    };
    let poses = &recording.poses;
    let (mut headings, mut moving) = (Vec::new(), 0);
    for pose in poses.iter().filter(|pose| pose.taken >= from) {
        let off = |it: &&Observation| (it.taken - (pose.taken + 0.3)).abs();
        let later = poses.iter().min_by(|one, other| off(one).total_cmp(&off(other))).unwrap();
        if off(&later) > recording.interval().unwrap() / 2.0 {
            continue;
        }
        let (mut turned, mut moved) = (0.0, false);
        let start = pose.taken.seconds();
        let steps = ((later.taken - pose.taken) / 1e-4).round() as u32;
        for step in 0..steps {
            let twist = in_force(start + (f64::from(step) + 0.5) * 1e-4 - 0.05);
            turned += (1.1 * twist.angular + 0.2 * twist.linear) * 1e-4;
        }
        for step in 0..600 + (steps / 10) {
            moved |= in_force(start - LONGEST + f64::from(step) * 1e-3) != Twist::ZERO;
        }
        if moved {
            moving += 1;
            headings.push((later.pose.heading.minus(pose.pose.heading + turned)).abs());
        }
    }
    headings.sort_by(f64::total_cmp);
    assert!(errors.poses.abs_diff(moving) <= 2, "{} {moving}", errors.poses);
    let p90 = headings[headings.len() * 9 / 10];
    assert!((errors.heading.p90 - p90).abs() < 0.002, "{} {p90}", errors.heading.p90);
}

#[test]
fn a_gap_and_rest_end_a_stretch() {
    let mut recording = recorded(PLAIN);
    recording.poses.retain(|pose| !(20.0..22.0).contains(&pose.taken.seconds()));
    for (stretch, commanded) in recording.stretches() {
        let (first, last) = stretch.ends().unwrap();
        assert!(last.taken - first.taken <= MAX_SPAN && commanded.moves());
        assert!(stretch.poses.windows(2).all(|it| {
            let apart = it[1].taken - it[0].taken;
            (APART - JITTER..=GAP).contains(&apart)
        }));
    }
}

#[test]
fn a_recording_without_anything_in_common_says_nothing() {
    let mut recording = recorded(PLAIN);
    recording.poses.iter_mut().for_each(|pose| pose.taken += 1000.0);
    recording.commands.last_mut().unwrap().1 = Twist::new(0.1, 0.0);
    assert_eq!(recording.known(), None);
    let found = identified(recording);
    assert_eq!((found.belief.estimate().stretches, found.comparison), (0, None));
    let nothing = Recording::default();
    assert_eq!((nothing.known(), nothing.interval()), (None, None));
    assert_eq!(identified(nothing).belief.estimate().stretches, 0);
}
