//! A simulated minute and a real minute agree.

use crate::ARRIVAL;
use umwelt_agent::TraceRow;
use umwelt_api::robot::{Description, Spec};
use umwelt_api::task::Stage;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::horizon::SLOT;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::Task;
use umwelt_tests::rover::{Agent, Simulated, id};
use umwelt_tests::server::Server;

const SEEDS: [u64; 5] = [1, 2, 3, 4, 5];

/// How a robot did its task.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Time in s.
    time: f64,
    /// Largest distance in m from the leg, as observed.
    observed: f64,
    /// Largest distance in m from the path, by the true positions.
    driven: f64,
    /// Median loop delay in s, as identified.
    loop_delay: f64,
}

/// The thesis's round trip without its calibration, on a hard floor under a camera, over a constant link.
fn scenario() -> Scenario {
    let settings = Settings { noise: PoseNoise::CAMERA, ..Settings::default() };
    Scenario {
        settings,
        plant: PlantModel {
            drive: settings.drive,
            slip: Slip::HARD,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        },
        link: LinkModel::ordinary(Rtt::Constant(0.040)),
        task: Task { calibration: None, ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: ARRIVAL.as_secs_f64(),
    }
}

/// Largest distance of `points` from the nearest leg of `task`, which begins at its first waypoint.
fn off_the_path(task: &Task, points: impl Iterator<Item = Point>) -> f64 {
    let legs = task.waypoints.windows(2);
    let distance = |point: Point| {
        let each = legs.clone().map(|leg| point.distance_to_segment(leg[0], leg[1]));
        each.fold(f64::INFINITY, f64::min)
    };
    points.map(distance).fold(0.0, f64::max)
}

fn simulate(scenario: &Scenario, seed: u64) -> Run {
    let mut points = Vec::new();
    let (outcome, controller) =
        scenario.run_with(seed, |row| points.push(row.pose.point())).unwrap();
    assert!(outcome.arrived, "seed {seed}: {outcome:?}");
    Run {
        time: outcome.time,
        observed: controller.progress().max_deviation,
        driven: off_the_path(&scenario.task, points.into_iter()),
        loop_delay: controller.estimates().link.median.unwrap(),
    }
}

/// Drives all seeds at once, each with an agent of its own, over HTTP.
async fn drive(scenario: &Scenario) -> Vec<Run> {
    let server = Server::start();
    let mut agents = Vec::new();
    for seed in SEEDS {
        let robot = id(&format!("seed-{seed}"));
        server
            .client
            .put_robot(&robot, &Description::from(&Spec::from(&scenario.settings)))
            .await
            .unwrap();
        server.client.set_task(&robot, &(&scenario.task).into()).await.unwrap();
        let link = Some(scenario.link.clone());
        let simulated = Simulated { plant: scenario.plant, start: scenario.start, link, seed };
        agents.push((robot.clone(), Agent::start(&server.url(), &robot, simulated)));
    }
    let mut runs = Vec::new();
    for (robot, mut agent) in agents {
        agent.until("it arrives", ARRIVAL, |now| now.stage == Some(Stage::Arrived)).await;
        let progress = server.client.get_task(&robot).await.unwrap().progress;
        let link = server.client.environment(&robot).await.unwrap().link;
        let (_, rows) = agent.end().await;
        let points = rows.iter().filter_map(|row: &TraceRow| row.pose).map(|pose| pose.point());
        runs.push(Run {
            time: progress.elapsed_s,
            observed: progress.max_deviation_m,
            driven: off_the_path(&scenario.task, points),
            loop_delay: link.median_s.unwrap(),
        });
    }
    runs
}

fn median(runs: &[Run], of: impl Fn(&Run) -> f64) -> f64 {
    let mut values: Vec<f64> = runs.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Guards against: agent or server lose a slot, hold a reply, stamp a pose wrongly; everything still arrives, and
/// what the simulation says about methods and links is not true of any robot.
///
/// Time and deviation within the limits of the issue. They forgive much where a horizon of 20 slots bridges the delay,
/// so the loop delay itself is held to half a slot: that is what a slot too much somewhere on the way would be.
#[tokio::test(flavor = "multi_thread")]
async fn the_episode_and_the_real_run_agree() {
    let scenario = scenario();
    let simulated = SEEDS.map(|seed| simulate(&scenario, seed));
    let driven = drive(&scenario).await;
    let both = format!("simulated {simulated:#?}\ndriven {driven:#?}");
    println!("{both}");
    let ratio = median(&driven, |run| run.time) / median(&simulated, |run| run.time);
    assert!((0.9..=1.1).contains(&ratio), "time differs by the factor {ratio}: {both}");
    let difference =
        median(&driven, |run| run.loop_delay) - median(&simulated, |run| run.loop_delay);
    assert!(difference.abs() < SLOT / 2.0, "loop delay differs by {difference} s: {both}");
    for deviation in [|run: &Run| run.observed, |run: &Run| run.driven] {
        let difference = median(&driven, deviation) - median(&simulated, deviation);
        assert!(difference.abs() <= 0.005, "deviation differs by {difference} m: {both}");
    }
}
