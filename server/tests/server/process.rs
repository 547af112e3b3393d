//! The program itself: what it prints, how it ends.

use crate::sockets::{request, talk};
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

/// Guards against: a server that the whole network can drive, started by someone who never thought of it.
#[tokio::test]
async fn other_machines_are_listened_for_with_a_token_or_at_ones_own_risk() {
    let folder = tempfile::tempdir().unwrap();
    let (file, short) = (folder.path().join("token"), folder.path().join("short"));
    std::fs::write(&file, "0123456789abcdef\n").unwrap();
    std::fs::write(&short, "hunter2\n").unwrap();
    let (file, short) = (file.to_str().unwrap(), short.to_str().unwrap());
    let all = ["--in-memory", "--listen", "0.0.0.0:0"];
    for (flags, word) in [
        (&[][..], "--token-file"),
        (&["--token-file", short], "a token has 16 to 256 characters"),
        (&["--token-file", "/nonexistent/token"], "/nonexistent/token"),
        (&["--token-file", file, "--allow-insecure"], "cannot be used with"),
    ] {
        let output = program(&[&all[..], flags].concat()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(word) && !said.contains("hunter2"), "{said}");
        assert!(output.stdout.is_empty(), "it never listened");
    }
    for (flags, code, word) in [
        (["--token-file", file].as_slice(), "HTTP/1.1 401", "in the clear"),
        (&["--allow-insecure"], "HTTP/1.1 200", "--allow-insecure"),
    ] {
        let (child, address) = start(program(&[&all[..], flags].concat()));
        let near = (std::net::Ipv4Addr::LOCALHOST, address.port()).into();
        let answer = request(near, "POST", "/v1/stop", "").await;
        assert!(answer.starts_with(code), "{answer}");
        let output = end(child, "-TERM");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("WARN") && said.contains(word), "{said}");
        assert!(!said.contains("0123456789abcdef"), "{said}");
    }
}

#[tokio::test]
async fn who_may_ask_can_be_said_in_the_environment() {
    let mut command = program(&["--in-memory", "--listen", "127.0.0.1:0"]);
    command.env("UMWELT_CORS_ORIGIN", "http://localhost:3000,https://robots.example");
    command.env("UMWELT_ALLOW_HOST", "robots.example,lab");
    let (child, address) = start(command);
    let ask = |origin: &str, host: &str| {
        format!(
            "GET /v1/robots HTTP/1.1\r\nhost: {host}\r\norigin: {origin}\r\nconnection: close\r\n\r\n"
        )
    };
    for (origin, host, code) in [
        ("http://localhost:3000", "lab", 200),
        ("https://robots.example", "localhost", 200),
        ("https://robots.example", "robots.example", 200),
        ("https://robots.example:444", "lab", 403),
        ("http://localhost:3000", "else", 403),
    ] {
        let answer = talk(address, ask(origin, host).as_bytes()).await;
        assert!(answer.starts_with(&format!("HTTP/1.1 {code}")), "{origin} {host}: {answer}");
    }
    assert_eq!(end(child, "-TERM").status.code(), Some(0));
}

/// Guards against a change of a robot that the log does not tell, or tells twice.
#[tokio::test]
async fn every_change_of_a_robot_is_one_line_of_the_log() {
    let arguments = ["serve", "--listen", "127.0.0.1:0", "--in-memory", "--log", "info"];
    let (child, address) = start(program(&arguments));
    let ask = async |method: &str, path: &str, body: &str| {
        let answer = request(address, method, &format!("/v1/robots/rover-7{path}"), body).await;
        assert!(answer.starts_with("HTTP/1.1 20"), "{method} {path}: {answer}");
    };
    let step = |epoch| format!(r#"{{"sequence":1,"epoch":{epoch},"sent_s":1.0}}"#);
    ask("PUT", "", "{}").await;
    ask("PUT", "/task", r#"{"waypoints":[{"x_m":1.0,"y_m":0.0}]}"#).await;
    ask("POST", "/step", &step(1)).await;
    ask("POST", "/step", &step(2)).await;
    ask("POST", "/stop", "").await;
    ask("POST", "/resume", "").await;
    ask("DELETE", "/task", "").await;
    ask("POST", "/environment/reset", "").await;
    ask("DELETE", "", "").await;
    let log = String::from_utf8(end(child, "-TERM").stderr).unwrap();
    let of_robot: Vec<_> = log.lines().filter(|line| line.contains("robot=rover-7")).collect();
    let told = [
        ("robot described", true),
        ("task set", true),
        ("robot connected", false),
        ("robot taken over", false),
        ("robot stopped", true),
        ("robot resumed", true),
        ("task cancelled", true),
        ("environment reset", true),
        ("robot removed", true),
    ];
    assert_eq!(of_robot.len(), told.len(), "{log}");
    for (line, (words, has_peer)) in of_robot.iter().zip(told) {
        assert!(line.contains("INFO") && line.contains(words), "{words}: {line}");
        assert_eq!(line.contains("peer=127.0.0.1"), has_peer, "{line}");
    }
}
