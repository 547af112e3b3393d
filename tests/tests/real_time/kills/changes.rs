//! People who change things all the time, and what they remember of it.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::task::JoinHandle;
use umwelt_tests::http::{attempt, call};

/// Things of each kind: few, so that each is made, replaced and removed again and again.
const THINGS: u32 = 4;

/// Least time between two changes of one person: robots drive meanwhile.
const TURN: Duration = Duration::from_millis(10);

/// What is changed. Each kind has someone of its own, so that changes of different kinds are kept in one group.
const KINDS: [Kind; 4] = [Kind::Robot, Kind::Task, Kind::Prior, Kind::Environment];

/// A prior that is never changed, for robots to use.
const USED: &str = "in-use";

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Robot,
    Task,
    Prior,
    Environment,
}

impl Kind {
    fn path(self, thing: u32) -> String {
        match self {
            Self::Robot => format!("/v1/robots/parked-{thing}"),
            // Of robots that are there all the time.
            Self::Task => format!("/v1/robots/standing-{thing}/task"),
            Self::Prior => format!("/v1/priors/p-{thing}"),
            Self::Environment => format!("/v1/environments/e-{thing}"),
        }
    }

    /// A body that no other turn has, and where the turn stands in it and in the answer.
    fn body(self, turn: u64) -> (Value, &'static str, &'static str) {
        match self {
            Self::Robot => {
                let radius = 0.02 + turn as f64 * 1e-7;
                let prior = if turn.is_multiple_of(2) { USED } else { "default" };
                let body = json!({"drive": {"wheel_radius_m": radius}, "prior": prior});
                (body, "/drive/wheel_radius_m", "/spec/drive/wheel_radius_m")
            }
            Self::Task => {
                let body = json!({"waypoints": [{"x_m": turn as f64 * 1e-3, "y_m": 0.5}]});
                (body, "/waypoints/0/x_m", "/spec/waypoints/0/x_m")
            }
            Self::Prior => {
                let body = json!({"forward": {"mu": -0.1, "k": 5.0, "r": 8.0, "s": 0.1}, "note": turn.to_string()});
                (body, "/note", "/note")
            }
            Self::Environment => {
                let body = json!({"slip": "oily", "link": "bad", "note": turn.to_string()});
                (body, "/note", "/note")
            }
        }
    }
}

/// A change that was asked for and may have been made or not.
#[derive(Clone, Debug)]
enum Unacknowledged {
    Put(u64),
    Delete,
}

/// One thing: what the server said that it is, none where it said that it is not there.
#[derive(Clone, Debug, Default)]
struct Thing {
    said: Option<Value>,
    unacknowledged: Option<Unacknowledged>,
}

/// What one of the people remembers.
#[derive(Clone, Debug)]
struct Person {
    kind: Kind,
    rng: Pcg64Mcg,
    turn: u64,
    things: BTreeMap<u32, Thing>,
    acknowledged: u64,
    in_doubt: u64,
}

impl Person {
    /// Changes things until told to end, or until the server is gone.
    async fn change(mut self, server: SocketAddr, end: Arc<AtomicBool>) -> Self {
        let mut turns = tokio::time::interval(TURN);
        while !end.load(Ordering::SeqCst) {
            turns.tick().await;
            let thing = self.rng.random_range(0..THINGS);
            let is_delete = self.rng.random_range(0..4) == 0;
            self.turn += 1;
            let unacknowledged =
                if is_delete { Unacknowledged::Delete } else { Unacknowledged::Put(self.turn) };
            let path = self.kind.path(thing);
            let remembered = self.things.entry(thing).or_default();
            remembered.unacknowledged = Some(unacknowledged.clone());
            let answer = match unacknowledged {
                Unacknowledged::Delete => attempt(server, "DELETE", &path, &[], b"").await,
                Unacknowledged::Put(turn) => {
                    let body = self.kind.body(turn).0.to_string();
                    attempt(server, "PUT", &path, &[], body.as_bytes()).await
                }
            };
            let Some(answer) = answer else {
                self.in_doubt += 1;
                return self;
            };
            match answer.code {
                200 | 201 => remembered.said = Some(answer.json()),
                204 => remembered.said = None,
                404 if is_delete => assert_eq!(remembered.said, None, "{path}: {answer:?}"),
                _ => panic!("{path}: {answer:?}"),
            }
            remembered.unacknowledged = None;
            self.acknowledged += 1;
        }
        self
    }

    /// Everything is as the server said. What it did not answer may have been done or not, but not in part.
    async fn check(&mut self, server: SocketAddr) {
        for (thing, remembered) in &mut self.things {
            let path = self.kind.path(*thing);
            let answer = call(server, "GET", &path, &[], b"").await;
            let found = match answer.code {
                200 => Some(answer.json()),
                404 => None,
                _ => panic!("{path}: {answer:?}"),
            };
            let is_done = match remembered.unacknowledged.take() {
                None => false,
                Some(Unacknowledged::Delete) => found.is_none(),
                Some(Unacknowledged::Put(turn)) => {
                    let (body, asked, told) = self.kind.body(turn);
                    let told = found.as_ref().and_then(|found| found.pointer(told));
                    told.is_some_and(|told| Some(told) == body.pointer(asked))
                }
            };
            if !is_done {
                assert_eq!(found, remembered.said, "{path}: found, and acknowledged");
            }
            remembered.said = found;
        }
    }
}

/// Everybody's.
#[derive(Debug)]
pub(super) struct Changes(Vec<Person>);

impl Changes {
    pub(super) fn new(seed: u64) -> Self {
        let person = |(index, kind): (u64, Kind)| Person {
            kind,
            rng: Pcg64Mcg::seed_from_u64(seed ^ ((index + 1) << 32)),
            turn: 0,
            things: BTreeMap::new(),
            acknowledged: 0,
            in_doubt: 0,
        };
        Self((0..).zip(KINDS).map(person).collect())
    }

    /// What everybody needs before they begin.
    pub(super) async fn prepare(server: SocketAddr) {
        let prior = format!("/v1/priors/{USED}");
        assert_eq!(call(server, "PUT", &prior, &[], b"{}").await.code, 201);
        for thing in 0..THINGS {
            let robot = format!("/v1/robots/standing-{thing}");
            assert_eq!(call(server, "PUT", &robot, &[], b"{}").await.code, 201);
        }
    }

    /// Lets them change things on the server until it dies.
    pub(super) fn start(self, server: SocketAddr) -> Changing {
        let end = Arc::new(AtomicBool::new(false));
        let people = self.0.into_iter();
        let tasks = people.map(|it| tokio::spawn(it.change(server, Arc::clone(&end)))).collect();
        Changing { end, tasks }
    }

    pub(super) async fn check(&mut self, server: SocketAddr) {
        for person in &mut self.0 {
            person.check(server).await;
        }
    }

    /// Changes that the server has acknowledged.
    pub(super) fn acknowledged(&self) -> u64 {
        self.0.iter().map(|person| person.acknowledged).sum()
    }

    /// Changes that were asked for when it died.
    pub(super) fn in_doubt(&self) -> u64 {
        self.0.iter().map(|person| person.in_doubt).sum()
    }
}

/// People at work.
#[derive(Debug)]
pub(super) struct Changing {
    end: Arc<AtomicBool>,
    tasks: Vec<JoinHandle<Person>>,
}

impl Changing {
    /// Waits until all have noticed that the server is dead.
    pub(super) async fn ended(self) -> Changes {
        self.end.store(true, Ordering::SeqCst);
        let mut people = Vec::new();
        for task in self.tasks {
            people.push(task.await.unwrap());
        }
        Changes(people)
    }
}
