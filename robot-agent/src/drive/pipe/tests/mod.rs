mod replies;

use super::*;
use crate::report::{AgentError, Ended, Report};
use crate::transport::Connect;
use crate::{Clock, Config, run};
use output::Taker;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use umwelt_client::api::Checked;
use umwelt_client::api::step;
use umwelt_client::api::task::Stage;
use umwelt_core::controller::Controller;
use umwelt_core::geometry::{Point, Twist};
use umwelt_core::horizon::Horizon;
use umwelt_core::kinematics::{Drive as Wheels, forward, inverse};
use umwelt_core::plant::{Plant, PlantModel};
use umwelt_core::settings::Settings;
use umwelt_core::task::{self, Task};
use umwelt_core::time::RobotTime;

/// A server that commands half a second of `linear` m/s, whatever it is told.
fn always(linear: f64, watchdog: f64) -> Connect {
    let speeds = inverse(&Wheels::default(), Twist::new(linear, 0.0));
    answering(move |request| Horizon {
        sequence: request.sequence,
        answers: request.sequence,
        start: RobotTime::new(request.sent_s),
        slot: SLOT,
        watchdog,
        speeds: [speeds; 17].into_iter().collect(),
    })
}

/// A server with a real controller and a task of `waypoints`.
fn controlling(waypoints: Vec<Point>) -> (Connect, Arc<Mutex<Controller>>) {
    let mut controller = Controller::new(Settings::default());
    controller.set_task(Task { waypoints, calibration: None, ..Task::thesis() });
    let controller = Arc::new(Mutex::new(controller));
    let shared = Arc::clone(&controller);
    let connect = answering(move |request| {
        let request = Checked::new(request.clone()).unwrap().to_core();
        shared.lock().unwrap().step(&request).horizon
    });
    (connect, controller)
}

fn answering(answer: impl Fn(&step::Request) -> Horizon + Send + Sync + 'static) -> Connect {
    let answer = Arc::new(answer);
    Box::new(move || {
        let answer = Arc::clone(&answer);
        Box::new(move |request| {
            let horizon = (&answer(&request)).into();
            let reply = step::Reply { horizon, stopped: false, stage: Stage::Driving, drive: None };
            Box::pin(async move { Ok(reply) })
        })
    })
}

/// The other ends of a pipe's channels.
struct Ends {
    poses: mpsc::Sender<Line>,
    speeds: Taker,
    done: oneshot::Sender<()>,
}

fn pipe() -> (Pipe, Ends) {
    let (poses, lines) = mpsc::channel(MAX_READ_AHEAD);
    let (putter, speeds) = newest_line();
    let (done, written) = oneshot::channel();
    (Pipe::over(lines, putter, written, Output::Wheels), Ends { poses, speeds, done })
}

fn config() -> Config {
    Config::new("rover-7".parse().unwrap())
}

fn parse(line: &[u8]) -> (f64, WheelSpeeds) {
    let line: Value = serde_json::from_slice(line).unwrap();
    let number = |name: &str| line[name].as_f64().unwrap();
    let speeds = WheelSpeeds { left: number("left_rad_per_s"), right: number("right_rad_per_s") };
    (number("t_s"), speeds)
}

/// Reads all lines until the end, sending what `pose` gives for each and closing the input where it gives none.
async fn converse(
    mut ends: Ends,
    mut pose: impl FnMut(f64, WheelSpeeds) -> Option<String>,
) -> Vec<(f64, WheelSpeeds)> {
    let (mut lines, mut poses) = (Vec::new(), Some(ends.poses));
    while let Some(line) = ends.speeds.next().await {
        let (now, speeds) = parse(&line);
        lines.push((now, speeds));
        match pose(now, speeds) {
            Some(text) => {
                if let Some(poses) = &poses {
                    poses.send(Line::Whole(text.into())).await.unwrap();
                }
            }
            None => poses = None,
        }
    }
    ends.done.send(()).unwrap();
    lines
}

async fn driven(
    connect: Connect,
    pose: impl FnMut(f64, WheelSpeeds) -> Option<String>,
) -> (Report, Vec<(f64, WheelSpeeds)>) {
    let (pipe, ends) = pipe();
    let run = run(config(), connect, pipe, Clock::start(), std::future::pending());
    let (report, lines) = tokio::join!(run, converse(ends, pose));
    (report.unwrap(), lines)
}

const RESTING: &str = r#"{"x_m":0,"y_m":0,"heading_rad":0}"#;

#[tokio::test(start_paused = true)]
async fn speeds_come_at_every_slot_and_at_every_change_and_end_with_zeros() {
    let pose = |now, _| (now < 3.0).then(|| RESTING.to_owned());
    let (report, lines) = driven(always(0.1, 0.3), pose).await;
    assert_eq!(report.ended, Ended::NoMorePoses);
    assert!(lines.windows(2).all(|pair| pair[1].0 - pair[0].0 <= SLOT + 0.002));
    assert!(lines.iter().any(|(_, speeds)| (speeds.left - 0.1 / 0.03).abs() < 1e-9));
    assert_eq!(lines.first().unwrap().1, WheelSpeeds::ZERO);
    assert_eq!(lines.last().unwrap().1, WheelSpeeds::ZERO);
    let stopping = report.time - 3.0;
    assert!(stopping > 0.2 && stopping < 0.5, "{stopping} s to rest after the last pose");
}

/// A script as the robot: it integrates the wheel speeds, tells its pose `rate` times a second, and ends the poses once
/// it has arrived or a minute is over. How long it took, and how far from `target` it stands.
async fn tracked(rate: f64, target: Point) -> (f64, f64) {
    let (connect, controller) = controlling(vec![target]);
    let (pipe, Ends { poses, mut speeds, done }) = pipe();
    let clock = Clock::start();
    let mut plant = Plant::new(PlantModel::default(), Pose::default(), 1).unwrap();
    let script = async {
        let mut frames = tokio::time::interval(Duration::from_secs_f64(1.0 / rate));
        let (mut applied, mut poses, mut took) = (WheelSpeeds::ZERO, Some(poses), 60.0);
        loop {
            tokio::select! {
                line = speeds.next() => {
                    let Some(line) = line else { break };
                    let (now, next) = parse(&line);
                    plant.advance(applied, now - plant.time());
                    applied = next;
                }
                _ = frames.tick(), if poses.is_some() => {
                    let now = clock.now();
                    plant.advance(applied, now - plant.time());
                    let Pose { x, y, heading } = plant.pose();
                    let (h, open) = (heading.radians(), poses.as_ref().unwrap());
                    let line = format!(r#"{{"t_s":{now},"x_m":{x},"y_m":{y},"heading_rad":{h}}}"#);
                    open.send(Line::Whole(line.into())).await.unwrap();
                    let has_arrived = controller.lock().unwrap().progress().stage == task::Stage::Arrived;
                    if has_arrived || now > took {
                        (took, poses) = (now, None);
                    }
                }
            }
        }
        done.send(()).unwrap();
        took
    };
    let run = run(config(), connect, pipe, clock, std::future::pending());
    let (report, took) = tokio::join!(run, script);
    assert_eq!(report.unwrap().ended, Ended::NoMorePoses);
    (took, plant.pose().point().distance(target))
}

#[tokio::test(start_paused = true)]
async fn a_robot_behind_pipes_reaches_its_waypoint_at_any_frame_rate() {
    for rate in [10.0, 25.0, 30.0, 1.0 / SLOT, 50.0, 60.0, 90.0, 120.0, 240.0] {
        let (took, off) = tracked(rate, Point::new(0.3, 0.2)).await;
        assert!(took < 10.0 && off < 0.01, "{took} s at {rate} poses per s, {off} m off");
    }
}

#[tokio::test(start_paused = true)]
async fn garbage_never_moves_the_robot() {
    let (connect, _) = controlling(vec![Point::new(0.3, 0.0)]);
    let garbage = [
        "",
        "{}",
        "[1,2,3]",
        "\u{0}\u{1}",
        r#"{"x_m":0,"y_m":0,"heading_rad":"north"}"#,
        r#"{"t_s":1e9,"x_m":0,"y_m":0,"heading_rad":0}"#,
        r#"{"t_s":-5,"x_m":0,"y_m":0,"heading_rad":0}"#,
        r#"{"x_m":1e300,"y_m":0,"heading_rad":0}"#,
        r#"{"x_m":0,"y_m":0,"heading_rad":0,"left_rad_per_s":8}"#,
    ];
    let mut count = 0;
    let (_, lines) = driven(connect, |now, _| {
        count += 1;
        (now < 5.0).then(|| garbage[count % garbage.len()].to_owned())
    })
    .await;
    assert!(lines.len() > 150 && lines.iter().all(|(_, speeds)| *speeds == WheelSpeeds::ZERO));
}

/// The horizon of a server that means well.
fn ordinary(request: &step::Request) -> Horizon {
    Horizon {
        sequence: request.sequence,
        answers: request.sequence,
        start: RobotTime::new(request.sent_s),
        slot: SLOT,
        watchdog: 0.3,
        speeds: [inverse(&Wheels::default(), Twist::new(0.1, 0.0)); 17].into_iter().collect(),
    }
}

#[tokio::test(start_paused = true)]
async fn an_output_that_no_one_reads_stops_the_run() {
    let (pipe, ends) = pipe();
    let clock = Clock::start();
    let error = run(config(), always(0.1, 0.3), pipe, clock, std::future::pending()).await;
    assert_eq!(error, Err(AgentError::Drive(DriveError::OutputBlocked)));
    assert!(clock.now() < 2.0);
    drop(ends);
}

#[tokio::test(start_paused = true)]
async fn an_output_that_is_closed_stops_the_run() {
    let (pipe, Ends { poses, speeds, .. }) = pipe();
    drop(speeds);
    let error = run(config(), always(0.1, 0.3), pipe, Clock::start(), std::future::pending()).await;
    assert_eq!(error, Err(AgentError::Drive(DriveError::OutputClosed)));
    drop(poses);
}

#[test]
fn a_twist_is_written_as_such_and_zero_has_no_sign() {
    let wheels = Wheels::default();
    let speeds = inverse(&wheels, Twist::new(0.1, -0.5));
    let line = Output::Twist(wheels).line(1.5, speeds).unwrap();
    let line: Value = serde_json::from_slice(&line).unwrap();
    assert!((line["linear_m_per_s"].as_f64().unwrap() - 0.1).abs() < 1e-12);
    assert!((line["angular_rad_per_s"].as_f64().unwrap() + 0.5).abs() < 1e-12);
    let zero = Output::Wheels.line(1.5, WheelSpeeds { left: -0.0, right: 0.0 }).unwrap();
    assert_eq!(zero, b"{\"t_s\":1.5,\"left_rad_per_s\":0.0,\"right_rad_per_s\":0.0}\n");
    assert_eq!(forward(&wheels, WheelSpeeds::ZERO), Twist::ZERO);
}

/// A hold acts without the server, which here goes on saying drive; so does a smaller speed.
#[tokio::test(start_paused = true)]
async fn the_robot_itself_has_the_last_word() {
    let told = |now: f64| match now {
        ..1.0 => "",
        1.0..3.0 => r#","hold":true"#,
        3.0..5.0 => r#","hold":false,"max_speed_m_per_s":0.05"#,
        5.0..6.0 => r#","max_speed_m_per_s":0.01"#,
        6.0..8.0 => r#","max_speed_m_per_s":null"#,
        _ => "end",
    };
    let (_, lines) = driven(always(0.1, 0.3), |now, _| {
        let told = told(now);
        (told != "end").then(|| format!(r#"{{"x_m":0,"y_m":0,"heading_rad":0{told}}}"#))
    })
    .await;
    let wheels = Wheels::default();
    let speeds = |from: f64, to: f64| {
        let within = lines.iter().filter(move |(now, _)| (from..to).contains(now));
        within.map(|(_, speeds)| forward(&wheels, *speeds).linear).collect::<Vec<_>>()
    };
    let ramp = 0.1 / wheels.max_linear_acceleration + 2.0 * SLOT;
    assert!(speeds(0.9, 1.0).iter().all(|v| (v - 0.1).abs() < 1e-9));
    let slower = lines.iter().find(|(now, speeds)| *now >= 1.0 && speeds.left < 3.33);
    assert!(slower.is_some_and(|(now, _)| *now < 1.0 + 2.0 * SLOT), "{slower:?}: at once");
    let is_all = |from: f64, to: f64, wanted: f64| {
        let speeds = speeds(from, to);
        speeds.len() > 10 && speeds.iter().all(|v| (v - wanted).abs() < 1e-9)
    };
    assert!(is_all(1.0 + ramp, 3.0, 0.0), "held");
    assert!(is_all(3.0 + ramp, 5.0, 0.05), "slower");
    assert!(is_all(5.0 + ramp, 6.0, 0.0), "no motor turns at that speed");
    assert!(is_all(6.0 + ramp, 8.0, 0.1), "as told");
}

/// Takes 15 ms for each line.
struct Slow(Arc<Mutex<Vec<u8>>>);

impl Write for Slow {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        std::thread::sleep(Duration::from_millis(15));
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Poses in bursts, while the speeds change all the time, and a motor driver that is slow: each pose makes a line, and the
/// driver gets the newest whenever it is ready for one.
#[tokio::test]
async fn bursts_of_poses_end_no_run() {
    let wheels = Wheels::default();
    let connect = answering(move |request| {
        let side = if request.sequence / 8 % 2 == 0 { 0.1 } else { -0.1 };
        let speeds = [inverse(&wheels, Twist::new(side, 0.0)); 17].into_iter().collect();
        Horizon { speeds, ..ordinary(request) }
    });
    let (poses_out, mut poses) = std::io::pipe().unwrap();
    let taken = Arc::new(Mutex::new(Vec::new()));
    let pipe = Pipe::new(poses_out, Slow(Arc::clone(&taken)), Output::Wheels).unwrap();
    let tracker = tokio::task::spawn_blocking(move || {
        for _ in 0..15 {
            std::thread::sleep(Duration::from_millis(100));
            poses.write_all(format!("{RESTING}\n").repeat(100).as_bytes()).unwrap();
        }
    });
    let report = run(config(), connect, pipe, Clock::host(), std::future::pending()).await;
    assert_eq!(report.unwrap().ended, Ended::NoMorePoses);
    tracker.await.unwrap();
    let lines: Vec<_> =
        taken.lock().unwrap().split_inclusive(|byte| *byte == b'\n').map(parse).collect();
    assert!(lines.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    assert!(lines.iter().any(|(_, speeds)| speeds.left > 0.5));
    assert!(lines.iter().any(|(_, speeds)| speeds.left < -0.5));
    assert_eq!(lines.last().unwrap().1, WheelSpeeds::ZERO);
}

/// Real pipes and real time: what threads and system calls do is not seen on a paused clock.
#[tokio::test]
async fn real_pipes_carry_poses_and_speeds() {
    let (poses_out, mut poses) = std::io::pipe().unwrap();
    let (speeds, speeds_in) = std::io::pipe().unwrap();
    let pipe = Pipe::new(poses_out, speeds_in, Output::Wheels).unwrap();
    let robot = tokio::task::spawn_blocking(move || {
        let mut lines = BufReader::new(speeds).lines();
        poses.write_all(b"garbage\n{\"x_m\":0,\"y_m\":0,\"heading_rad\":0}\n").unwrap();
        let moving =
            lines.by_ref().find(|line| parse(line.as_ref().unwrap().as_bytes()).1.left > 1.0);
        assert!(moving.is_some());
        drop(poses);
        parse(lines.last().unwrap().unwrap().as_bytes()).1
    });
    let run = run(config(), always(0.1, 0.3), pipe, Clock::host(), std::future::pending());
    assert_eq!(run.await.unwrap().ended, Ended::NoMorePoses);
    assert_eq!(robot.await.unwrap(), WheelSpeeds::ZERO);
}
