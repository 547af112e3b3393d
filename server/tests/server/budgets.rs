//! What one peer may use up: never what others need. Peers are addresses of the loopback network.

use crate::api::{config, step};
use crate::sockets::{read_out, serve, written};
use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use hyper_util::rt::{TokioExecutor, TokioIo};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use umwelt_server::Config;

/// Long enough for a busy machine; nothing here waits for it where all is well.
const TIMEOUT: Duration = Duration::from_secs(30);

/// A peer that answers no pings is cut off after 20 s anyway.
const BEFORE_PINGS: Duration = Duration::from_secs(15);

const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0";

/// A connection of the peer 127.0.0.`peer`.
async fn connect(peer: u8, address: SocketAddr) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind(([127, 0, 0, peer], 0).into()).unwrap();
    socket.connect(address).await.unwrap()
}

/// The first line of the answer to one request of a peer on a connection of its own, and all of it.
async fn ask(peer: u8, address: SocketAddr, method: &str, path: &str, body: &str) -> String {
    let request = written(method, path, body);
    let answer = read_out(connect(peer, address).await, request.as_bytes());
    tokio::time::timeout(TIMEOUT, answer).await.expect("an answer")
}

async fn code(peer: u8, address: SocketAddr, method: &str, path: &str) -> u16 {
    let answer = ask(peer, address, method, path, "").await;
    answer.get(9..12).and_then(|code| code.parse().ok()).unwrap_or_else(|| panic!("{answer:?}"))
}

/// A stream of events that has begun: its connection is busy until it is dropped.
async fn following(peer: u8, address: SocketAddr) -> TcpStream {
    let mut stream = connect(peer, address).await;
    stream.write_all(b"GET /v1/events HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
    let mut begin = [0; 15];
    stream.read_exact(&mut begin).await.unwrap();
    assert_eq!(&begin, b"HTTP/1.1 200 OK");
    stream
}

/// A step of robot `r` as a new one of epoch `epoch`.
async fn step_of(peer: u8, address: SocketAddr, epoch: u64) -> String {
    ask(peer, address, "POST", "/v1/robots/r/step", &step(epoch, 1, 10.0, 0.0).to_string()).await
}

/// Guards against: one peer takes all connections, and no one can drive or stop a robot any more.
#[tokio::test]
async fn a_peer_at_its_limit_stops_neither_others_nor_anybodys_stop() {
    let limits = Config {
        max_connections: 8,
        max_connections_per_peer: 6,
        reserved_connections: 8,
        ..config()
    };
    let (address, _server) = serve(limits).await;
    assert!(ask(3, address, "PUT", "/v1/robots/r", "{}").await.starts_with("HTTP/1.1 201"));
    let mut held = Vec::new();
    for _ in 0..6 {
        held.push(following(2, address).await);
    }
    let refused = ask(2, address, "GET", "/v1/robots", "").await;
    assert!(refused.starts_with("HTTP/1.1 429") && refused.contains("retry-after: 1"), "{refused}");
    assert_eq!(code(2, address, "POST", "/v1/robots/r/stop").await, 200);
    assert!(step_of(3, address, 1).await.starts_with("HTTP/1.1 200"), "another peer drives");
    // Now all places are taken by those who are busy.
    for _ in 0..2 {
        held.push(following(3, address).await);
    }
    assert_eq!(code(4, address, "GET", "/v1/robots").await, 429);
    // The reserve cannot be used up by one peer either: many silent connections, and half a request on each.
    let mut silent = Vec::new();
    for _ in 0..40 {
        let mut stream = connect(2, address).await;
        let _ = stream.write_all(b"POST /v1/st").await;
        silent.push(stream);
    }
    for peer in [2, 3, 4] {
        assert_eq!(code(peer, address, "POST", "/v1/stop").await, 200, "{peer}");
        assert_eq!(code(peer, address, "GET", "/healthz").await, 200, "{peer}");
        assert_eq!(code(peer, address, "GET", "/readyz").await, 200, "{peer}");
        assert_eq!(code(peer, address, "POST", "/v1/resume").await, 429, "{peer}");
    }
    drop((held, silent));
    while code(4, address, "GET", "/v1/robots").await != 200 {
        tokio::task::yield_now().await;
    }
}

/// Guards against: connections that were used once keep their places, whoever needs one.
#[tokio::test]
async fn the_longest_idle_connection_of_the_greediest_peer_gives_way() {
    let limits = Config { max_connections: 4, max_connections_per_peer: 3, ..config() };
    let (address, _server) = serve(limits).await;
    let mut idle = Vec::new();
    for _ in 0..3 {
        let mut stream = connect(2, address).await;
        stream.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
        let mut begin = [0; 15];
        stream.read_exact(&mut begin).await.unwrap();
        idle.push(stream);
    }
    let busy = following(3, address).await;
    let served = async {
        while code(4, address, "GET", "/v1/robots").await != 200 {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(TIMEOUT, served).await.expect("an idle one gives way");
    let mut rest = Vec::new();
    let closed = tokio::time::timeout(TIMEOUT, idle[0].read_to_end(&mut rest));
    assert!(closed.await.is_ok(), "the longest idle one was closed");
    // The others go on.
    idle[2]
        .write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n")
        .await
        .unwrap();
    let mut rest = String::new();
    idle[2].read_to_string(&mut rest).await.unwrap();
    assert!(rest.contains("HTTP/1.1 200"), "{rest}");
    drop(busy);
}

#[tokio::test]
async fn one_peer_does_not_take_all_event_streams() {
    let limits = Config { max_event_streams: 3, max_event_streams_per_peer: 2, ..config() };
    let (address, _server) = serve(limits).await;
    let _held = [following(2, address).await, following(2, address).await];
    let refused = ask(2, address, "GET", "/v1/events", "").await;
    assert!(
        refused.starts_with("HTTP/1.1 429") && refused.contains("of this address"),
        "{refused}"
    );
    let _other = following(3, address).await;
    assert_eq!(code(4, address, "GET", "/v1/events").await, 429);
}

/// Guards against: bodies that never end hold as much memory as someone likes to send.
#[tokio::test]
async fn unfinished_bodies_are_given_up_for_others_and_no_one_else_is_refused() {
    const MB: usize = 1 << 20;
    let limits = Config { max_bodies: 2 * MB, max_bodies_per_peer: MB, ..config() };
    let (address, _server) = serve(limits).await;
    assert!(ask(3, address, "PUT", "/v1/robots/r", "{}").await.starts_with("HTTP/1.1 201"));
    let mut held = Vec::new();
    let head =
        "PUT /v1/robots/r/task HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n";
    let unfinished = format!("{head}content-length: 250000\r\n\r\n{}", " ".repeat(200_000));
    for _ in 0..20 {
        let mut stream = connect(2, address).await;
        stream.write_all(unfinished.as_bytes()).await.unwrap();
        held.push(stream);
    }
    // At most five of them fit into a megabyte; the first were given up long before the time for a body is over.
    let mut answer = [0; 12];
    tokio::time::timeout(TIMEOUT, held[0].read_exact(&mut answer)).await.unwrap().unwrap();
    assert_eq!(&answer, b"HTTP/1.1 429");
    for (peer, epoch) in [(2, 1), (3, 2)] {
        let answer = step_of(peer, address, epoch).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
    drop(held);
}

fn frame(kind: u8, stream: u8, content: &[u8]) -> Vec<u8> {
    [&[0, 0, content.len() as u8, kind, 0, 0, 0, 0, stream], content].concat()
}

/// Sends a preface and `frames` again and again, and reads what comes, until the connection ends.
async fn flood(address: SocketAddr, begin: Vec<u8>, frames: Vec<u8>) {
    let (mut read, mut write) = connect(2, address).await.into_split();
    let reading = async move {
        let mut ignored = Vec::new();
        let _ = read.read_to_end(&mut ignored).await;
    };
    let writing = async move {
        let _ = write.write_all(&[PREFACE, &begin].concat()).await;
        while write.write_all(&frames).await.is_ok() {}
    };
    let ended = async { tokio::join!(reading, writing) };
    tokio::time::timeout(BEFORE_PINGS, ended).await.expect("a flood ends its connection");
}

/// Guards against: a connection that only sends control frames takes all the time there is.
#[tokio::test]
async fn a_flood_of_control_frames_ends_its_connection_and_no_other() {
    // Nothing else ends them in time.
    let (header_timeout, body_timeout) = (10 * TIMEOUT, 10 * TIMEOUT);
    let (address, _server) = serve(Config { header_timeout, body_timeout, ..config() }).await;
    let settings = frame(4, 0, &[0, 3, 0, 0, 0, 100]);
    let step = b"\x83\x86\x04\x12/v1/robots/r0/step\x01\x01x";
    let step = [&[0, 0, step.len() as u8, 1, 4, 0, 0, 0, 1][..], step].concat();
    for (begin, flooding) in [
        (Vec::new(), settings),
        (Vec::new(), frame(6, 0, b"12345678")),
        (Vec::new(), frame(8, 0, &[0, 0, 0, 1])),
        (Vec::new(), frame(2, 1, &[0, 0, 0, 3, 5])),
        (Vec::new(), frame(0x20, 0, b"unknown")),
        (step, frame(0, 1, b"")),
    ] {
        flood(address, begin, flooding.repeat(500)).await;
        assert_eq!(code(3, address, "GET", "/healthz").await, 200);
    }
}

/// What the limit must never touch: an agent's steps, even at a hundredth of the limit and as fast as they go.
#[tokio::test]
async fn an_agent_is_far_below_the_limit_of_control_frames() {
    let limits = Config { max_control_frames_per_s: 1, ..config() };
    let (address, _server) = serve(limits).await;
    assert!(ask(3, address, "PUT", "/v1/robots/r", "{}").await.starts_with("HTTP/1.1 201"));
    let stream = connect(3, address).await;
    let (sender, connection) =
        hyper::client::conn::http2::handshake(TokioExecutor::new(), TokioIo::new(stream))
            .await
            .unwrap();
    tokio::spawn(connection);
    for sequence in 1..=300 {
        let mut sender = sender.clone();
        let body = step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0).to_string();
        let request = Request::post(format!("http://{address}/v1/robots/r/step"))
            .header("content-type", "application/json")
            .body(Body::from(body))
            .unwrap();
        let response = sender.send_request(request).await.unwrap();
        assert_eq!(response.status(), 200);
        response.into_body().collect().await.unwrap();
    }
}
