//! The link goes in the middle of a leg.

use crate::{AgentProcess, REST_AFTER, arrived, assert_stands_at, give, passed, straight_to};
use std::time::Duration;
use umwelt_core::kinematics::Drive;
use umwelt_tests::proxy::Proxy;
use umwelt_tests::server::{self, Server};
use umwelt_tests::trace;

/// How long nothing gets through.
const OUTAGE: Duration = Duration::from_secs(20);

/// Where the task ends, and beyond where the link goes, in m.
const GOAL: f64 = 0.6;
const CUT: f64 = 0.15;

/// Guards against: a robot that drives on without its link, stops with a jerk, or waits for a person afterwards.
///
/// One robot's connections stay open and silent, the other's are reset and its new ones stay silent.
#[tokio::test(flavor = "multi_thread")]
async fn twenty_seconds_without_a_link_in_the_middle_of_a_leg() {
    let server = Server::start();
    tokio::join!(lose_link(&server, "silent", false), lose_link(&server, "reset", true));
}

async fn lose_link(server: &Server, name: &str, is_reset: bool) {
    let drive = Drive::default();
    let proxy = Proxy::start(server.address).await;
    proxy.delay(Duration::from_millis(20), Duration::from_millis(20));
    let robot = give(&server.client, name, &straight_to(GOAL)).await;
    let agent = AgentProcess::start(&server::url(proxy.address()), &robot);
    let last_seen = passed(&server.client, &robot, CUT).await.taken_s;
    proxy.cut();
    if is_reset {
        proxy.drop_connections();
    }
    tokio::time::sleep(OUTAGE).await;
    proxy.mend();
    arrived(&server.client, &robot).await;
    let rows = agent.end().await;

    trace::assert_within_limits(&rows, &drive);
    let moving = trace::twist(&drive, trace::at(&rows, last_seen)).linear;
    assert!(
        moving > drive.max_linear / 2.0,
        "{name}: it drives at {moving} m/s when the link goes"
    );
    let back = last_seen + OUTAGE.as_secs_f64();
    trace::assert_rests(&rows, last_seen + REST_AFTER, back);
    // Fresh connections are tried once per second.
    let later = rows.iter().filter(|row| row.time > back);
    let on = later.map(|row| (row.time, trace::twist(&drive, row).linear)).find(|on| on.1 > 0.0);
    let on = on.unwrap_or_else(|| panic!("{name}: it never goes on")).0;
    assert!(on < back + 4.0, "{name}: it goes on {} s after the link is back", on - back);
    assert_stands_at(&rows, GOAL);
}
