//! A robot behind pipes, in seventy lines: what a camera tracker and a motor driver have to do.
//!
//! It starts `umwelt-agent --drive pipe`, reads wheel speeds from its standard output, moves as they say, and writes
//! the poses that a camera would see to its standard input.
//!
//! `cargo run --release --example pipe_robot -- rover-8 [SERVER] [SECONDS]`

#![allow(clippy::print_stdout, reason = "an example prints")]

use serde_json::{Value, json};
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::kinematics::{Drive, forward, integrate};

/// Time between two pictures of the camera.
const FRAME: Duration = Duration::from_millis(30);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let robot = arguments.next().ok_or("which robot? pipe_robot ID [SERVER] [SECONDS]")?;
    let server = arguments.next().unwrap_or_else(|| "http://127.0.0.1:8080".to_owned());
    let seconds: f64 = arguments.next().map_or(Ok(20.0), |seconds| seconds.parse())?;

    // The agent lies beside this example's folder: target/release/umwelt-agent.
    let here = std::env::current_exe()?;
    let agent = here.ancestors().nth(2).ok_or("no such folder")?.join("umwelt-agent");
    let mut agent = Command::new(agent)
        .args(["--drive", "pipe", "--robot", &robot, "--server", &server, "--log", "warn"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let (mut poses, speeds) =
        (agent.stdin.take().ok_or("stdin")?, agent.stdout.take().ok_or("stdout")?);

    // The motors: they do what the last line says.
    let wheels = Arc::new(Mutex::new(WheelSpeeds::ZERO));
    let motors = Arc::clone(&wheels);
    let reading = thread::spawn(move || {
        for line in BufReader::new(speeds).lines().map_while(Result::ok) {
            let Ok(line) = serde_json::from_str::<Value>(&line) else { continue };
            let speed = |wheel: &str| line[wheel].as_f64().unwrap_or(0.0);
            let (left, right) = (speed("left_rad_per_s"), speed("right_rad_per_s"));
            *motors.lock().unwrap_or_else(|e| e.into_inner()) = WheelSpeeds { left, right };
        }
    });

    // The camera: a pose every 30 ms, stamped by the agent on arrival.
    let (drive, mut pose) = (Drive::default(), Pose::default());
    let begun = Instant::now();
    let mut frames = 0;
    while begun.elapsed().as_secs_f64() < seconds {
        let (x, y, heading) = (pose.x, pose.y, pose.heading.radians());
        writeln!(poses, "{}", json!({"x_m": x, "y_m": y, "heading_rad": heading}))?;
        if frames % 33 == 0 {
            eprintln!("x {x:7.3} m  y {y:7.3} m  heading {heading:6.3} rad");
        }
        frames += 1;
        thread::sleep((begun + FRAME * frames).saturating_duration_since(Instant::now()));
        let wheels = *wheels.lock().unwrap_or_else(|e| e.into_inner());
        pose = pose.then(integrate(forward(&drive, wheels), FRAME.as_secs_f64()));
    }
    drop(poses);
    agent.wait()?;
    reading.join().map_err(|_| "the reader failed")?;
    println!("{}", json!({"x_m": pose.x, "y_m": pose.y, "heading_rad": pose.heading.radians()}));
    Ok(())
}
