//! Programs that do one thing and end: what they returned and said.

use crate::process::{Process, SOON};
use crate::server::Server;
use serde_json::Value;
use std::time::Duration;

/// What a program returned and said.
#[derive(Clone, Debug)]
pub struct Said {
    /// Its exit status; none where a signal ended it.
    pub code: Option<i32>,
    /// The lines of its standard output.
    pub output: Vec<String>,
    /// Its standard error.
    pub log: String,
}

/// Runs `program` to its end.
///
/// # Panics
/// Where it does not end [`SOON`].
pub async fn call(program: &str, arguments: &[&str]) -> Said {
    call_within(program, arguments, SOON).await
}

/// The same for what takes longer.
///
/// # Panics
/// Where it does not end `within` the time.
pub async fn call_within(program: &str, arguments: &[&str], within: Duration) -> Said {
    let mut process = Process::start(program, arguments);
    let status = process.end(within).await;
    Said { code: status.code(), output: process.lines(), log: process.log() }
}

/// Calls `umwelt --json` on `server`, which must succeed with one document on standard output and nothing else.
///
/// # Panics
/// Where it does not.
pub async fn umwelt(server: &Server, arguments: &str) -> Value {
    let url = server.url();
    let all: Vec<&str> =
        ["--server", &url, "--json"].into_iter().chain(arguments.split_whitespace()).collect();
    json(&call("umwelt", &all).await, arguments)
}

/// What `umwelt-server evolve --json` finds, which must succeed `within` the time.
///
/// # Panics
/// Where it does not.
pub async fn evolve(arguments: &str, within: Duration) -> Value {
    offline("evolve", arguments, within).await
}

/// What `umwelt-server compare --json` finds, which must succeed `within` the time.
///
/// # Panics
/// Where it does not.
pub async fn compare(arguments: &str, within: Duration) -> Value {
    offline("compare", arguments, within).await
}

async fn offline(command: &str, arguments: &str, within: Duration) -> Value {
    let all: Vec<&str> =
        [command, "--json"].into_iter().chain(arguments.split_whitespace()).collect();
    json(&call_within("umwelt-server", &all, within).await, arguments)
}

fn json(said: &Said, arguments: &str) -> Value {
    assert_eq!(said.code, Some(0), "{arguments}: {}", said.log);
    let text = said.output.join("\n");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{arguments}: {error}: {text}"))
}
