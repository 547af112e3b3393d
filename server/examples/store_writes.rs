//! How much a server writes to its disk while robots drive: 20 robots, some minutes of their time.
//!
//! `cargo run --release -p umwelt-server --example store_writes [MINUTES [ROBOTS [DIRECTORY]]]`
//!
//! Robots, routes, fleet and store are those of a server; only the clock is made up, so that minutes take seconds. What is
//! counted is what this process writes to files, by `/proc/self/io` (Linux): `wchar` is what it hands to the system,
//! `write_bytes` what the system takes for a disk, which is nothing where DIRECTORY is in memory.

#![allow(clippy::print_stdout, reason = "an example that prints what it measured")]

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;
use tower::ServiceExt;
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::kinematics::{self, Drive};
use umwelt_server::{Config, Server};

/// One slot.
const SLOT: Duration = Duration::from_millis(30);

/// Slots from a pose being taken to the request that carries it.
const SENSOR: usize = 4;

/// What GB are, in bytes.
const GB: f64 = 1e9;

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |index: usize, default| arguments.get(index).map_or(Ok(default), |it| it.parse());
    let (minutes, count): (u64, u64) = (number(0, 4)?, number(1, 20)?);
    let kept = match arguments.get(2) {
        Some(directory) => tempfile::tempdir_in(directory)?,
        None => tempfile::tempdir_in(".")?,
    };
    let data = Some(PathBuf::from(kept.path()));
    let server =
        Server::bind(Config { data, listen: ([127, 0, 0, 1], 0).into(), ..Config::default() });
    let router = server.await?.router();
    let mut robots = Vec::new();
    for index in 0..count {
        robots.push(Robot::begin(&router, index).await?);
    }
    // From here on time passes only where everybody waits for it: not while a step is answered or the store writes.
    tokio::time::pause();
    println!("{count} robots in {}", kept.path().display());
    println!("{:>8} {:>22} {:>22}", "minute", "wchar GB/robot-hour", "disk GB/robot-hour");
    let begin = Written::now();
    for minute in 1..=minutes {
        let before = Written::now();
        for _ in 0..(60_000 / SLOT.as_millis()) {
            for robot in &mut robots {
                robot.step(&router).await?;
            }
            tokio::time::sleep(SLOT).await;
        }
        println!("{minute:>8} {}", before.per_robot_hour(count, 1));
    }
    println!("{:>8} {}", "all", begin.per_robot_hour(count, minutes));
    Ok(())
}

/// Bytes that this process has written.
#[derive(Clone, Copy)]
struct Written {
    handed_over: f64,
    to_disk: f64,
}

impl Written {
    /// Nothing where the system does not say.
    fn now() -> Self {
        let said = std::fs::read_to_string("/proc/self/io").unwrap_or_default();
        let of = |name: &str| {
            let line = said.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|number| number.trim().parse().ok()).unwrap_or(f64::NAN)
        };
        Self { handed_over: of("wchar:"), to_disk: of("write_bytes:") }
    }

    fn per_robot_hour(self, robots: u64, minutes: u64) -> String {
        let now = Self::now();
        let hours = robots as f64 * minutes as f64 / 60.0;
        let rate = |bytes: f64| bytes / GB / hours;
        let (handed_over, to_disk) =
            (rate(now.handed_over - self.handed_over), rate(now.to_disk - self.to_disk));
        format!("{handed_over:>22.5} {to_disk:>22.5}")
    }
}

async fn call(router: &Router, method: &str, path: &str, body: Value) -> Result<Value> {
    let request = Request::builder()
        .method(method)
        .uri(path)
        .header("content-type", "application/json")
        .header("host", "localhost")
        .body(Body::from(body.to_string()))?;
    let answer = router.clone().oneshot(request).await?;
    let code = answer.status();
    let body = answer.into_body().collect().await?.to_bytes();
    assert!(code.is_success(), "{method} {path}: {code} {}", String::from_utf8_lossy(&body));
    Ok(serde_json::from_slice(&body)?)
}

/// A robot that drives between two places for ever; its wheels slip a little, and its camera is not quite sharp.
struct Robot {
    path: String,
    rng: Pcg64Mcg,
    sequence: u64,
    clock: f64,
    seen: Vec<(Pose, f64)>,
    pose: Pose,
    speeds: WheelSpeeds,
}

impl Robot {
    async fn begin(router: &Router, index: u64) -> Result<Self> {
        let path = format!("/v1/robots/r{index}");
        call(router, "PUT", &path, json!({})).await?;
        let place = |leg: u32| json!({"x_m": 0.5 * f64::from(leg % 2), "y_m": 0.0});
        let waypoints: Vec<_> = (0..100).map(place).collect();
        call(router, "PUT", &format!("{path}/task"), json!({ "waypoints": waypoints })).await?;
        Ok(Self {
            path: format!("{path}/step"),
            rng: Pcg64Mcg::seed_from_u64(index),
            sequence: 0,
            clock: 10.0,
            seen: Vec::new(),
            pose: Pose::default(),
            speeds: WheelSpeeds::ZERO,
        })
    }

    async fn step(&mut self, router: &Router) -> Result<()> {
        self.seen.push((self.pose, self.clock));
        self.sequence += 1;
        let (seen, taken) = self.seen[self.seen.len().saturating_sub(1 + SENSOR)];
        let place = seen.point();
        let pose = json!({
            "x_m": place.x + self.noise(0.0005), "y_m": place.y + self.noise(0.0005),
            "heading_rad": seen.heading.radians() + self.noise(0.003), "taken_s": taken
        });
        let mut body = json!({
            "epoch": 7, "sequence": self.sequence, "sent_s": self.clock, "observations": [pose]
        });
        if self.sequence > 1 {
            let delay = 0.15 + self.noise(0.01);
            body["deliveries"] = json!([{"sequence": self.sequence - 1, "loop_delay_s": delay}]);
        }
        let answer = call(router, "POST", &self.path, body).await?;
        let twist = kinematics::forward(&Drive::default(), self.speeds);
        let mut moved = kinematics::integrate(twist, SLOT.as_secs_f64());
        moved.forward *= 0.95 + self.noise(0.03);
        moved.turn *= 0.98 + self.noise(0.03);
        self.pose = self.pose.then(moved);
        // What is commanded is played at once.
        let first = &answer["horizon"]["wheel_speeds"][0];
        let speed = |side: &str| first[side].as_f64().unwrap_or(0.0);
        self.speeds =
            WheelSpeeds { left: speed("left_rad_per_s"), right: speed("right_rad_per_s") };
        self.clock += SLOT.as_secs_f64();
        Ok(())
    }

    /// Uniform with this standard deviation.
    fn noise(&mut self, sd: f64) -> f64 {
        use rand::RngExt;
        sd * 3.0_f64.sqrt() * self.rng.random_range(-1.0..1.0)
    }
}
