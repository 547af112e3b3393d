//! A robot behind two pipes: a camera that writes poses and motors that read wheel speeds.

use crate::{ARRIVAL, arrived, give, straight_to};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use umwelt_agent::TraceRow;
use umwelt_core::geometry::{Point, Pose, Twist, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::task::{TOLERANCE, Task};
use umwelt_tests::process::{Process, SOON};
use umwelt_tests::server::Server;
use umwelt_tests::{trace, wait};

/// There and back, in m.
const THERE: f64 = 0.15;
const BACK: f64 = 0.0;

/// Longest time in s without a line: a motor driver that hears nothing for so long stops by itself.
const QUIET: f64 = 0.3;

/// What is said on the pipes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Speech {
    /// Poses with their time, wheel speeds.
    Stamped,
    /// Poses without a time, wheel speeds.
    Unstamped,
    /// Poses with their time, body speeds.
    Twist,
}

/// The script: it takes a line of speeds, has moved as the line before said, and writes the frames that its camera has
/// taken meanwhile.
struct Script {
    agent: Process,
    speech: Speech,
    pose: Pose,
    /// Time in s between two frames, and of the next one.
    period: f64,
    next_frame: f64,
    rows: Vec<TraceRow>,
}

impl Script {
    fn start(server: &Server, robot: &str, speech: Speech, period: f64) -> Self {
        let url = server.url();
        let mut arguments = vec!["--server", &url, "--robot", robot, "--drive", "pipe"];
        if speech == Speech::Twist {
            arguments.extend(["--output", "twist"]);
        }
        let agent = Process::start_with_input("umwelt-agent", &arguments);
        let (pose, next_frame) = (Pose::default(), f64::NEG_INFINITY);
        Self { agent, speech, pose, period, next_frame, rows: Vec::new() }
    }

    /// Runs until `is_enough`, then closes the agent's input and takes what still comes.
    fn run(mut self, is_enough: impl Fn(&Pose) -> bool) -> Self {
        let mut is_open = true;
        while let Some(line) = self.agent.line(self.rows.len()) {
            let (time, applied) = self.read(&line);
            let before = *self.rows.last().unwrap_or(&TraceRow { time, pose: None, applied });
            assert!(time >= before.time, "time goes back: {line}");
            let began = self.pose;
            let twist = kinematics::forward(&Drive::default(), before.applied);
            let at = |when: f64| began.then(kinematics::integrate(twist, when - before.time));
            self.next_frame = self.next_frame.max(before.time);
            while is_open && self.next_frame <= time {
                let said = self.said(self.next_frame, &at(self.next_frame));
                let is_taken = self.agent.write_line(&said);
                assert!(is_taken, "the agent reads: {}", self.agent.log());
                self.next_frame += self.period;
            }
            self.pose = at(time);
            self.rows.push(TraceRow { time, pose: Some(self.pose), applied });
            if is_open && is_enough(&self.pose) {
                self.agent.close_input();
                is_open = false;
            }
        }
        self
    }

    fn read(&self, line: &str) -> (f64, WheelSpeeds) {
        let value: Value = serde_json::from_str(line)
            .unwrap_or_else(|error| panic!("{error} on standard output: {line}"));
        let number = |name: &str| value[name].as_f64().unwrap_or_else(|| panic!("{name}: {line}"));
        assert_eq!(value.as_object().map(|fields| fields.len()), Some(3), "{line}");
        let speeds = if self.speech == Speech::Twist {
            let twist = Twist::new(number("linear_m_per_s"), number("angular_rad_per_s"));
            kinematics::inverse(&Drive::default(), twist)
        } else {
            WheelSpeeds { left: number("left_rad_per_s"), right: number("right_rad_per_s") }
        };
        (number("t_s"), speeds)
    }

    /// A frame.
    fn said(&self, time: f64, pose: &Pose) -> String {
        let (x, y, heading) = (pose.x, pose.y, pose.heading.radians());
        let mut line = json!({"x_m": x, "y_m": y, "heading_rad": heading});
        if self.speech != Speech::Unstamped {
            line["t_s"] = json!(time);
        }
        line.to_string()
    }

    /// Checks that the agent ended well, with zeros, and kept every limit on the way.
    async fn end(mut self) -> Vec<TraceRow> {
        let status = self.agent.end(SOON).await;
        assert_eq!(status.code(), Some(0), "{}", self.agent.log());
        let last = self.rows.last().unwrap();
        assert_eq!((last.applied.left, last.applied.right), (0.0, 0.0), "{last:?}");
        trace::assert_within_limits(&self.rows, &Drive::default());
        let quiet = self.rows.windows(2).map(|pair| pair[1].time - pair[0].time);
        let quiet = quiet.fold(0.0, f64::max);
        assert!(quiet < QUIET, "nothing for {quiet} s");
        self.rows
    }
}

/// Guards against: the one way in which a real robot is attached works in no other than the author's hands: with a
/// camera whose frames keep step with the slots, and a delay that fills up the nominal one.
#[tokio::test(flavor = "multi_thread")]
async fn robots_behind_pipes_go_there_and_back() {
    let server = Server::start();
    let task = Task {
        waypoints: vec![Point::new(THERE, 0.0), Point::new(BACK, 0.0)],
        ..straight_to(BACK)
    };
    let mut running = Vec::new();
    for (name, speech, frames_per_s) in [
        ("motion-capture", Speech::Stamped, 240.0),
        ("camera", Speech::Stamped, 60.0),
        ("slow-camera", Speech::Stamped, 25.0),
        ("unstamped", Speech::Unstamped, 30.0),
        ("twist", Speech::Twist, 1.0 / SLOT),
    ] {
        let robot = give(&server.client, name, &task).await;
        let script = Script::start(&server, name, speech, 1.0 / frames_per_s);
        let is_enough = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&is_enough);
        let script = thread::spawn(move || script.run(|_| told.load(Ordering::Relaxed)));
        running.push((robot, script, is_enough));
    }
    for (robot, script, is_enough) in running {
        arrived(&server.client, &robot).await;
        is_enough.store(true, Ordering::Relaxed);
        let rows = end(script).await.end().await;
        let farthest = rows.iter().map(|row| row.pose.unwrap().x).fold(0.0, f64::max);
        assert!((farthest - THERE).abs() < TOLERANCE, "{robot} turned at {farthest} m");
        crate::assert_stands_at(&rows, BACK);
    }
}

/// Guards against: the camera's program dies and the robot drives on.
#[tokio::test(flavor = "multi_thread")]
async fn a_robot_whose_poses_end_ramps_to_rest() {
    let server = Server::start();
    give(&server.client, "blind", &straight_to(2.0)).await;
    let script = Script::start(&server, "blind", Speech::Stamped, SLOT);
    let script = thread::spawn(move || script.run(|pose| pose.x > 0.10));
    let rows = end(script).await.end().await;
    let drive = Drive::default();
    let fastest = rows.iter().map(|row| trace::twist(&drive, row).linear).fold(0.0, f64::max);
    // As long as its scale is not known it may be faster than it seems.
    assert!(fastest > 0.7 * drive.max_linear, "{fastest} m/s");
    let (closed, last) = (rows.iter().find(|row| row.pose.unwrap().x > 0.10), rows.last());
    let took = last.unwrap().time - closed.unwrap().time;
    assert!(took < 1.0, "it took {took} s");
}

async fn end(script: thread::JoinHandle<Script>) -> Script {
    wait::until("the end of the agent", ARRIVAL, async || script.is_finished().then_some(())).await;
    script.join().unwrap()
}
