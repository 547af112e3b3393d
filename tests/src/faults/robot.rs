//! A robot of the harness: its body, its link, and its agent as a process.

use super::body::Body;
use super::judge::Blindness;
use crate::process::Process;
use crate::proxy::Proxy;
use crate::server;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::io::Write;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use umwelt_agent::Clock;

/// Points of a task: more than a robot visits in a run, as a rule.
const POINTS: usize = 300;

/// Half the edge of the room in m: legs of half a metre, each with a turn before.
const ROOM: f64 = 0.5;

/// A robot.
#[derive(Debug)]
pub struct Robot {
    /// Its id.
    pub id: String,
    /// What it truly is and does.
    pub body: Arc<Body>,
    /// Its link to the server.
    pub proxy: Proxy,
    /// Whether a fault of its own is under way.
    pub is_busy: AtomicBool,
    agent: Mutex<Option<Process>>,
    disturbances: AtomicU64,
    tasks: AtomicU64,
    seed: u64,
}

impl Robot {
    /// Robot `number` with its link to `server`; its agent is not started yet.
    pub async fn new(number: usize, server: SocketAddr, clock: Clock, seed: u64) -> Self {
        let id = format!("robot-{number}");
        let seed = seed.wrapping_mul(1000).wrapping_add(number as u64);
        let body = Arc::new(Body::new(&id, clock, seed));
        Self {
            id,
            body,
            proxy: Proxy::start(server).await,
            is_busy: AtomicBool::new(false),
            agent: Mutex::new(None),
            disturbances: AtomicU64::new(0),
            tasks: AtomicU64::new(0),
            seed,
        }
    }

    /// Starts an agent for it.
    pub fn start_agent(&self) {
        let url = server::url(self.proxy.address());
        let arguments = ["--server", &url, "--robot", &self.id, "--drive", "pipe", "--log", "warn"];
        let (number, poses) = self.body.plug();
        let body = Arc::clone(&self.body);
        let hear = move |line: String| body.hear(number, &line);
        let mut process = Process::start_heard("umwelt-agent", &arguments, hear);
        let input = process.take_input();
        std::thread::spawn(move || {
            let Some(mut input) = input else { return };
            for pose in poses {
                if writeln!(input, "{pose}").and_then(|()| input.flush()).is_err() {
                    return;
                }
            }
        });
        self.proxy.tap().clear();
        self.body.judge(|judge, now| judge.begins_anew(now));
        *self.agent() = Some(process);
    }

    /// Kills its agent.
    pub fn kill_agent(&self) {
        self.body.unplug();
        // Its process is killed as it is dropped.
        *self.agent() = None;
    }

    /// What its agent said before it ended, where it has ended though no one told it to.
    pub fn agent_ended(&self) -> Option<String> {
        let mut agent = self.agent();
        let status = agent.as_mut()?.ended()?;
        let log = agent.take()?.log();
        self.body.unplug();
        let last: Vec<&str> = log.lines().rev().take(2).collect();
        Some(format!("{}: its agent ended by itself, {status}: {last:?}", self.id))
    }

    /// Something befalls it: what went before is not to be judged by how it goes on.
    pub fn disturb(&self) {
        self.disturbances.fetch_add(1, Ordering::SeqCst);
    }

    /// How often that was.
    pub fn disturbances(&self) -> u64 {
        self.disturbances.load(Ordering::SeqCst)
    }

    /// It cannot hear the server from here on, or can again.
    pub fn cut(&self, is_cut: bool, why: Blindness) {
        self.body.judge(
            |judge, now| {
                if is_cut { judge.goes_blind(why, now) } else { judge.sees(why, now) }
            },
        );
    }

    /// The body of a task that it had not before: to and fro in a room of its own.
    pub fn next_task(&self) -> Value {
        let turn = self.tasks.fetch_add(1, Ordering::SeqCst);
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed ^ (turn << 32));
        let points = (0..POINTS).map(|point| {
            let side = if point % 2 == 0 { ROOM } else { -ROOM };
            let x = side * rng.random_range(0.3..1.0);
            json!({"x_m": x, "y_m": rng.random_range(-ROOM..ROOM)})
        });
        json!({"waypoints": points.collect::<Vec<Value>>()})
    }

    /// Its task may be the new one since it was said, and is from now on.
    pub fn has_next_task(&self) {
        self.tasks.fetch_add(1, Ordering::SeqCst);
    }

    /// Which task it has, another number while it is being told a new one.
    pub fn task(&self) -> u64 {
        self.tasks.load(Ordering::SeqCst)
    }

    fn agent(&self) -> MutexGuard<'_, Option<Process>> {
        // A process is there or not: what is behind a poisoned lock is whole.
        self.agent.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
