//! Event streams: each event once, also across a connection that breaks.

use super::describe;
use futures_util::StreamExt;
use umwelt_api::RobotId;
use umwelt_api::event::{Event, Kind};
use umwelt_client::{Client, Events};
use umwelt_tests::process::SOON;
use umwelt_tests::proxy::Proxy;
use umwelt_tests::server::{self, Server};
use umwelt_tests::wait;

/// The next event. A connection that breaks is reported in between, and is no event.
async fn next(events: &mut Events) -> Event {
    loop {
        let item = wait::within("an event", SOON, events.next()).await;
        match item.expect("the stream goes on") {
            Ok(event) => return event,
            Err(error) => assert!(error.is_transient(), "{error}"),
        }
    }
}

/// Stops and resumes: two events, known in advance.
async fn stop_and_resume(client: &Client, robot: &RobotId) {
    client.stop(robot).await.unwrap();
    client.resume(robot).await.unwrap();
}

/// Guards against: whoever reconnects sees an event twice, or never.
#[tokio::test]
async fn a_stream_resumes_behind_the_last_event() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    let other = describe(&server.client, "rover-8").await;
    let mut events = server.client.events(Some(&robot), None).await.unwrap();
    for _ in 0..2 {
        stop_and_resume(&server.client, &robot).await;
        stop_and_resume(&server.client, &other).await;
    }
    let mut seen = Vec::new();
    for _ in 0..4 {
        seen.push(next(&mut events).await);
    }
    drop(events);
    let kinds: Vec<&Kind> = seen.iter().map(|event| &event.kind).collect();
    assert_eq!(kinds, [&Kind::Stopped, &Kind::Resumed, &Kind::Stopped, &Kind::Resumed]);
    assert!(seen.iter().all(|event| event.robot.as_ref() == Some(&robot)));
    stop_and_resume(&server.client, &robot).await;
    for place in 0..seen.len() {
        let after = Some(seen[place].id);
        let mut events = server.client.events(Some(&robot), after).await.unwrap();
        for expected in &seen[place + 1..] {
            assert_eq!(&next(&mut events).await, expected);
        }
        assert_eq!(next(&mut events).await.kind, Kind::Stopped);
        assert_eq!(next(&mut events).await.kind, Kind::Resumed);
    }
    // An id of another life of the server: what was missed is not passed over in silence.
    let mut events = server.client.events(Some(&robot), Some(1)).await.unwrap();
    assert_eq!(next(&mut events).await.kind, Kind::Missed);
}

/// Guards against: a follower over a bad link believes that nothing happened while it was away.
#[tokio::test]
async fn a_follower_whose_connection_breaks_misses_nothing() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    let proxy = Proxy::start(server.address).await;
    let mut events = server::client(proxy.address()).events(None, None).await.unwrap();
    let mut ids = Vec::new();
    for _ in 0..3 {
        stop_and_resume(&server.client, &robot).await;
        for kind in [Kind::Stopped, Kind::Resumed] {
            let event = next(&mut events).await;
            assert_eq!(event.kind, kind);
            ids.push(event.id);
        }
        proxy.drop_connections();
        stop_and_resume(&server.client, &robot).await;
        for kind in [Kind::Stopped, Kind::Resumed] {
            let event = next(&mut events).await;
            assert_eq!(event.kind, kind);
            ids.push(event.id);
        }
    }
    assert!(ids.windows(2).all(|pair| pair[0] < pair[1]), "{ids:?}");
}
