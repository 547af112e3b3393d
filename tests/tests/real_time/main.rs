//! Robots in real time: run alone and one at a time (`--test-threads=1`), in about two minutes.
//!
//! Where a test waits for a fixed time, that is how long a fault lasts, not a hope that something has happened.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod agreement;
mod check;
mod comparison;
mod faults;
mod fleet;
mod kills;
mod outage;
mod pause;
mod pipe;
mod shutdown;

use std::path::PathBuf;
use std::time::Duration;
use umwelt_agent::TraceRow;
use umwelt_api::RobotId;
use umwelt_api::robot::Pose;
use umwelt_api::task::Stage;
use umwelt_client::Client;
use umwelt_core::geometry::Point;
use umwelt_core::task::{TOLERANCE, Task};
use umwelt_tests::process::{Process, SOON, Signal};
use umwelt_tests::rover::id;
use umwelt_tests::{trace, wait};

/// Time to arrive in: several times what any task here takes.
const ARRIVAL: Duration = Duration::from_secs(60);

/// Robot time in s within which a robot rests whose link has gone: the loop delay of 0.23 s, a horizon of 0.6 s, the
/// watchdog of 0.3 s and the ramp of 0.43 s, and half as much again for a busy machine.
const REST_AFTER: f64 = 2.5;

/// Straight to (`x`, 0), without calibration.
fn straight_to(x: f64) -> Task {
    Task {
        waypoints: vec![Point::new(x, 0.0)],
        tolerance: TOLERANCE,
        reverse: false,
        calibration: None,
        max_deviation: None,
        check: None,
        square: None,
    }
}

/// Describes the robot `name`, all by default, and gives it a task.
async fn give(client: &Client, name: &str, task: &Task) -> RobotId {
    let robot = id(name);
    client.put_robot(&robot, &Default::default()).await.unwrap();
    client.set_task(&robot, &task.into()).await.unwrap();
    robot
}

/// Waits until the server has seen the robot beyond `x_m`, and returns where.
async fn passed(client: &Client, robot: &RobotId, x_m: f64) -> Pose {
    wait::until(&format!("{robot} passes {x_m} m"), ARRIVAL, async || {
        client.get_robot(robot).await.unwrap().pose.filter(|pose| pose.x_m > x_m)
    })
    .await
}

/// Waits until the robot has arrived.
async fn arrived(client: &Client, robot: &RobotId) {
    wait::until(&format!("{robot} arrives"), ARRIVAL, async || {
        let progress = client.get_task(robot).await.unwrap().progress;
        (progress.stage == Stage::Arrived).then_some(())
    })
    .await;
}

/// The agent of a simulated robot as a process, with its trace.
struct AgentProcess {
    process: Process,
    trace: PathBuf,
}

impl AgentProcess {
    fn start(url: &str, robot: &RobotId) -> Self {
        let trace = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{robot}.csv"));
        let path = trace.to_str().expect("a path of text").to_owned();
        let arguments = ["--server", url, "--robot", robot.as_str(), "--drive", "sim"];
        let more = ["--seed", "3", "--trace", &path];
        Self { process: Process::start("umwelt-agent", &[&arguments[..], &more].concat()), trace }
    }

    /// Ends it with SIGTERM, which must give 0; returns its trace.
    async fn end(mut self) -> Vec<TraceRow> {
        self.process.signal(Signal::Terminate);
        let status = self.process.end(SOON).await;
        assert_eq!(status.code(), Some(0), "{}", self.process.log());
        trace::read(&self.trace)
    }
}

/// Checks that the robot of `rows` stands at (`x`, 0) in the end.
fn assert_stands_at(rows: &[TraceRow], x: f64) {
    let last = rows.last().unwrap();
    let point = last.pose.unwrap().point();
    // Seen within the tolerance, by a camera that may be wrong by four standard deviations of 0.5 mm.
    let distance = point.distance_to_segment(Point::new(x, 0.0), Point::new(x, 0.0));
    assert!(distance < TOLERANCE + 0.002, "{distance} m off: {last:?}");
    trace::assert_rests(rows, last.time, last.time);
}
