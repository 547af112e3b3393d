//! The program itself: what it prints, how it ends.

use crate::sockets::request;
use std::io::{BufRead, BufReader, Read};
use std::net::{SocketAddr, TcpListener};
use std::process::{Child, Command, Output, Stdio};

pub(crate) fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umwelt-server"));
    command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    for (name, _) in std::env::vars().filter(|(name, _)| name.starts_with("UMWELT_")) {
        command.env_remove(name);
    }
    command
}

/// Starts a server and reads where it listens from its first line.
pub(crate) fn start(mut command: Command) -> (Child, SocketAddr) {
    let mut child = command.spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let address = line.trim_end().strip_prefix("listening on http://").expect(&line);
    (child, address.parse().unwrap())
}

pub(crate) fn end(mut child: Child, signal: &str) -> Output {
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    let mut stderr = Vec::new();
    child.stderr.take().unwrap().read_to_end(&mut stderr).unwrap();
    Output { status: child.wait().unwrap(), stdout: Vec::new(), stderr }
}

#[tokio::test]
async fn it_says_where_it_listens_and_ends_well_on_a_signal() {
    for signal in ["-TERM", "-INT"] {
        let (child, address) = start(program(&["serve", "--listen", "127.0.0.1:0", "--in-memory"]));
        assert!(request(address, "GET", "/readyz", "").await.starts_with("HTTP/1.1 200"));
        let output = end(child, signal);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
}

#[tokio::test]
async fn the_environment_sets_what_no_flag_does() {
    let mut command = program(&["serve", "--max-robots", "1", "--in-memory"]);
    command.env("UMWELT_LISTEN", "127.0.0.1:0").env("UMWELT_MAX_ROBOTS", "2");
    let (child, address) = start(command);
    assert!(request(address, "PUT", "/v1/robots/a", "{}").await.starts_with("HTTP/1.1 201"));
    let second = request(address, "PUT", "/v1/robots/b", "{}").await;
    assert!(second.starts_with("HTTP/1.1 429"), "the flag wins: {second}");
    assert_eq!(end(child, "-TERM").status.code(), Some(0));
}

#[test]
fn a_wrong_call_is_2_and_a_failure_is_1() {
    let output = program(&["--no-such-flag"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let output = program(&["--listen", &address, "--in-memory"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    assert!(String::from_utf8_lossy(&output.stderr).contains(&address));
}
