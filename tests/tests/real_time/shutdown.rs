//! Agents and servers that are told to end.

use crate::{AgentProcess, give, passed, straight_to};
use umwelt_core::kinematics::Drive;
use umwelt_tests::process::{SOON, Signal};
use umwelt_tests::rover::{self, Agent, Simulated};
use umwelt_tests::server::Server;
use umwelt_tests::trace;

/// Longest robot time in s from the end of the server to the rest of its robots: the loop delay of 0.23 s, the ramp of
/// 0.43 s, and as much again. Without a stopping horizon it is 1.5 s.
const STOPPED_BY_SERVER: f64 = 1.2;

/// Guards against: an agent that ends leaves its motors as they were, or stops them with a jerk.
#[tokio::test(flavor = "multi_thread")]
async fn sigterm_to_an_agent_leaves_a_stopped_robot() {
    let drive = Drive::default();
    let server = Server::start();
    let robot = give(&server.client, "ended", &straight_to(2.0)).await;
    let agent = AgentProcess::start(&server.url(), &robot);
    let last_seen = passed(&server.client, &robot, 0.10).await.taken_s;
    let rows = agent.end().await;

    trace::assert_within_limits(&rows, &drive);
    let moving = trace::twist(&drive, trace::at(&rows, last_seen)).linear;
    assert!(moving > drive.max_linear / 2.0, "it drives at {moving} m/s when it is told");
    let last = rows.last().unwrap();
    assert_eq!((last.applied.left, last.applied.right), (0.0, 0.0), "{last:?}");
    assert!(last.time < last_seen + 2.0, "it took {} s", last.time - last_seen);
}

/// Guards against: a server that ends leaves its robots to their watchdogs, or waits for them for ever.
#[tokio::test(flavor = "multi_thread")]
async fn sigterm_to_the_server_stops_its_robots_first() {
    let mut server = Server::start();
    let mut agents = Vec::new();
    for name in ["first", "second"] {
        let robot = give(&server.client, name, &straight_to(2.0)).await;
        agents.push(Agent::start(&server.url(), &robot, Simulated::default()));
    }
    for agent in &mut agents {
        agent.until("it drives", SOON, rover::drives).await;
    }
    let told: Vec<f64> = agents.iter().map(|agent| agent.status().time).collect();
    server.process.signal(Signal::Terminate);
    for (agent, told) in agents.iter_mut().zip(told) {
        let rests = agent.until("it rests", SOON, rover::rests).await;
        assert!(rests.stopped, "told by the server: {rests:?}");
        assert!(rests.time < told + STOPPED_BY_SERVER, "after {} s", rests.time - told);
    }
    let status = server.process.end(SOON).await;
    assert_eq!(status.code(), Some(0), "{}", server.process.log());
    for agent in agents {
        let (_, rows) = agent.end().await;
        trace::assert_within_limits(&rows, &Drive::default());
    }
}
