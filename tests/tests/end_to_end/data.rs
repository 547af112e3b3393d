//! The data directory: copied while in use, refused where it cannot be used.

use super::evolutions::{EVOLUTION, endless, get, goes_on, submit, until};
use super::{describe, straight_to};
use std::fs;
use umwelt_tests::data::Data;
use umwelt_tests::http;
use umwelt_tests::process::{SOON, Signal};
use umwelt_tests::rover::{self, Agent, Simulated};
use umwelt_tests::said::{Said, call, call_within};
use umwelt_tests::server::Server;

/// A server that must be refused.
async fn refused(data: &str) -> Said {
    let said = call("umwelt-server", &["--listen", "127.0.0.1:0", "--data", data]).await;
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.output.is_empty() && !said.log.contains("panicked"), "{said:?}");
    assert!(said.log.contains(data), "it says which: {said:?}");
    said
}

/// Guards against: a copy of a moving thing, of which half is from before and half from after, or none at all.
#[tokio::test]
async fn a_backup_while_everything_goes_on_is_a_server_of_its_own() {
    let data = Data::new();
    let server = Server::start_with(&["--data", data.text()]);
    for (path, body) in [
        ("/v1/priors/wet-hall", r#"{"note": "n"}"#),
        ("/v1/environments/oily", r#"{"slip": "oily", "link": "bad"}"#),
        ("/v1/robots/parked", r#"{"prior": "wet-hall"}"#),
    ] {
        let put = http::call(server.address, "PUT", path, &[], body.as_bytes()).await;
        assert_eq!(put.code, 201, "{path}: {put:?}");
    }
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(20.0)).await.unwrap();
    let mut agent = Agent::start(&server.url(), &robot, Simulated::default());
    agent.until("the robot drives", SOON, rover::drives).await;
    let path = submit(&server, &endless()).await;
    let seen = until(&server, &path, "a generation", goes_on).await;

    let file = data.file("copy");
    let file = file.to_str().unwrap();
    let arguments = ["backup", file, "--data", data.text()];
    let said = call_within("umwelt-server", &arguments, EVOLUTION).await;
    assert_eq!(said.code, Some(0), "{said:?}");
    for word in ["2 robots", "1 priors", "1 environments", "1 evolutions"] {
        assert!(said.output.join("\n").contains(word), "{word}: {said:?}");
    }
    let again = call_within("umwelt-server", &arguments, EVOLUTION).await;
    assert_eq!(again.code, Some(1), "it replaces nothing: {again:?}");
    assert!(again.log.contains("exists"), "{again:?}");
    let generation = |it: &serde_json::Value| it["progress"]["generation"].as_u64();
    let farther = |it: &serde_json::Value| generation(it) > generation(&seen);
    until(&server, &path, "the evolution goes on", farther).await;
    let later = agent.status().time + 0.5;
    agent.until("the robot goes on", SOON, |now| now.time > later && rover::drives(now)).await;

    let other = Data::new();
    fs::copy(file, other.file("umwelt.sqlite")).unwrap();
    let copy = Server::start_with(&["--data", other.text()]);
    for path in ["/v1/priors/wet-hall", "/v1/environments/oily", "/v1/robots/parked"] {
        assert_eq!(get(&copy, path).await, get(&server, path).await, "{path}");
    }
    let rover = get(&copy, "/v1/robots/rover-7/task").await;
    assert_eq!(rover["spec"], get(&server, "/v1/robots/rover-7/task").await["spec"]);
    let found = get(&copy, &path).await;
    assert_eq!((&found["spec"], &found["interrupted"]), (&seen["spec"], &1.into()));
    assert!(generation(&found) >= generation(&seen), "{found}");
    let generations = get(&copy, &format!("{path}/generations")).await;
    let originals = get(&server, &format!("{path}/generations")).await;
    assert_eq!(generations["generations"][0], originals["generations"][0]);
    agent.end().await;
}

/// Guards against: two servers write into one file, or the second ends the first.
#[tokio::test]
async fn a_second_server_on_the_same_data_is_refused() {
    let data = Data::new();
    let server = Server::start_with(&["--data", data.text()]);
    let said = refused(data.text()).await;
    assert!(said.log.contains("in use by another umwelt-server"), "{said:?}");
    describe(&server.client, "rover-7").await;
    drop(server);
    let server = Server::start_with(&["--data", data.text()]);
    get(&server, "/v1/robots/rover-7").await;
}

/// Guards against: a server that begins anew where it cannot read what it had, or that takes in what it cannot keep.
#[tokio::test]
async fn data_that_cannot_be_used_is_refused_and_left_as_it_is() {
    let damaged = Data::new();
    let mut server = Server::start_with(&["--data", damaged.text()]);
    describe(&server.client, "rover-7").await;
    server.process.signal(Signal::Terminate);
    assert_eq!(server.process.end(SOON).await.code(), Some(0));
    let file = damaged.file("umwelt.sqlite");
    let garbage = vec![b'x'; 8192];
    fs::write(&file, &garbage).unwrap();
    let said = refused(damaged.text()).await;
    assert!(said.log.contains("umwelt.sqlite"), "{said:?}");
    assert_eq!(fs::read(&file).unwrap(), garbage, "nobody has asked it to be replaced");

    // Even root cannot write in /proc, nor make a directory there or below a file.
    for directory in [damaged.file("umwelt.sqlite"), "/proc".into(), "/proc/umwelt".into()] {
        let said = refused(directory.to_str().unwrap()).await;
        assert!(said.log.contains("--data"), "it says what to do: {said:?}");
    }
    let nothing = Data::new();
    let backup = ["backup", "/proc/copy", "--data", nothing.text()];
    let said = call("umwelt-server", &backup).await;
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.log.contains("no data file"), "{said:?}");
}
