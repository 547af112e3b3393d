//! The server stands still under moving robots.

use crate::{AgentProcess, REST_AFTER, arrived, assert_stands_at, give, passed, straight_to};
use std::time::Duration;
use umwelt_core::kinematics::Drive;
use umwelt_tests::process::Signal;
use umwelt_tests::server::Server;
use umwelt_tests::trace;

/// How long the server stands still.
const PAUSE: Duration = Duration::from_secs(5);

/// Where the task ends, in m.
const GOAL: f64 = 0.5;

/// Guards against: a server that was suspended takes its robots for lost or their requests of then for those of now,
/// or the robot takes old horizons for new ones.
#[tokio::test(flavor = "multi_thread")]
async fn the_server_is_paused_for_five_seconds_under_a_moving_robot() {
    let drive = Drive::default();
    let server = Server::start();
    let robot = give(&server.client, "paused", &straight_to(GOAL)).await;
    let agent = AgentProcess::start(&server.url(), &robot);
    let last_seen = passed(&server.client, &robot, 0.12).await.taken_s;
    server.process.signal(Signal::Stop);
    tokio::time::sleep(PAUSE).await;
    server.process.signal(Signal::Continue);
    arrived(&server.client, &robot).await;
    let rows = agent.end().await;

    trace::assert_within_limits(&rows, &drive);
    let moving = trace::twist(&drive, trace::at(&rows, last_seen)).linear;
    assert!(moving > drive.max_linear / 2.0, "it drives at {moving} m/s when the server stops");
    trace::assert_rests(&rows, last_seen + REST_AFTER, last_seen + PAUSE.as_secs_f64());
    assert_stands_at(&rows, GOAL);
}
