//! Shutting down leaves no robot in motion.

use crate::api::{config, step};
use crate::sockets::request;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use umwelt_server::{Config, Server};

const LONG: Duration = Duration::from_secs(60);

struct Running {
    address: SocketAddr,
    stop: oneshot::Sender<()>,
    ended: JoinHandle<std::io::Result<()>>,
}

async fn run(config: Config) -> Running {
    let server = Server::bind(config).await.unwrap();
    let address = server.local_addr();
    let (stop, stopped) = oneshot::channel();
    let ended = tokio::spawn(server.run(async { stopped.await.unwrap_or_default() }));
    Running { address, stop, ended }
}

/// Holds that the server ends by itself and not by one of its long limits.
async fn has_ended(ended: JoinHandle<std::io::Result<()>>) {
    tokio::time::timeout(LONG / 3, ended).await.expect("it ends").unwrap().unwrap();
}

async fn drive(address: SocketAddr, sequence: u64) -> String {
    let body = step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0).to_string();
    request(address, "POST", "/v1/robots/r/step", &body).await
}

async fn until_draining(address: SocketAddr) {
    while !request(address, "GET", "/readyz", "").await.starts_with("HTTP/1.1 503") {
        tokio::task::yield_now().await;
    }
}

/// The limits are a minute here: the server ends because the robot was served, not because of time or because the
/// robot is given up.
#[tokio::test]
async fn a_connected_robot_fetches_a_stopping_horizon_and_then_the_server_ends() {
    let Running { address, stop, ended } =
        run(Config { drain: LONG, lost_after: LONG, ..config() }).await;
    for robot in ["r", "never"] {
        let put = request(address, "PUT", &format!("/v1/robots/{robot}"), "{}").await;
        assert!(put.starts_with("HTTP/1.1 201"), "{put}");
    }
    assert!(drive(address, 1).await.contains("\"stopped\":false"));
    stop.send(()).unwrap();
    until_draining(address).await;
    assert!(!ended.is_finished(), "it waits for the robot");
    for (method, path) in [("PUT", "/v1/robots/new"), ("POST", "/v1/robots/r/resume")] {
        let refused = request(address, method, path, "{}").await;
        assert!(refused.starts_with("HTTP/1.1 503"), "{refused}");
        assert!(refused.contains("DRAINING"), "{refused}");
    }
    assert!(request(address, "GET", "/healthz", "").await.starts_with("HTTP/1.1 200"));
    // A repeat of an earlier step is no stopping horizon.
    assert!(drive(address, 1).await.contains("\"stopped\":false"));
    assert!(!ended.is_finished());
    assert!(drive(address, 2).await.contains("\"stopped\":true"));
    has_ended(ended).await;
}

#[tokio::test]
async fn a_robot_that_fetches_nothing_is_not_waited_for_any_longer() {
    let drain = Duration::from_millis(50);
    let Running { address, stop, ended } = run(Config { drain, ..config() }).await;
    request(address, "PUT", "/v1/robots/r", "{}").await;
    drive(address, 1).await;
    stop.send(()).unwrap();
    has_ended(ended).await;
}

/// Guards against: a stream that never ends, or a client that reads nothing, keeps the server from ending.
#[tokio::test]
async fn event_streams_end_with_the_server() {
    let Running { address, stop, ended } = run(Config { close: LONG, ..config() }).await;
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(b"GET /v1/events HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
    let mut head = [0; 12];
    stream.read_exact(&mut head).await.unwrap();
    assert_eq!(&head, b"HTTP/1.1 200");
    stop.send(()).unwrap();
    has_ended(ended).await;
    let mut rest = Vec::new();
    stream.read_to_end(&mut rest).await.unwrap();
}
