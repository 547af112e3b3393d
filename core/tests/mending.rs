//! A waypoint that was missed by a centimetre or two is mended by reversing or by a turn of a quarter at most.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use umwelt_core::episode::{Outcome, Scenario, TIME_LIMIT};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::Task;

/// What a robot did whose waypoint lies at this bearing, so far from where it rests.
struct Run {
    outcome: Outcome,
    /// How far in rad it turned in all.
    turned: f64,
    /// Its largest distance in m from where it stood.
    strayed: f64,
}

fn run(method: Method, slip: Slip, bearing: f64, distance: f64, seed: u64) -> Run {
    let drive = Drive { lag: 0.08, dead_time: 0.04, ..Drive::default() };
    let (noise, attribution) = (PoseNoise::CAMERA, Attribution::Played);
    let settings = Settings { drive, noise, method, attribution, ..Settings::default() };
    let waypoint = Point::new(distance * bearing.cos(), distance * bearing.sin());
    let scenario = Scenario {
        settings,
        plant: PlantModel { drive, slip, noise, ..PlantModel::default() },
        link: LinkModel::preset("normal").expect("a preset"),
        task: Task { waypoints: vec![waypoint], calibration: None, ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: TIME_LIMIT,
    };
    let (mut before, mut turned, mut strayed) = (Pose::default(), 0.0, 0.0_f64);
    let (outcome, _) = scenario
        .run_with(seed, |row| {
            turned += row.pose.heading.minus(before.heading).abs();
            strayed = strayed.max(row.pose.point().distance(Point::default()));
            before = row.pose;
        })
        .expect("a valid scenario");
    Run { outcome, turned, strayed }
}

/// The median of `of` over runs of either method, adaptive first.
fn medians(bearing: f64, distance: f64, of: fn(&Run) -> f64) -> [f64; 2] {
    [Method::Adaptive, Method::Bayesian].map(|method| {
        let of = |seed| of(&run(method, Slip::DUSTY, bearing, distance, seed));
        let mut values: Vec<f64> = (0..21).map(of).collect();
        values.sort_by(f64::total_cmp);
        values[10]
    })
}

/// Guards against: half a turn toward a waypoint that lies behind, which takes 2.5 s.
#[test]
fn what_lies_behind_is_reversed_to() {
    for bearing in [PI, PI - 0.2, -PI + 0.2] {
        for distance in [0.013, 0.02] {
            let [turned, before] = medians(bearing, distance, |run| run.turned);
            assert!(turned < 0.7 && before > 2.5, "{bearing}: {turned} rad, {before} rad");
            let [time, before] = medians(bearing, distance, |run| run.outcome.time);
            assert!(time < 0.5 * before, "{bearing}: {time} s, {before} s");
        }
    }
}

/// Guards against: a turn to the far side of what lies beside, or further than it takes to come within the tolerance.
#[test]
fn what_lies_beside_takes_less_than_a_quarter_turn() {
    for bearing in [FRAC_PI_2 + 0.4, -FRAC_PI_2 - 0.4] {
        let [turned, before] = medians(bearing, 0.018, |run| run.turned);
        assert!(turned < 1.35 && before > 1.8, "{bearing}: {turned} rad, {before} rad");
        let [time, before] = medians(bearing, 0.018, |run| run.outcome.time);
        assert!(time < 0.9 * before, "{bearing}: {time} s, {before} s");
    }
    let [turned, _] = medians(FRAC_PI_2, 0.018, |run| run.turned);
    assert!(turned < 1.65, "{turned} rad");
}

/// Guards against: a robot that goes to and fro about its waypoint, or far away to come back.
#[test]
fn it_arrives_from_everywhere_around_and_stays_near() {
    for (floor, slip) in [Slip::HARD, Slip::SLIPPERY].into_iter().enumerate() {
        for place in 0..60_u32 {
            let bearing = TAU * f64::from(place) / 60.0 - PI;
            let distance = 0.011 + 0.0025 * f64::from(place % 10);
            let run = run(Method::Adaptive, slip, bearing, distance, u64::from(place));
            assert!(
                run.outcome.arrived && run.outcome.time < 5.0,
                "{floor} {bearing}: {:?}",
                run.outcome
            );
            assert!(run.strayed < distance + 0.01, "{floor} {bearing}: {} m", run.strayed);
        }
    }
}

/// Guards against: a robot that drives a leg in reverse because its waypoint lies behind.
#[test]
fn a_leg_is_not_reversed() {
    let far = run(Method::Adaptive, Slip::HARD, PI, 0.3, 1);
    assert!(far.outcome.arrived && far.turned > 2.5, "{} rad", far.turned);
}
