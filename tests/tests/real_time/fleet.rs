//! Many robots on one server.

use crate::{ARRIVAL, give, passed, straight_to};
use umwelt_api::RobotId;
use umwelt_api::robot::State;
use umwelt_api::task::Stage;
use umwelt_core::derived::complete;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::Pose;
use umwelt_core::kinematics::Drive;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{Lateness, PlantModel};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_tests::proxy::Proxy;
use umwelt_tests::rover::{Agent, Simulated};
use umwelt_tests::server::{self, Server};
use umwelt_tests::wait;

/// Where the task ends, in m.
const GOAL: f64 = 0.4;

/// Time in s of the task in simulated time, alone over a clean link, of the robot of this seed.
fn alone(seed: u64) -> f64 {
    // As a new robot of which nothing is said.
    let known = Settings {
        noise: PoseNoise::CAMERA,
        identifies_noise: true,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let settings = complete(known, |_| false);
    let Lateness { lag, dead_time } = Lateness::drawn(seed);
    let drive = Drive { lag, dead_time, ..settings.drive };
    let scenario = Scenario {
        settings,
        plant: PlantModel { drive, noise: PoseNoise::CAMERA, ..PlantModel::default() },
        link: LinkModel::preset("clean").unwrap(),
        task: straight_to(GOAL),
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: ARRIVAL.as_secs_f64(),
    };
    let outcome = scenario.run(1).unwrap();
    assert!(outcome.arrived, "{outcome:?}");
    outcome.time
}

async fn elapsed(server: &Server, robot: &RobotId, agent: &mut Agent) -> f64 {
    agent.until("it arrives", ARRIVAL, |now| now.stage == Some(Stage::Arrived)).await;
    server.client.get_task(robot).await.unwrap().progress.elapsed_s
}

/// Guards against: the server waits for the robot that does not answer, and all the others creep.
#[tokio::test(flavor = "multi_thread")]
async fn one_dead_link_among_ten_robots_disturbs_no_other() {
    let server = Server::start();
    let proxy = Proxy::start(server.address).await;
    let start = |url: &str, robot: &RobotId, seed| {
        Agent::start(url, robot, Simulated { seed, ..Simulated::default() })
    };
    let dead = give(&server.client, "dead", &straight_to(GOAL)).await;
    let mut dead_agent = start(&server::url(proxy.address()), &dead, 0);
    passed(&server.client, &dead, 0.05).await;
    proxy.cut();
    let mut others = Vec::new();
    for seed in 1..10 {
        let robot = give(&server.client, &format!("other-{seed}"), &straight_to(GOAL)).await;
        let agent = start(&server.url(), &robot, seed);
        others.push((robot, agent, alone(seed)));
    }
    for (robot, agent, alone) in &mut others {
        let alone = *alone;
        let time = elapsed(&server, robot, agent).await;
        println!("{robot}: {time:.2} s, alone {alone:.2} s");
        assert!((0.85..1.15).contains(&(time / alone)), "{robot}: {time} s, alone {alone} s");
    }
    let lost = wait::until("it counts as lost", ARRIVAL, async || {
        let robot = server.client.get_robot(&dead).await.unwrap();
        (robot.state == State::Lost).then_some(robot)
    })
    .await;
    assert!(lost.pose.is_some_and(|pose| pose.x_m > 0.05), "{lost:?}");
    proxy.mend();
    elapsed(&server, &dead, &mut dead_agent).await;
}
