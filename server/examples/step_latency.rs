//! How long a step takes while an evolution runs, against without: ten robots at 33 Hz over real HTTP.
//!
//! `cargo run --release -p umwelt-server --example step_latency [SECONDS [ROUNDS [THREADS]]]`
//!
//! Server and robots are in one process and share the cores. Rounds with and without an evolution alternate, so that
//! whatever else the machine does falls on both. A step counts from the moment the robot sends it to the last byte of its
//! answer; that the timer of the robot itself is rough does not count.

#![allow(clippy::print_stdout, reason = "an example that prints what it measured")]

use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use hyper::client::conn::http2::{SendRequest, handshake};
use hyper_util::rt::{TokioExecutor, TokioIo};
use serde_json::{Value, json};
use std::error::Error;
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::net::TcpStream;
use umwelt_server::{Config, Server};

const ROBOTS: usize = 10;

/// One slot.
const EVERY: Duration = Duration::from_millis(30);

/// Time for which an evolution runs before steps count: its first threads, its first pages.
const WARM_UP: Duration = Duration::from_millis(500);

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

#[tokio::main]
async fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let mut next = |default: u64| arguments.next().unwrap_or(Ok(default));
    let (seconds, rounds, threads) = (next(20)?, next(4)?, next(0)?);
    let config = Config {
        listen: ([127, 0, 0, 1], 0).into(),
        evolution_threads: usize::try_from(threads).ok().filter(|threads| *threads > 0),
        ..Config::default()
    };
    let server = Server::bind(config).await?;
    let address = server.local_addr();
    tokio::spawn(server.run(std::future::pending()));
    let mut robots = Vec::new();
    for index in 0..ROBOTS {
        robots.push(Robot::begin(address, index).await?);
    }
    let mut client = Client::connect(address).await?;
    let (mut without, mut with) = (Vec::new(), Vec::new());
    println!("{ROBOTS} robots, {seconds} s a round; times in ms");
    println!("{:<24} {:>7} {:>7} {:>7} {:>7}", "", "p50", "p99", "p99.9", "max");
    for round in 0..2 * rounds {
        let evolves = round % 2 == 1;
        let mut evolution = None;
        if evolves {
            let body = json!({"preset": "default", "generations": 1000, "population": 200});
            let (code, answer) = client.call("POST", "/v1/evolutions", &body).await?;
            assert_eq!(code, 201, "{answer}");
            evolution = answer["evolution"].as_str().map(str::to_owned);
            tokio::time::sleep(WARM_UP).await;
        }
        let before = cpu_time();
        let began = Instant::now();
        let mut times = drive(&mut robots, Duration::from_secs(seconds)).await?;
        let cores = (cpu_time() - before) / began.elapsed().as_secs_f64();
        let name = if evolves { "with an evolution" } else { "without" };
        println!("{name:<24} {}  {cores:.2} cores busy", quantiles(&mut times));
        if evolves { &mut with } else { &mut without }.append(&mut times);
        if let Some(evolution) = evolution {
            let path = format!("/v1/evolutions/{evolution}/cancel");
            let (code, answer) = client.call("POST", &path, &Value::Null).await?;
            assert_eq!(code, 200, "{answer}");
        }
    }
    println!("\n{:<24} {}", "all without", quantiles(&mut without));
    println!("{:<24} {}", "all with an evolution", quantiles(&mut with));
    let (p50, p99) = (ratio(&with, &without, 0.5), ratio(&with, &without, 0.99));
    println!("ratio: p50 {p50:.2}, p99 {p99:.2} (2 at most is the aim)");
    Ok(())
}

/// A connection.
struct Client {
    sender: SendRequest<Body>,
    address: SocketAddr,
}

impl Client {
    async fn connect(address: SocketAddr) -> Result<Self> {
        let stream = TcpStream::connect(address).await?;
        stream.set_nodelay(true)?;
        let (sender, connection) = handshake(TokioExecutor::new(), TokioIo::new(stream)).await?;
        tokio::spawn(connection);
        Ok(Self { sender, address })
    }

    async fn call(&mut self, method: &str, path: &str, body: &Value) -> Result<(u16, Value)> {
        let request = Request::builder()
            .method(method)
            .uri(format!("http://{}{path}", self.address))
            .header("content-type", "application/json")
            .body(Body::from(body.to_string()))?;
        self.sender.ready().await?;
        let (head, body) = self.sender.send_request(request).await?.into_parts();
        let body = body.collect().await?.to_bytes();
        Ok((head.status.as_u16(), serde_json::from_slice(&body).unwrap_or_default()))
    }
}

/// A robot that drives to and fro for ever.
struct Robot {
    client: Client,
    path: String,
    sequence: u64,
    begin: Instant,
}

impl Robot {
    async fn begin(address: SocketAddr, index: usize) -> Result<Self> {
        let mut client = Client::connect(address).await?;
        let path = format!("/v1/robots/r{index}");
        let (code, answer) = client.call("PUT", &path, &json!({})).await?;
        assert_eq!(code, 201, "{answer}");
        let waypoints: Vec<_> =
            (0..100).map(|leg| json!({"x_m": f64::from(leg % 2), "y_m": 0.0})).collect();
        let task = json!({"waypoints": waypoints, "calibration": {}});
        let (code, answer) = client.call("PUT", &format!("{path}/task"), &task).await?;
        assert_eq!(code, 201, "{answer}");
        Ok(Self { client, path: format!("{path}/step"), sequence: 0, begin: Instant::now() })
    }

    /// One step; how long it took.
    async fn step(&mut self) -> Result<Duration> {
        self.sequence += 1;
        let sent = 10.0 + self.begin.elapsed().as_secs_f64();
        // Slowly forward: what it sees keeps the controller busy, whatever it makes of it.
        let pose = json!({
            "x_m": 0.02 * (sent - 10.0), "y_m": 0.0, "heading_rad": 0.0, "taken_s": sent - 0.02
        });
        let body =
            json!({"epoch": 7, "sequence": self.sequence, "sent_s": sent, "observations": [pose]});
        let (path, begin) = (self.path.clone(), Instant::now());
        let (code, answer) = self.client.call("POST", &path, &body).await?;
        assert_eq!(code, 200, "{answer}");
        Ok(begin.elapsed())
    }
}

/// Lets the robots step at their rate, evenly spread over a slot.
async fn drive(robots: &mut [Robot], time: Duration) -> Result<Vec<f64>> {
    let begin = Instant::now();
    let run = robots.iter_mut().enumerate().map(async |(index, robot)| -> Result<Vec<f64>> {
        let mut times = Vec::new();
        let mut due = begin + EVERY / ROBOTS as u32 * index as u32;
        while due < begin + time {
            tokio::time::sleep_until(due.into()).await;
            times.push(robot.step().await?.as_secs_f64() * 1e3);
            due += EVERY;
        }
        Ok(times)
    });
    Ok(futures_util::future::try_join_all(run).await?.concat())
}

fn quantiles(times: &mut [f64]) -> String {
    times.sort_by(f64::total_cmp);
    let at = |share| quantile(times, share);
    format!("{:>7.3} {:>7.3} {:>7.3} {:>7.3}", at(0.5), at(0.99), at(0.999), at(1.0))
}

/// Of times in their order.
fn quantile(times: &[f64], share: f64) -> f64 {
    let index = (share * times.len() as f64).ceil() as usize;
    times[index.clamp(1, times.len()) - 1]
}

fn ratio(one: &[f64], other: &[f64], share: f64) -> f64 {
    quantile(one, share) / quantile(other, share)
}

/// CPU time in s that this process has used; 0 where the system does not say.
fn cpu_time() -> f64 {
    // proc_pid_stat(5): utime and stime, fields 14 and 15, in hundredths of a second.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields);
    let ticks = fields.split_whitespace().skip(11).take(2).filter_map(|it| it.parse::<f64>().ok());
    ticks.sum::<f64>() / 100.0
}
