//! The programs as people call them: what they say, where they say it, and what they return.

use serde_json::Value;
use umwelt_tests::rover::{Agent, Simulated, id};
use umwelt_tests::said::{call, umwelt};
use umwelt_tests::server::Server;

/// Guards against: a command that works in its own tests and not against the server.
#[tokio::test]
async fn a_robot_is_described_sent_watched_and_removed_from_the_command_line() {
    let server = Server::start();
    let added = umwelt(&server, "robot add rover-7 --wheel-radius 0.021 --method statistic").await;
    assert_eq!(added["robot"], "rover-7");
    assert_eq!(added["spec"]["drive"]["wheel_radius_m"], 0.021);
    let listed = umwelt(&server, "robot list --state never").await;
    assert_eq!(listed["robots"][0]["robot"], "rover-7");
    let shown = umwelt(&server, "robot show rover-7").await;
    assert_eq!((&shown["state"], &shown["spec"]["method"]), (&"never".into(), &"statistic".into()));
    let task = umwelt(&server, "task set rover-7 --waypoint 0.2,0 --no-calibration").await;
    assert_eq!(task["spec"]["waypoints"][0]["x_m"], 0.2);
    assert_eq!(umwelt(&server, "stop rover-7").await["stopped"], true);
    assert_eq!(umwelt(&server, "robot show rover-7").await["stopped"], true);
    assert_eq!(umwelt(&server, "resume --all").await["stopped"], false);
    let environment = umwelt(&server, "environment show rover-7").await;
    assert_eq!(environment["method"], "statistic");
    umwelt(&server, "task cancel rover-7").await;
    umwelt(&server, "robot remove rover-7").await;
    assert_eq!(umwelt(&server, "robot list").await["robots"], Value::Array(Vec::new()));
}

/// Guards against: a robot's wheels and limits are wiped by whoever wants to change one thing of it.
#[tokio::test]
async fn a_robot_is_changed_in_parts_and_described_anew_only_where_that_is_meant() {
    let server = Server::start();
    umwelt(&server, "robot add Rover_7.b --wheel-radius 0.021 --max-speed 0.1").await;
    let set = umwelt(&server, "robot set Rover_7.b --prior flat --unset drive.max_linear_m_per_s");
    let drive = serde_json::json!({"wheel_radius_m": 0.021});
    assert_eq!(set.await["described"], serde_json::json!({"drive": drive, "prior": "flat"}));
    let url = server.url();
    let again = ["--server", &url, "robot", "add", "Rover_7.b", "--prior", "flat"];
    let again = call("umwelt", &again).await;
    assert_eq!(again.code, Some(1));
    assert!(again.log.contains("umwelt robot set Rover_7.b"), "{}", again.log);
    let kept = umwelt(&server, "robot show Rover_7.b").await;
    assert_eq!(kept["described"]["drive"], drive);
    let anew = umwelt(&server, "robot add Rover_7.b --prior flat --replace").await;
    assert_eq!(anew["described"], serde_json::json!({"prior": "flat"}));
}

/// Guards against: a script goes on after a call that failed, or cannot tell its own mistake from the world's.
#[tokio::test]
async fn what_fails_returns_1_what_was_wrong_returns_2_and_both_say_why() {
    let server = Server::start();
    let url = server.url();
    umwelt(&server, "robot add rover-7").await;
    let on = |arguments: &str| format!("--server {url} {arguments}");
    let cases = [
        ("umwelt", on("robot show nobody"), 1, "nobody"),
        ("umwelt", on("task set nobody --waypoint 0.2,0"), 1, "nobody"),
        ("umwelt", on("task show rover-7"), 1, "no task"),
        ("umwelt", "--server http://127.0.0.1:1 robot list".to_owned(), 1, "127.0.0.1:1"),
        ("umwelt", on("task set rover-7 --waypoint 0.2"), 2, "0.2"),
        ("umwelt", on("task set rover-7 --waypoint 1e9,0"), 2, "waypoints[0].x_m"),
        ("umwelt", on("robot add _rover"), 2, "_rover"),
        ("umwelt", on("robot add rover-7 --slots 1000"), 2, "horizon_slots"),
        ("umwelt", on("robot fly rover-7"), 2, "fly"),
        ("umwelt", "--server nowhere robot list".to_owned(), 2, "nowhere"),
        ("umwelt-server", format!("--in-memory --listen {}", server.address), 1, "listen"),
        ("umwelt-server", "--listen here".to_owned(), 2, "here"),
        ("umwelt-agent", format!("--server {url} --robot .rover --drive sim"), 2, ".rover"),
        ("umwelt-agent", format!("--server {url} --robot rover-7 --drive wings"), 2, "wings"),
        (
            "umwelt-agent",
            format!("--server {url} --robot rover-7 --drive sim --link worse"),
            2,
            "worse",
        ),
    ];
    for (program, arguments, code, word) in cases {
        let said = call(program, &arguments.split_whitespace().collect::<Vec<_>>()).await;
        let what = format!("{program} {arguments}: {:?} {}", said.output, said.log);
        assert_eq!(said.code, Some(code), "{what}");
        assert!(said.log.contains(word), "{what}");
        assert!(said.output.is_empty(), "standard output is for results: {what}");
    }
}

/// Guards against: `--watch` ends before the robot is there, or never.
#[tokio::test]
async fn a_watched_task_ends_with_the_arrival() {
    let server = Server::start();
    umwelt(&server, "robot add rover-7").await;
    let agent = Agent::start(&server.url(), &id("rover-7"), Simulated::default());
    let url = server.url();
    let arguments = format!(
        "--server {url} --json task set rover-7 --waypoint 0.05,0 --no-calibration --watch"
    );
    let said = call("umwelt", &arguments.split_whitespace().collect::<Vec<_>>()).await;
    assert_eq!(said.code, Some(0), "{}", said.log);
    let last: Value = serde_json::from_str(said.output.last().unwrap()).unwrap();
    assert_eq!(last["progress"]["stage"], "arrived", "{last}");
    agent.end().await;
}
