//! Robots that drive through all deaths of their server.

use serde_json::Value;
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::task::JoinHandle;
use umwelt_api::RobotId;
use umwelt_core::kinematics::Drive;
use umwelt_tests::data::Data;
use umwelt_tests::http::attempt;
use umwelt_tests::process::{Process, SOON, Signal};
use umwelt_tests::rover::id;
use umwelt_tests::server::Server;
use umwelt_tests::wait;

/// What robots learned is at most this old after a kill of a server that saves every [`SAVE_EVERY_S`].
const AGE: Duration = Duration::from_secs(1);

/// Time between two saves, in s: a tenth of what servers do by themselves, so that lives can be short.
pub(super) const SAVE_EVERY_S: &str = "0.5";

/// Or that much of what was learned is kept: less is not worth a write.
const KEPT: f64 = 1.0 / (1.0 + umwelt_core::controller::GROWTH);

/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Time to calibrate and set out.
const SETTING_OUT: Duration = Duration::from_secs(30);

/// Robot time in s for which a robot drives by itself at most: horizon, watchdog and ramp, and half as much again.
const BY_ITSELF: f64 = 2.0;

/// One robot and its link each.
const LINKS: [&str; 3] = ["normal", "bad", "wifi-bursty"];

/// A calibration of a few seconds, then straight ahead for longer than all of this takes.
const TASK: &str = r#"{"waypoints": [{"x_m": 100.0, "y_m": 0.0}], "calibration":
    {"rotations": 2, "rotate_s": 0.6, "pause_s": 0.2, "straight_m": 0.0}}"#;

/// What was seen of a robot, and when the answer was there.
#[derive(Clone, Debug)]
struct Look {
    at: Instant,
    robot: Value,
    /// Deliveries from which its link was learned: one more with every exchange.
    deliveries: u64,
}

impl Look {
    /// None where there is no answer.
    async fn at(server: SocketAddr, robot: &RobotId) -> Option<Self> {
        let get = async |path: String| Some(attempt(server, "GET", &path, &[], b"").await?.json());
        let shown = get(format!("/v1/robots/{robot}")).await?;
        let environment = get(format!("/v1/robots/{robot}/environment")).await?;
        let deliveries = environment["link"]["samples"].as_u64();
        let deliveries = deliveries.unwrap_or_else(|| panic!("{shown} {environment}"));
        Some(Self { at: Instant::now(), robot: shown, deliveries })
    }

    fn number(&self, pointer: &str) -> f64 {
        self.robot.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NEG_INFINITY)
    }

    fn x(&self) -> f64 {
        self.number("/pose/x_m")
    }

    fn taken(&self) -> f64 {
        self.number("/pose/taken_s")
    }

    /// Time since the calibration ended.
    fn elapsed(&self) -> f64 {
        self.number("/task/elapsed_s")
    }

    fn is_driving(&self) -> bool {
        self.robot["task"]["stage"] == "driving"
    }

    fn is_calibrating(&self) -> bool {
        self.robot["task"]["stage"] == "calibrating"
    }
}

#[derive(Debug)]
struct Driver {
    robot: RobotId,
    agent: Process,
    /// Of this life of the server, the last one of the life before first.
    looks: Vec<Look>,
}

impl Driver {
    fn last(&self) -> &Look {
        self.looks.last().unwrap()
    }
}

/// All that drive.
#[derive(Debug)]
pub(super) struct Robots {
    drivers: Vec<Driver>,
    telling: usize,
}

impl Robots {
    /// Starts them; they have calibrated and drive on return.
    pub(super) async fn start(server: &Server) -> Self {
        let mut drivers = Vec::new();
        for (seed, link) in LINKS.iter().enumerate() {
            let robot = id(&format!("driving-{link}"));
            for (path, body) in [("", "{}"), ("/task", TASK)] {
                let path = format!("/v1/robots/{robot}{path}");
                let answer = attempt(server.address, "PUT", &path, &[], body.as_bytes()).await;
                assert_eq!(answer.map(|answer| answer.code), Some(201), "{path}");
            }
            let (url, seed) = (server.url(), seed.to_string());
            let arguments = ["--server", &url, "--robot", robot.as_str(), "--drive", "sim"];
            let more = ["--link", link, "--seed", &seed];
            let agent = Process::start("umwelt-agent", &[&arguments[..], &more].concat());
            drivers.push(Driver { robot, agent, looks: Vec::new() });
        }
        for driver in &mut drivers {
            let what = format!("{} drives", driver.robot);
            let look = wait::until(&what, SETTING_OUT, async || {
                let look = Look::at(server.address, &driver.robot).await?;
                // Calibrated for longer than what may be forgotten.
                (look.is_driving() && look.elapsed() > 2.0 * AGE.as_secs_f64()).then_some(look)
            })
            .await;
            driver.looks.push(look);
        }
        Self { drivers, telling: 0 }
    }

    /// Looks at them until the server dies.
    pub(super) fn watch(mut self, server: SocketAddr) -> Watching {
        Watching(tokio::spawn(async move {
            loop {
                for driver in &mut self.drivers {
                    let Some(look) = Look::at(server, &driver.robot).await else { return self };
                    driver.looks.push(look);
                }
                tokio::time::sleep(PAUSE).await;
            }
        }))
    }

    /// Looks at what is kept, in a copy that no agent knows of.
    ///
    /// What an answer shows was learned before it came. So what is kept, if it is at most as old as it may be, has
    /// learned hardly less than any answer shows that came this long before the kill, in the same life of the server.
    pub(super) async fn check_kept(&mut self, data: &Data, killed: Instant) {
        let copy = data.copy();
        let server = Server::start_with(&["--data", copy.text()]);
        let mut is_telling = false;
        for Driver { robot, looks, .. } in &mut self.drivers {
            let kept = Look::at(server.address, robot).await.unwrap();
            let old = looks.iter().filter(|look| look.at + AGE <= killed);
            for look in old {
                let age = killed - look.at;
                let (deliveries, elapsed) = (look.deliveries as f64 * KEPT, look.elapsed() * KEPT);
                assert!(
                    kept.deliveries as f64 >= deliveries && kept.elapsed() >= elapsed,
                    "{robot}: kept are {} deliveries and {} s of driving; {} and {} were seen {age:?} before the kill",
                    kept.deliveries,
                    kept.elapsed(),
                    look.deliveries,
                    look.elapsed(),
                );
                is_telling |= deliveries > looks[0].deliveries as f64;
            }
            assert!(!kept.is_calibrating(), "{robot} is not calibrated any more: {kept:?}");
            // From here on nothing less may be found; where it had got to is the last that was seen.
            let last = looks.last().unwrap().robot.clone();
            *looks = vec![Look { at: killed, robot: last, deliveries: kept.deliveries }];
        }
        self.telling += usize::from(is_telling);
    }

    /// Lives of the server in which one would have seen that something too old was kept.
    pub(super) fn telling(&self) -> usize {
        self.telling
    }

    /// Waits until every agent is back by itself, and its robot goes on where it was.
    pub(super) async fn go_on(&mut self, server: &Server) {
        for driver in &mut self.drivers {
            let (robot, before) = (&driver.robot, driver.last().clone());
            let look = wait::until(&format!("{robot} goes on"), SOON, async || {
                let look = Look::at(server.address, robot).await?;
                assert!(!look.is_calibrating(), "{robot} begins anew: {look:?}");
                (look.is_driving() && look.taken() > before.taken()).then_some(look)
            })
            .await;
            assert_eq!(look.robot["epoch"], before.robot["epoch"], "{robot} has the same agent");
            assert!(look.deliveries >= before.deliveries, "{before:?} {look:?}");
            // What was kept is in the first look; the life before is over.
            driver.looks = vec![look];
        }
    }

    /// Waits until all are farther than they would have got by themselves; then ends their agents.
    pub(super) async fn end(self, server: &Server) {
        let far = BY_ITSELF * Drive::default().max_linear;
        for mut driver in self.drivers {
            let goal = driver.last().x() + far;
            wait::until(&format!("{} passes {goal} m", driver.robot), SOON, async || {
                let look = Look::at(server.address, &driver.robot).await?;
                (look.x() > goal).then_some(())
            })
            .await;
            driver.agent.signal(Signal::Terminate);
            let status = driver.agent.end(SOON).await;
            assert_eq!(status.code(), Some(0), "{}", driver.agent.log());
        }
    }
}

/// Someone who looks at robots.
#[derive(Debug)]
pub(super) struct Watching(JoinHandle<Robots>);

impl Watching {
    /// Waits until it has noticed that the server is dead.
    pub(super) async fn ended(self) -> Robots {
        self.0.await.unwrap()
    }
}
