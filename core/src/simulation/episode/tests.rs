use super::*;
use crate::geometry::Twist;
use crate::identification::estimate::{Channel, Estimates};
use crate::kinematics;
use crate::link::{LatePackets, Outage, PRESETS, Rtt};
use crate::plant::Slip;
use crate::settings::{Attribution, Method, PoseNoise, PredictorKind};

/// The thesis's round trip with a real camera on `floor`, `slots` per horizon.
fn scenario(link: LinkModel, floor: Slip, slots: usize) -> Scenario {
    let settings = Settings { slots, noise: PoseNoise::CAMERA, ..Settings::default() };
    Scenario {
        settings,
        plant: PlantModel {
            drive: settings.drive,
            slip: floor,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        },
        link,
        task: Task::thesis(),
        start: Pose::default(),
        region: None,
        frame: crate::episode::FRAME,
        time_limit: TIME_LIMIT,
    }
}

fn preset(name: &str) -> LinkModel {
    LinkModel::preset(name).expect("a preset")
}

fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

/// Times and deviations of `runs` seeds; every robot must arrive.
fn drive(scenario: &Scenario, runs: u64) -> (Vec<f64>, Vec<f64>) {
    (0..runs)
        .map(|seed| {
            let outcome = scenario.run(seed).expect("a valid scenario");
            assert!(outcome.arrived, "seed {seed}: {outcome:?}");
            (outcome.time, outcome.max_deviation)
        })
        .unzip()
}

#[test]
fn every_method_arrives_over_every_link_on_every_floor() {
    for method in Method::ALL {
        for link in PRESETS {
            for (floor, slots) in [(Slip::NONE, 1), (Slip::SLIPPERY, 1), (Slip::DUSTY, 20)] {
                let mut scenario = scenario(preset(link), floor, slots);
                scenario.settings.method = method;
                drive(&scenario, 2);
            }
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_episode_bit_for_bit() {
    let scenario = scenario(preset("bad"), Slip::SLIPPERY, 20);
    assert_eq!(scenario.trace(5), scenario.trace(5));
    assert_ne!(scenario.run(5), scenario.run(6));
}

/// What the horizon is for: 400 ms stalls cost one slot per reply dearly and twenty next to nothing.
///
/// 1000 paired seeds; the limits are 5 % in time, and for the deviation half a millimetre above 1.5 times the clean link's,
/// for the sampling error of a 90 % quantile.
#[test]
fn a_horizon_makes_the_bad_link_nearly_as_good_as_the_clean_one() {
    let run = |link, slots| drive(&scenario(preset(link), Slip::HARD, slots), 1000);
    let (clean_times, clean_deviations) = run("clean", 20);
    let (times, deviations) = run("bad", 20);
    let (thesis_times, thesis_deviations) = run("bad", 1);
    assert!(quantile(times.clone(), 0.5) < 1.05 * quantile(clean_times, 0.5));
    let clean = quantile(clean_deviations, 0.9);
    assert!(quantile(deviations.clone(), 0.9) < 1.5 * clean + 0.0005);
    assert!(quantile(thesis_times, 0.5) > 1.2 * quantile(times, 0.5));
    assert!(quantile(thesis_deviations, 0.5) > 5.0 * quantile(deviations, 0.5));
}

/// The robot stops by itself within the acceleration limit, stays, goes on and arrives; speeds keep every limit.
#[test]
fn twenty_seconds_of_outage_in_the_middle_of_a_leg() {
    // The task begins at 17.6 s; at 25 s the robot is on its long leg.
    let outage = Outage { start: 25.0, duration: 20.0 };
    let link = LinkModel { outages: vec![outage], ..preset("normal") };
    let scenario = scenario(link, Slip::HARD, 20);
    let drive = scenario.settings.drive;
    let (outcome, rows) = scenario.trace(3).expect("a valid scenario");
    assert!(outcome.arrived && outcome.time > 20.0, "{outcome:?}");
    let moves = |row: &TraceRow| kinematics::forward(&drive, row.applied) != Twist::ZERO;
    let at = |time: f64| rows.iter().rfind(|row| row.time <= time).expect("a row");
    assert!(at(24.9).applied.left > 3.0, "it drives when the link goes");
    // Horizon 0.6 s and loop delay, watchdog 0.3 s, ramp 0.13/0.3 s.
    assert!(rows.iter().filter(|row| (27.0..45.0).contains(&row.time)).all(|row| !moves(row)));
    assert!(rows.iter().any(|row| row.time > 45.0 && moves(row)), "it goes on");
    for pair in rows.windows(2) {
        let [before, after] = [&pair[0], &pair[1]].map(|r| kinematics::forward(&drive, r.applied));
        assert!(after.linear.abs() <= drive.max_linear + 1e-9);
        assert!(after.angular.abs() <= drive.max_angular + 1e-9);
        let wheel = pair[1].applied.left.abs().max(pair[1].applied.right.abs());
        assert!(wheel <= drive.max_wheel_speed + 1e-9);
        // One slot's worth of acceleration may come at once, as in any stepped command.
        let allowed = pair[1].time - pair[0].time + SLOT;
        assert!(drive.change_time(before, after) <= allowed + 1e-6, "{pair:?}");
    }
    // Over any tenth of a second the speed changes by what the limit allows in it, and a slot.
    for (i, row) in rows.iter().enumerate() {
        let Some(later) = rows[i..].iter().find(|later| later.time >= row.time + 0.1) else {
            break;
        };
        let [before, after] = [row, later].map(|row| kinematics::forward(&drive, row.applied));
        let allowed = later.time - row.time + SLOT;
        assert!(drive.change_time(before, after) <= allowed + 1e-6, "{row:?} {later:?}");
    }
}

/// The environment as identified at the end.
fn identified(scenario: &Scenario, seed: u64) -> Estimates {
    scenario.run_with(seed, |_| {}).expect("valid").1.estimates()
}

/// Measured against the commands as sent, a late packet is a control error; as played, it is not.
#[test]
fn as_played_the_link_does_not_look_like_the_floor() {
    let sd = |attribution, link| {
        let mut scenario = scenario(preset(link), Slip::HARD, 1);
        scenario.settings.attribution = attribution;
        let sds = (0..20).map(|seed| {
            let environment = identified(&scenario, seed);
            environment.channels[Channel::Turn as usize].sd.expect("many samples")
        });
        quantile(sds.collect(), 0.5)
    };
    let (normal, bad) = (sd(Attribution::Sent, "normal"), sd(Attribution::Sent, "bad"));
    assert!(bad > 2.0 * normal, "as sent: {bad} against {normal}");
    let (normal, bad) = (sd(Attribution::Played, "normal"), sd(Attribution::Played, "bad"));
    assert!(bad < 1.5 * normal, "as played: {bad} against {normal}");
}

/// The floor is identified: forward slip of -20 % +- the width of what 20 round trips say.
#[test]
fn a_slippery_floor_is_identified() {
    let floor = Slip::OILY;
    let scenario = scenario(preset("normal"), floor, 20);
    let means: Vec<f64> =
        (0..20).map(|seed| identified(&scenario, seed).channels[0].mean).collect();
    let mean = quantile(means, 0.5);
    assert!((mean - floor.forward.mean()).abs() < 0.05, "{mean} for {}", floor.forward.mean());
}

#[test]
fn the_link_is_identified() {
    let link = LinkModel {
        late: LatePackets::independent(0.05),
        ..LinkModel::ordinary(Rtt::Constant(0.04))
    };
    let estimate = identified(&scenario(link, Slip::HARD, 20), 2).link;
    // That of the last second: where a packet was late, those after it waited for their turn.
    assert!((estimate.median.expect("seen") - 0.17).abs() < 0.03, "{estimate:?}");
    // One packet in twenty of some 800: 4 sd are 3 %.
    assert!((0.02..0.08).contains(&estimate.late_probability), "{estimate:?}");
    assert!(estimate.chance_of_luck < 1e-6);
}

/// Monte Carlo, the thesis's predictor, drives the same robot: a few hundred agents are its sampling error away.
#[test]
fn monte_carlo_drives_like_the_moments() {
    let moments = scenario(preset("normal"), Slip::HARD, 1);
    let mut agents = moments.clone();
    agents.settings.predictor = PredictorKind::MonteCarlo { agents: 300, cell: 0.0005, seed: 1 };
    let (times, _) = drive(&moments, 4);
    let (agent_times, _) = drive(&agents, 4);
    let ratio = quantile(agent_times, 0.5) / quantile(times, 0.5);
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
}

#[test]
fn lag_that_is_known_costs_little() {
    let mut scenario = scenario(preset("normal"), Slip::HARD, 20);
    scenario.settings.drive.lag = 0.1;
    scenario.settings.drive.dead_time = 0.05;
    scenario.plant.drive = scenario.settings.drive;
    let (times, deviations) = drive(&scenario, 20);
    assert!(quantile(times, 0.5) < 14.0);
    assert!(quantile(deviations, 0.9) < 0.010);
}

#[test]
fn what_means_nothing_is_refused() {
    let mut wrong = scenario(preset("bad"), Slip::NONE, 1);
    wrong.plant.noise.position = f64::NAN;
    assert!(matches!(wrong.run(1), Err(EpisodeError::Plant(_))));
    let mut wrong = scenario(preset("bad"), Slip::NONE, 1);
    wrong.link.sensor_delay = -1.0;
    assert!(matches!(wrong.run(1), Err(EpisodeError::Link(_))));
}

/// A region that is everywhere is the room, one that is nowhere is nothing, one in between is neither.
#[test]
fn floor_and_link_change_where_the_region_is() {
    let bad = LinkModel::preset("bad").expect("a preset");
    let plain = scenario(LinkModel::preset("normal").expect("a preset"), Slip::HARD, 1);
    let changed = scenario(bad.clone(), Slip::SLIPPERY, 1);
    let with = |from, to| {
        let region = Some(Region { from, to, slip: Slip::SLIPPERY, link: bad.clone() });
        Scenario { region, ..plain.clone() }.run(4).expect("a valid scenario")
    };
    let [plain_run, changed_run] = [&plain, &changed].map(|it| it.run(4).expect("valid"));
    assert_eq!(with(-9.0, 9.0), changed_run);
    assert_eq!(with(5.0, 9.0), plain_run);
    let between = with(-0.3, -0.1);
    assert!(between != plain_run && between != changed_run);
    assert_ne!(with(-0.9, -0.1), between, "it is left again");
}
