//! Connections that stall, half open or half said, disturb no one else; and the end of the server.

use super::{describe, straight_to};
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use umwelt_tests::http;
use umwelt_tests::process::{SOON, Signal};
use umwelt_tests::proxy::Proxy;
use umwelt_tests::rover::request;
use umwelt_tests::server::{self, Server};
use umwelt_tests::wait;

/// Connections of each kind: more than a pool of worker threads has threads.
const OF_EACH: usize = 20;

/// Longest time for a step that nothing disturbs. It takes a millisecond; one that waits for a stalled connection
/// takes as long as that.
const UNDISTURBED: Duration = Duration::from_secs(2);

async fn stall(server: SocketAddr, said: &str) -> TcpStream {
    let mut stream = TcpStream::connect(server).await.unwrap();
    stream.write_all(said.as_bytes()).await.unwrap();
    stream
}

/// Guards against: whoever begins a request and does not end it takes the place of a robot.
#[tokio::test]
async fn half_said_requests_block_no_one_and_are_ended() {
    let server = Server::start_with(&["--header-timeout-s", "3", "--body-timeout-s", "3"]);
    let robot = describe(&server.client, "rover-7").await;
    let body = "POST /v1/robots/rover-7/step HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 500\r\n\r\n{\"seq";
    let kinds = [
        "",
        "PO",
        "GET /v1/robots HTTP/1.1\r\nHost: localhost\r\nX-Slow: ",
        body,
        "PRI * HTTP/2.0\r\n",
    ];
    let mut stalled = Vec::new();
    for said in kinds.iter().cycle().take(OF_EACH * kinds.len()) {
        stalled.push((*said, stall(server.address, said).await));
    }
    let steps = server.client.step_connection();
    for sequence in 1..=50 {
        let begin = Instant::now();
        steps.step(&robot, &request(1, sequence, sequence as f64 * 0.03)).await.unwrap();
        server.client.get_robot(&robot).await.unwrap();
        assert!(begin.elapsed() < UNDISTURBED, "step {sequence} took {:?}", begin.elapsed());
    }
    for (said, mut stream) in stalled {
        let mut answer = Vec::new();
        let read = stream.read_to_end(&mut answer);
        // An end in order or a reset, either is one.
        let _ = wait::within(&format!("the end of {said:?}"), SOON, read).await;
        let answer = String::from_utf8_lossy(&answer);
        assert!(said != body || answer.contains("BODY_TIMEOUT"), "{answer:?}");
    }
    let next = steps.step(&robot, &request(1, 51, 1.53)).await.unwrap();
    assert_eq!(next.horizon.answers, 51);
}

/// Guards against: the server waits for a client that is gone without a word, and the robots with it.
#[tokio::test]
async fn half_open_connections_block_no_one() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    let dead = describe(&server.client, "rover-8").await;
    server.client.set_task(&dead, &straight_to(1.0)).await.unwrap();
    let proxy = Proxy::start(server.address).await;
    let far = server::client(proxy.address());
    let over = far.step_connection();
    over.step(&dead, &request(1, 1, 0.03)).await.unwrap();
    let events = far.events(None, None).await.unwrap();
    proxy.cut();
    let held = async {
        let [a, b, c] = [2, 3, 4].map(|n| request(1, n, n as f64 * 0.03));
        let replies =
            tokio::join!(over.step(&dead, &a), over.step(&dead, &b), over.step(&dead, &c));
        [replies.0, replies.1, replies.2]
    };
    let near = async {
        let steps = server.client.step_connection();
        for sequence in 1..=50 {
            let begin = Instant::now();
            steps.step(&robot, &request(1, sequence, sequence as f64 * 0.03)).await.unwrap();
            assert!(begin.elapsed() < UNDISTURBED, "step {sequence} took {:?}", begin.elapsed());
        }
        proxy.mend();
    };
    let (held, ()) = tokio::join!(held, near);
    // What the link held back is answered when it is back, in order.
    for (reply, sequence) in held.into_iter().zip(2..) {
        assert_eq!(reply.unwrap().horizon.answers, sequence);
    }
    drop(events);
}

/// Guards against: a server that cannot be ended while someone is connected, and is killed in the end.
#[tokio::test]
async fn sigterm_ends_the_server_with_0_whoever_is_connected() {
    let mut server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    let _events = server.client.events(None, None).await.unwrap();
    let steps = server.client.step_connection();
    steps.step(&robot, &request(1, 1, 0.03)).await.unwrap();
    let _half = stall(server.address, "GET /v1/robots HTTP/1.1\r\n").await;
    server.process.signal(Signal::Terminate);
    let status = server.process.end(SOON).await;
    assert_eq!(status.code(), Some(0), "{}", server.process.log());
    assert_eq!(server.process.lines().len(), 1, "nothing but the address on standard output");
}

/// Guards against: clients are generated from a contract that the server does not serve.
#[tokio::test]
async fn the_contract_served_is_the_one_checked_in() {
    let server = Server::start();
    let served = http::call(server.address, "GET", "/openapi.json", &[], b"").await;
    assert_eq!(served.code, 200);
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../openapi/openapi.json");
    let checked_in: serde_json::Value =
        serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    assert!(served.json() == checked_in, "the contract served is not that of {file}");
}
