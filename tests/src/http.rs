//! Requests byte by byte, for what the typed client refuses to send.

use crate::process::SOON;
use crate::wait;
use serde_json::Value;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Its HTTP status.
    pub code: u16,
    /// Its header, names in lower case.
    pub headers: Vec<(String, String)>,
    /// Its body.
    pub body: String,
}

impl Answer {
    /// The value of the header `name`, in lower case.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// The body as JSON, null where it is none.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_default()
    }

    /// Whether none of the body is missing.
    fn is_whole(&self) -> bool {
        let length = self.header("content-length").and_then(|length| length.parse().ok());
        length.is_none_or(|length: usize| length == self.body.len())
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let text = String::from_utf8_lossy(bytes);
        let (head, body) = text.split_once("\r\n\r\n")?;
        let (first, headers) = head.split_once("\r\n").unwrap_or((head, ""));
        let code = first.strip_prefix("HTTP/1.1 ")?.get(..3)?.parse().ok()?;
        let headers = headers.lines().filter_map(|line| line.split_once(": "));
        let headers = headers.map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned()));
        Some(Self { code, headers: headers.collect(), body: body.to_owned() })
    }
}

/// One request over a connection of its own. The body is declared as JSON unless `headers` say otherwise.
///
/// # Panics
/// Where no answer comes.
pub async fn call(
    server: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &[u8],
) -> Answer {
    let what = format!("{method} {path}");
    let all = request(server, method, path, headers, body);
    let bytes = wait::within(&what, SOON, send(server, &all)).await;
    let said = String::from_utf8_lossy(&bytes);
    Answer::read(&bytes).unwrap_or_else(|| panic!("{what}: no answer but {said:?}"))
}

/// The same of a server that may die meanwhile: none where no whole answer comes.
///
/// # Panics
/// Where neither an answer nor an end comes.
pub async fn attempt(
    server: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &[u8],
) -> Option<Answer> {
    let all = request(server, method, path, headers, body);
    let bytes = wait::within(&format!("{method} {path}"), SOON, try_send(server, &all)).await?;
    Answer::read(&bytes).filter(Answer::is_whole)
}

/// The same of a server that may also stand still: none where no whole answer comes `within` the time.
pub async fn attempt_within(
    server: SocketAddr,
    method: &str,
    path: &str,
    body: &[u8],
    within: Duration,
) -> Option<Answer> {
    let all = request(server, method, path, &[], body);
    let bytes = tokio::time::timeout(within, try_send(server, &all)).await.ok()??;
    Answer::read(&bytes).filter(Answer::is_whole)
}

/// The bytes of a request.
fn request(
    server: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &[u8],
) -> Vec<u8> {
    let mut head = format!(
        "{method} {path} HTTP/1.1\r\nHost: {server}\r\nConnection: close\r\nContent-Length: {}\r\n",
        body.len()
    );
    if !headers.iter().any(|(name, _)| name.eq_ignore_ascii_case("content-type")) {
        head.push_str("Content-Type: application/json\r\n");
    }
    for (name, value) in headers {
        head.push_str(&format!("{name}: {value}\r\n"));
    }
    head.push_str("\r\n");
    [head.as_bytes(), body].concat()
}

/// Sends `bytes` and returns everything that comes back until the server closes the connection.
///
/// # Panics
/// Where no one listens.
pub async fn send(server: SocketAddr, bytes: &[u8]) -> Vec<u8> {
    try_send(server, bytes).await.expect("the server listens")
}

/// The same; none where no one listens.
async fn try_send(server: SocketAddr, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut stream = TcpStream::connect(server).await.ok()?;
    // A server that refuses a body need not read it: what it says all the same is what counts.
    let _ = stream.write_all(bytes).await;
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer).await;
    Some(answer)
}
