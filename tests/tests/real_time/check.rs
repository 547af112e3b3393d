//! `umwelt robot check` over real processes: a robot behind pipes that is well, and one with a motor the wrong way round.

use crate::ARRIVAL;
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::kinematics::{self, Drive};
use umwelt_tests::process::{Process, SOON};
use umwelt_tests::rover::id;
use umwelt_tests::said::{Said, call, call_within};
use umwelt_tests::server::Server;
use umwelt_tests::wait;

/// Lines of wheel speeds between two frames: some 11 a second.
const LINES: usize = 3;

/// A robot that moves as the lines of its agent say, its left wheel times `left`, until `is_over`.
fn drive(mut agent: Process, left: f64, is_over: Arc<AtomicBool>) -> JoinHandle<Process> {
    thread::spawn(move || {
        let (drive, mut pose) = (Drive::default(), Pose::new(0.4, 0.2, 0.5));
        let mut before: Option<(f64, WheelSpeeds)> = None;
        let (mut read, mut is_open) = (0, true);
        while let Some(line) = agent.line(read) {
            let value: Value = serde_json::from_str(&line).unwrap();
            let number = |name: &str| value[name].as_f64().unwrap();
            let time = number("t_s");
            let (last, speeds) = before.unwrap_or((time, WheelSpeeds::ZERO));
            let twist = kinematics::forward(&drive, speeds);
            pose = pose.then(kinematics::integrate(twist, time - last));
            let right = number("right_rad_per_s");
            before = Some((time, WheelSpeeds { left: left * number("left_rad_per_s"), right }));
            if is_open && is_over.load(Ordering::Relaxed) {
                agent.close_input();
                is_open = false;
            } else if is_open && read.is_multiple_of(LINES) {
                let (x, y, heading) = (pose.x, pose.y, pose.heading.radians());
                let frame = json!({"t_s": time, "x_m": x, "y_m": y, "heading_rad": heading});
                agent.write_line(&frame.to_string());
            }
            read += 1;
        }
        agent
    })
}

async fn check(url: &str, robot: &str) -> Said {
    let arguments = ["--server", url, "--json", "robot", "check", robot];
    call_within("umwelt", &arguments, ARRIVAL).await
}

fn report(said: &Said) -> Value {
    let text = said.output.join("\n");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text} {}", said.log))
}

/// Guards against: the newcomer's first command says that all is well, or names another mistake than there is.
#[tokio::test(flavor = "multi_thread")]
async fn a_robot_that_is_well_and_one_with_an_inverted_motor_are_told_apart() {
    let server = Server::start();
    let url = server.url();
    let mut running = Vec::new();
    for (name, left) in [("well", 1.0), ("inverted", -1.0)] {
        server.client.put_robot(&id(name), &Default::default()).await.unwrap();
        let said = call("umwelt", &["--server", &url, "robot", "check", name]).await;
        assert_eq!(said.code, Some(1), "it was never seen: {}", said.log);
        assert!(said.log.contains("start its agent"), "{}", said.log);
        let arguments = ["--server", &url, "--robot", name, "--drive", "pipe"];
        let agent = Process::start_with_input("umwelt-agent", &arguments);
        let is_over = Arc::new(AtomicBool::new(false));
        running.push((name, drive(agent, left, Arc::clone(&is_over)), is_over));
    }
    for (name, ..) in &running {
        wait::until(&format!("{name} is seen"), SOON, async || {
            server.client.get_robot(&id(name)).await.unwrap().pose
        })
        .await;
    }
    let (well, inverted) = tokio::join!(check(&url, "well"), check(&url, "inverted"));
    let found = report(&inverted);
    assert_eq!(found["findings"][0]["name"], "left-wheel-inverted", "{found}");
    assert_eq!((found["findings"][1].as_object(), inverted.code), (None, Some(1)), "{found}");
    let found = report(&well);
    assert_eq!((&found["findings"], well.code), (&json!([]), Some(0)), "{found} {}", well.log);
    for ratio in ["forward_ratio", "turn_ratio"] {
        assert!((found[ratio].as_f64().unwrap() - 1.0).abs() < 0.05, "{found}");
    }
    assert!(found["delay_s"].as_f64().unwrap().abs() < 0.1, "{found}");
    assert!(well.log.contains("around it free"), "{}", well.log);
    for (name, robot, is_over) in running {
        is_over.store(true, Ordering::Relaxed);
        wait::until(&format!("{name} ends"), SOON, async || robot.is_finished().then_some(()))
            .await;
        let mut agent = robot.join().unwrap();
        assert_eq!(agent.end(SOON).await.code(), Some(0), "{}", agent.log());
    }
}
