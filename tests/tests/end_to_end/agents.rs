//! Real agents: taken over, stopped, lost.

use super::{describe, straight_to};
use futures_util::StreamExt;
use std::time::Duration;
use umwelt_agent::AgentError;
use umwelt_api::event::Kind;
use umwelt_api::page::PageQuery;
use umwelt_api::robot::State;
use umwelt_core::kinematics::Drive;
use umwelt_tests::process::SOON;
use umwelt_tests::rover::{self, Agent, Simulated, request};
use umwelt_tests::said::{call, umwelt};
use umwelt_tests::server::Server;
use umwelt_tests::trace;
use umwelt_tests::wait;

/// Guards against: the agent that lost its robot goes on with its last horizon, or tries again for ever.
#[tokio::test]
async fn an_agent_that_is_taken_over_stops_its_robot_and_ends() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(2.0)).await.unwrap();
    let mut first = Agent::start(&server.url(), &robot, Simulated::default());
    first.until("the robot drives", SOON, rover::drives).await;
    let mut second = Agent::start(&server.url(), &robot, Simulated::default());
    let (result, rows) = first.ended().await;
    assert_eq!(result, Err(AgentError::Superseded { robot: robot.clone() }));
    trace::assert_within_limits(&rows, &Drive::default());
    let last = rows.last().unwrap();
    assert_eq!(trace::twist(&Drive::default(), last).linear, 0.0, "{last:?}");
    second.until("the second one drives", SOON, rover::drives).await;
    second.end().await;
}

/// Guards against: an agent that was told other wheels than the server, drives all the same, and the floor is blamed.
#[tokio::test]
async fn an_agent_has_its_drive_from_the_server_and_does_not_drive_by_another() {
    let server = Server::start();
    umwelt(&server, "robot add rover-7 --wheel-radius 0.021 --max-speed 0.1").await;
    umwelt(&server, "task set rover-7 --waypoint 2,0").await;
    let agent = |flags: &str| {
        format!("--server {} --robot rover-7 --drive sim --duration 3 {flags}", server.url())
    };
    let other = agent("--wheel-radius 0.03 --max-speed 0.1");
    let said = call("umwelt-agent", &other.split(' ').collect::<Vec<_>>()).await;
    assert_eq!(said.code, Some(1));
    for part in [
        "--wheel-radius 0.03 m here and 0.021 m on the server",
        "umwelt robot set rover-7 --wheel-radius 0.03",
    ] {
        assert!(said.log.contains(part), "{}", said.log);
    }
    let pose = server.client.get_robot(&rover::id("rover-7")).await.unwrap().pose;
    assert!(pose.is_none_or(|pose| pose.x_m.abs() < 0.01), "it did not move: {pose:?}");
    let own = agent("").trim().to_owned();
    let said = call("umwelt-agent", &own.split(' ').collect::<Vec<_>>()).await;
    assert_eq!(said.code, Some(0), "{}", said.log);
    assert!(said.log.contains("wheel_radius_m=0.021"), "{}", said.log);
    // It moved by the wheels that were described: what was commanded was seen.
    let environment = server.client.environment(&rover::id("rover-7")).await.unwrap();
    let forward = environment.channels.forward;
    assert!(forward.mean.is_none_or(|mean| mean.abs() < 0.1), "{forward:?}");
}

/// Guards against: a stop that is forgotten with the next pose, or a resume that jumps to full speed.
#[tokio::test]
async fn a_robot_that_is_stopped_rests_until_it_is_resumed() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(2.0)).await.unwrap();
    let mut agent = Agent::start(&server.url(), &robot, Simulated::default());
    agent.until("the robot drives", SOON, rover::drives).await;
    server.client.stop(&robot).await.unwrap();
    let resting = agent.until("it rests", SOON, |now| now.stopped && rover::rests(now)).await;
    assert!(server.client.get_robot(&robot).await.unwrap().stopped);
    // It rests on, whatever is sent.
    let later = resting.time + 0.5;
    agent.until("half a second", SOON, |now| now.time > later).await;
    assert!(rover::rests(&agent.status()));
    server.client.resume_all().await.unwrap();
    let moving = agent.until("it drives again", SOON, rover::drives).await;
    assert!(!moving.stopped);
    server.client.stop_all().await.unwrap();
    let again = agent.until("it rests again", SOON, |now| now.stopped && rover::rests(now)).await;
    let (_, rows) = agent.end().await;
    trace::assert_rests(&rows, resting.time, later);
    trace::assert_rests(&rows, again.time, rows.last().unwrap().time);
    trace::assert_within_limits(&rows, &Drive::default());
}

/// Guards against: a robot that falls silent disappears from the list, and no one looks for it.
#[tokio::test]
async fn a_lost_robot_stays_listed_with_its_last_pose() {
    let server = Server::start_with(&["--lost-after-s", "0.3"]);
    let robot = describe(&server.client, "rover-7").await;
    describe(&server.client, "rover-8").await;
    let mut events = server.client.events(Some(&robot), None).await.unwrap();
    let steps = server.client.step_connection();
    steps.step(&robot, &request(1, 1, 5.0)).await.unwrap();
    let mut next_state = async || loop {
        let event = wait::within("a change of the link", SOON, events.next()).await;
        if let Kind::Link { state } = event.unwrap().unwrap().kind {
            return state;
        }
    };
    assert_eq!(next_state().await, State::Connected);
    assert_eq!(next_state().await, State::Lost);
    let lost = PageQuery { state: Some(State::Lost), ..PageQuery::default() };
    let page = server.client.list_robots(&lost).await.unwrap();
    assert_eq!(page.robots.len(), 1);
    let seen = &page.robots[0];
    assert_eq!(seen.robot, robot);
    assert!(seen.pose.is_some_and(|pose| (pose.taken_s - 4.87).abs() < 1e-9), "{seen:?}");
    assert!(seen.last_seen_s_ago.is_some_and(|ago| ago >= 0.3), "{seen:?}");
    let all = server.client.list_robots(&PageQuery::default()).await.unwrap();
    assert_eq!(all.robots.len(), 2);
    steps.step(&robot, &request(1, 2, 9.0)).await.unwrap();
    assert_eq!(next_state().await, State::Connected);
}

/// Guards against: an agent that cannot stop without the server's consent.
#[tokio::test]
async fn an_agent_whose_server_dies_stops_its_robot() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(2.0)).await.unwrap();
    let mut agent = Agent::start(&server.url(), &robot, Simulated::default());
    agent.until("the robot drives", SOON, rover::drives).await;
    let address = server.address;
    drop(server);
    let killed = agent.status().time;
    let rests = agent.until("it rests", SOON, rover::rests).await;
    // 20 slots, the loop delay, the watchdog of 0.3 s, the ramp, and as much again for a busy machine.
    assert!(rests.time < killed + 3.0, "{} s after the server died", rests.time - killed);
    // A server that comes back without its robots: the agent says so and the robot rests.
    let listen = address.to_string();
    let server = umwelt_tests::process::Process::start(
        "umwelt-server",
        &["--in-memory", "--listen", &listen],
    );
    assert!(server.line(0).is_some());
    let client = umwelt_tests::server::client(address);
    describe(&client, "rover-7").await;
    client.set_task(&robot, &straight_to(2.0)).await.unwrap();
    let drives = agent.until("it drives again", Duration::from_secs(15), rover::drives).await;
    let (_, rows) = agent.end().await;
    trace::assert_within_limits(&rows, &Drive::default());
    assert!(drives.time > rests.time);
}
