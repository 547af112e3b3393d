//! A server with a token: operators and robots that have it work as ever, all others get nothing, and no one ever shows it.

use super::{describe, straight_to};
use std::fs;
use umwelt_client::api::problem::Status;
use umwelt_client::{Client, read_token};
use umwelt_tests::data::Data;
use umwelt_tests::process::{Process, SOON, Signal};
use umwelt_tests::rover::id;
use umwelt_tests::said::{Said, call};
use umwelt_tests::server::Server;
use umwelt_tests::wait;

const SECRET: &str = "kept-by-operators-and-robots-alone";
const WRONG: &str = "kept-by-operators-and-robots-alonE";

/// Guards against: a part of the system that cannot show its token, or shows it to everybody.
#[tokio::test]
async fn whoever_has_the_token_drives_and_no_one_else_and_it_is_never_shown() {
    let folder = Data::new();
    let (right, wrong) = (folder.file("token"), folder.file("wrong"));
    fs::write(&right, format!("{SECRET}\n")).unwrap();
    fs::write(&wrong, WRONG).unwrap();
    let (right, wrong) = (right.to_str().unwrap(), wrong.to_str().unwrap());
    let mut server = Server::start_with(&["--token-file", right, "--log", "trace"]);
    let url = server.url();
    let umwelt = async |token: &[&str], arguments: &str| -> Said {
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        call("umwelt", &[&["--server", &url], token, &arguments].concat()).await
    };
    let mut said = Vec::new();

    for token in [&[][..], &["--token-file", wrong]] {
        let refused = umwelt(token, "stop --all").await;
        assert_eq!(refused.code, Some(1), "{}", refused.log);
        assert!(refused.log.contains("UNAUTHENTICATED"), "{}", refused.log);
        assert!(refused.log.contains("--token-file"), "{}", refused.log);
        said.push(refused);
    }
    assert_eq!(server.client.health().await.unwrap().status, "ok");
    assert_eq!(server.client.ready().await.unwrap_err().status(), Some(Status::Unauthenticated));
    let added = umwelt(&["--token-file", right], "robot add rover-7").await;
    assert_eq!(added.code, Some(0), "{}", added.log);
    said.push(added);

    let client = Client::authorized(&url, Some(read_token(right.as_ref()).unwrap())).unwrap();
    let robot = id("rover-7");
    describe(&client, "rover-7").await;
    client.set_task(&robot, &straight_to(0.1)).await.unwrap();
    let agent = |token: &str| {
        let flags =
            ["--server", &url, "--robot", "rover-7", "--token-file", token, "--log", "trace"];
        Process::start("umwelt-agent", &flags)
    };
    let mut stranger = agent(wrong);
    let refused = async || stranger.log().contains("UNAUTHENTICATED").then_some(());
    wait::until("the stranger is refused", SOON, refused).await;
    assert!(client.get_robot(&robot).await.unwrap().pose.is_none(), "nothing of it was taken");
    let mut own = agent(right);
    let sees = async || client.get_robot(&robot).await.unwrap().pose;
    wait::until("the robot is seen", SOON, sees).await;
    for process in [&mut stranger, &mut own, &mut server.process] {
        process.signal(Signal::Terminate);
        assert!(process.end(SOON).await.success());
    }

    let logs = [stranger.log(), own.log(), server.process.log()];
    assert!(logs.iter().all(|log| log.len() > 100), "they were told to say everything");
    let words = said.iter().flat_map(|said| said.output.iter().chain([&said.log])).chain(&logs);
    for words in words {
        assert!(!words.contains(SECRET) && !words.contains(WRONG), "{words}");
    }
}
