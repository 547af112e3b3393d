//! What only a real connection can show: limits in time and number, both protocols.

use crate::api::{config, step};
use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use hyper_util::rt::{TokioExecutor, TokioIo};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinHandle;
use umwelt_server::{Config, Server};

/// Short enough for a test, long enough for a busy machine to serve a request.
const SHORT: Duration = Duration::from_secs(1);

/// A server in the background; it ends with the test's runtime.
pub(crate) async fn serve(config: Config) -> (SocketAddr, JoinHandle<std::io::Result<()>>) {
    let server = Server::bind(config).await.unwrap();
    (server.local_addr(), tokio::spawn(server.run(std::future::pending())))
}

/// Sends bytes and reads until the server closes.
pub(crate) async fn talk(address: SocketAddr, bytes: &[u8]) -> String {
    read_out(TcpStream::connect(address).await.unwrap(), bytes).await
}

/// Sends bytes on a connection and reads until the server closes.
pub(crate) async fn read_out(mut stream: TcpStream, bytes: &[u8]) -> String {
    stream.write_all(bytes).await.unwrap();
    let mut answer = Vec::new();
    // A reset is an end too.
    let _ = stream.read_to_end(&mut answer).await;
    String::from_utf8_lossy(&answer).into_owned()
}

/// One HTTP/1.1 request after which the connection ends.
pub(crate) fn written(method: &str, path: &str, body: &str) -> String {
    let length = body.len();
    let head = format!("{method} {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n");
    format!("{head}content-type: application/json\r\ncontent-length: {length}\r\n\r\n{body}")
}

/// One HTTP/1.1 request on a connection of its own.
pub(crate) async fn request(address: SocketAddr, method: &str, path: &str, body: &str) -> String {
    talk(address, written(method, path, body).as_bytes()).await
}

#[tokio::test]
async fn http_2_without_tls_is_spoken_on_the_same_port() {
    let (address, _server) = serve(config()).await;
    assert!(request(address, "PUT", "/v1/robots/r", "{}").await.starts_with("HTTP/1.1 201"));
    let stream = TcpStream::connect(address).await.unwrap();
    let (sender, connection) =
        hyper::client::conn::http2::handshake(TokioExecutor::new(), TokioIo::new(stream))
            .await
            .unwrap();
    tokio::spawn(connection);
    // All at once on one connection, as an agent does.
    let steps = (1..=4).map(|sequence| {
        let mut sender = sender.clone();
        let body = step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0).to_string();
        let request = Request::post(format!("http://{address}/v1/robots/r/step"))
            .header("content-type", "application/json")
            .body(Body::from(body))
            .unwrap();
        async move {
            let response = sender.send_request(request).await.unwrap();
            assert_eq!(response.status(), 200);
            response.into_body().collect().await.unwrap().to_bytes()
        }
    });
    let replies = futures_util::future::join_all(steps).await;
    assert!(replies.iter().all(|reply| reply.starts_with(b"{\"horizon\"")));
}

/// Guards against: connections that say nothing hold all the places, and no one can drive any more.
/// hyper alone waits for ever for the first bytes, and for the rest of a preface of HTTP/2.
#[tokio::test]
async fn half_open_connections_are_refused_politely_and_make_room_in_time() {
    let limits = Config { max_connections: 4, header_timeout: SHORT, ..config() };
    let (address, _server) = serve(limits).await;
    let mut silent = Vec::new();
    for bytes in ["", "GET / HT", "GET / HTTP/1.1\r\nhost: localhost\r\n", "PRI * HTTP/2.0\r\n"] {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(bytes.as_bytes()).await.unwrap();
        silent.push(stream);
    }
    let refused = request(address, "GET", "/v1/robots", "").await;
    assert!(refused.starts_with("HTTP/1.1 429"), "{refused}");
    assert!(refused.contains("LIMIT_REACHED") && refused.contains("retry-after: 1"), "{refused}");
    for mut stream in silent {
        let mut rest = Vec::new();
        let closed = tokio::time::timeout(10 * SHORT, stream.read_to_end(&mut rest)).await;
        assert!(closed.is_ok(), "a connection without a request is closed");
    }
    // The place is free a moment after the close.
    while !request(address, "GET", "/v1/robots", "").await.starts_with("HTTP/1.1 200") {
        tokio::task::yield_now().await;
    }
}

#[tokio::test]
async fn a_body_that_does_not_come_is_not_waited_for() {
    let (address, _server) = serve(Config { body_timeout: SHORT, ..config() }).await;
    let head = "PUT /v1/robots/r HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n";
    let answer = talk(address, format!("{head}content-length: 10\r\n\r\n{{}}").as_bytes()).await;
    assert!(answer.starts_with("HTTP/1.1 408"), "{answer}");
    assert!(answer.contains("DEADLINE_EXCEEDED") && answer.contains("BODY_TIMEOUT"), "{answer}");
    assert!(request(address, "GET", "/v1/robots/r", "").await.starts_with("HTTP/1.1 404"));
}

#[tokio::test]
async fn a_body_that_is_too_large_is_refused_before_it_is_sent() {
    let (address, _server) = serve(config()).await;
    let head = "PUT /v1/robots/r HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n";
    let answer = talk(address, format!("{head}content-length: 99999999\r\n\r\n").as_bytes()).await;
    assert!(answer.starts_with("HTTP/1.1 413"), "{answer}");
}

/// Guards against: clients that ask every now and then lose a request to a connection that was closed without a word.
#[tokio::test]
async fn a_kept_connection_of_http_1_says_how_long_it_may_be_silent_and_is_ended_after_that() {
    let idle = Duration::from_secs(2);
    let times = Config { header_timeout: SHORT, idle_timeout: idle, ..config() };
    let (address, _server) = serve(times).await;
    let mut stream = TcpStream::connect(address).await.unwrap();
    let ask = b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n";
    // Longer than a header may take; a connection is kept somewhat longer than it is said to be.
    for silence in [Duration::ZERO, SHORT * 3 / 2] {
        tokio::time::sleep(silence).await;
        stream.write_all(ask).await.unwrap();
        let answer = one_answer(&mut stream).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert!(answer.contains("keep-alive: timeout=2\r\n"), "{answer}");
    }
    let mut rest = Vec::new();
    let closed = tokio::time::timeout(10 * idle, stream.read_to_end(&mut rest)).await;
    assert!(closed.is_ok() && rest.is_empty(), "it is closed in the end");
    let closing = request(address, "GET", "/healthz", "").await;
    assert!(!closing.contains("keep-alive"), "whoever closes needs not know: {closing}");
}

/// Guards against: a header that comes byte by byte holds its place for as long as silence may.
#[tokio::test]
async fn a_header_on_a_kept_connection_has_the_time_of_a_header() {
    let long = Duration::from_secs(3600);
    let times = Config { header_timeout: SHORT, idle_timeout: long, ..config() };
    let (address, _server) = serve(times).await;
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await.unwrap();
    assert!(one_answer(&mut stream).await.starts_with("HTTP/1.1 200"));
    stream.write_all(b"GET /healthz HTTP/1.1\r\nhost: loc").await.unwrap();
    let mut rest = Vec::new();
    let closed = tokio::time::timeout(20 * SHORT, stream.read_to_end(&mut rest)).await;
    assert!(closed.is_ok(), "it is closed");
    assert!(!String::from_utf8_lossy(&rest).contains("200 OK"));
}

/// One answer of `/healthz` on a connection that goes on.
async fn one_answer(stream: &mut TcpStream) -> String {
    let mut answer = Vec::new();
    while !answer.ends_with(b"}") {
        let read = stream.read_buf(&mut answer).await.unwrap();
        assert!(read > 0, "{}", String::from_utf8_lossy(&answer));
    }
    String::from_utf8_lossy(&answer).into_owned()
}

/// What the router is tested for in `guard` holds over both protocols.
#[tokio::test]
async fn foreign_hosts_and_pages_are_refused_over_both_protocols() {
    let (address, _server) = serve(config()).await;
    for (head, code) in [
        ("host: localhost", 200),
        ("Host: LOCALHOST.:1", 200),
        ("host: evil.example", 403),
        ("host: localhost\r\nhost: evil.example", 400),
        ("host: localhost\r\norigin: http://evil.example", 403),
        ("x-no-host: 1", 400),
    ] {
        let ask = format!(
            "POST /v1/stop HTTP/1.1\r\n{head}\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
        );
        let answer = talk(address, ask.as_bytes()).await;
        assert!(answer.starts_with(&format!("HTTP/1.1 {code}")), "{head}: {answer}");
    }
    let absolute = b"GET http://evil.example/v1/robots HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    assert!(talk(address, absolute).await.starts_with("HTTP/1.1 403"));
    let stream = TcpStream::connect(address).await.unwrap();
    let (mut sender, connection) =
        hyper::client::conn::http2::handshake(TokioExecutor::new(), TokioIo::new(stream))
            .await
            .unwrap();
    tokio::spawn(connection);
    for (authority, headers, code) in [
        ("localhost:8080", &[][..], 200),
        ("evil.example", &[], 403),
        ("localhost", &[("origin", "http://evil.example")], 403),
        ("localhost", &[("host", "evil.example")], 403),
        ("localhost", &[("sec-fetch-site", "cross-site")], 403),
    ] {
        let mut request = Request::post(format!("http://{authority}/v1/stop"));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let answer = sender.send_request(request.body(Body::empty()).unwrap()).await.unwrap();
        assert_eq!(answer.status(), code, "{authority} {headers:?}");
        assert!(answer.headers().get("keep-alive").is_none(), "HTTP/2 has none");
        assert_eq!(answer.headers()["x-content-type-options"], "nosniff");
    }
}

#[tokio::test]
async fn what_is_no_http_ends_its_connection_only() {
    let (address, _server) = serve(config()).await;
    for garbage in
        [&b"\x16\x03\x01\x02\x00\x01\x00\x01"[..], b"\r\n\r\nhello\r\n\r\n", b"GET\r\n\r\n"]
    {
        talk(address, garbage).await;
    }
    assert!(request(address, "GET", "/healthz", "").await.starts_with("HTTP/1.1 200"));
}
