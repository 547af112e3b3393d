//! Facts that the server acknowledged, and whether they are still there: whatever happens to it meanwhile.
//!
//! One person changes things one after the other, and looks each up before it is changed again. What was not answered
//! may have been done or not; anything else that is found is a fact lost.

use crate::http::{Answer, attempt_within};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Things of each kind: few, so that each is changed again and again.
const THINGS: u64 = 3;

/// Time for an answer; a server under all these faults is slow, but not for so long.
const ANSWER: Duration = Duration::from_secs(20);

/// Time between two changes: robots drive meanwhile.
const PAUSE: Duration = Duration::from_millis(80);

/// What came of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Kept {
    /// Changes that the server acknowledged.
    pub acknowledged: u64,
    /// How often what was acknowledged was looked up.
    pub checked: u64,
    /// Changes that were not acknowledged, and may have been made or not.
    pub in_doubt: u64,
    /// Valid changes that were refused as invalid.
    pub refused: u64,
    /// Lookups that found something else than what was acknowledged.
    pub lost: u64,
    /// The first of them in words.
    #[serde(skip)]
    pub told: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Prior,
    Environment,
    Robot,
    Task,
    Stop,
}

const SORTS: [Sort; 5] = [Sort::Prior, Sort::Environment, Sort::Robot, Sort::Task, Sort::Stop];

/// One thing: what it may be, as far as someone can know; none where no one can.
#[derive(Debug)]
struct Thing {
    sort: Sort,
    number: u64,
    may_be: Option<Vec<Option<Value>>>,
    /// How many stops of everybody there were when it was known last.
    stops: u64,
}

/// One change: the call, and what the thing is where it was made.
struct Change {
    method: &'static str,
    path: String,
    body: Value,
    becomes: Option<Value>,
}

impl Thing {
    fn path(&self) -> String {
        let number = self.number;
        match self.sort {
            Sort::Prior => format!("/v1/priors/fact-{number}"),
            Sort::Environment => format!("/v1/environments/fact-{number}"),
            Sort::Robot => format!("/v1/robots/parked-{number}"),
            Sort::Task => format!("/v1/robots/standing-{number}/task"),
            Sort::Stop => format!("/v1/robots/standing-{number}"),
        }
    }

    /// Where in an answer the turn stands.
    fn pointer(&self) -> &'static str {
        match self.sort {
            Sort::Prior | Sort::Environment => "/note",
            Sort::Robot => "/spec/drive/wheel_radius_m",
            Sort::Task => "/spec/waypoints/0/x_m",
            Sort::Stop => "/stopped",
        }
    }

    /// A change that no other turn makes.
    fn change(&self, turn: u64, rng: &mut Pcg64Mcg) -> Change {
        let path = self.path();
        if self.sort == Sort::Stop {
            let stops = rng.random();
            let verb = if stops { "stop" } else { "resume" };
            let (path, becomes) = (format!("{path}/{verb}"), Some(Value::Bool(stops)));
            return Change { method: "POST", path, body: json!({}), becomes };
        }
        if rng.random_range(0..5) == 0 {
            return Change { method: "DELETE", path, body: Value::Null, becomes: None };
        }
        let (body, becomes) = match self.sort {
            Sort::Prior => (json!({"note": turn.to_string()}), json!(turn.to_string())),
            Sort::Environment => {
                let note = turn.to_string();
                (json!({"slip": "oily", "link": "bad", "note": note}), json!(note))
            }
            Sort::Robot => {
                let radius = 0.02 + turn as f64 * 1e-7;
                (json!({"drive": {"wheel_radius_m": radius}}), json!(radius))
            }
            Sort::Task | Sort::Stop => {
                let x = 0.1 + turn as f64 * 1e-4;
                (json!({"waypoints": [{"x_m": x, "y_m": 0.5}]}), json!(x))
            }
        };
        Change { method: "PUT", path, body, becomes: Some(becomes) }
    }
}

/// The person, and what it remembers.
#[derive(Debug)]
pub struct Facts {
    server: SocketAddr,
    things: Vec<Thing>,
    rng: Pcg64Mcg,
    turn: u64,
    kept: Kept,
}

impl Facts {
    /// Someone who knows nothing yet of `server`.
    pub fn new(server: SocketAddr, seed: u64) -> Self {
        let things = SORTS.into_iter().flat_map(|sort| {
            (0..THINGS).map(move |number| Thing { sort, number, may_be: None, stops: 0 })
        });
        let (things, rng) = (things.collect(), Pcg64Mcg::seed_from_u64(seed));
        Self { server, things, rng, turn: 0, kept: Kept::default() }
    }

    /// Makes the robots that stand around.
    pub async fn prepare(&self) {
        for number in 0..THINGS {
            self.call("PUT", &format!("/v1/robots/standing-{number}"), b"{}").await;
        }
    }

    /// Changes things until `ends` does, then looks everything up once more. `stops` counts what stops or resumes
    /// everybody: it concerns these robots, too.
    pub async fn run(mut self, ends: impl Future<Output = ()>, stops: &AtomicU64) -> Kept {
        let mut ends = std::pin::pin!(ends);
        loop {
            tokio::select! {
                () = &mut ends => break,
                () = tokio::time::sleep(PAUSE) => {}
            }
            let index = self.rng.random_range(0..self.things.len());
            if self.look_up(index, stops).await {
                self.change(index, stops).await;
            }
        }
        for index in 0..self.things.len() {
            self.look_up(index, stops).await;
        }
        self.kept
    }

    /// Looks a thing up; false where no one answers.
    async fn look_up(&mut self, index: usize, stops: &AtomicU64) -> bool {
        let before = stops.load(Ordering::SeqCst);
        let path = self.things[index].path();
        let Some(answer) = self.call("GET", &path, b"").await else { return false };
        let found = match answer.code {
            200 => answer.json().pointer(self.things[index].pointer()).cloned(),
            404 => None,
            _ => return false,
        };
        let thing = &mut self.things[index];
        let is_of_all = thing.sort == Sort::Stop
            && (before != thing.stops || before != stops.load(Ordering::SeqCst));
        if let Some(may_be) = thing.may_be.take().filter(|_| !is_of_all) {
            self.kept.checked += 1;
            if !may_be.contains(&found) {
                self.kept.lost += 1;
                self.kept.told.push(format!("{path} is {found:?} and was {may_be:?}"));
            }
        }
        (thing.may_be, thing.stops) = (Some(vec![found]), before);
        true
    }

    async fn change(&mut self, index: usize, stops: &AtomicU64) {
        self.turn += 1;
        let change = self.things[index].change(self.turn, &mut self.rng);
        let before = stops.load(Ordering::SeqCst);
        let body = if change.body.is_null() { String::new() } else { change.body.to_string() };
        let asked = Instant::now();
        let answer = self.call(change.method, &change.path, body.as_bytes()).await;
        let thing = &mut self.things[index];
        thing.stops = before;
        match answer {
            Some(answer) if matches!(answer.code, 200 | 201 | 204) => {
                self.kept.acknowledged += 1;
                // What is said not to be kept need not outlive the server.
                let is_kept = answer.json()["kept"] != Value::Bool(false);
                thing.may_be = is_kept.then(|| vec![change.becomes]);
            }
            // It was not there: looked up a moment ago, no one else removes it.
            Some(answer) if answer.code == 404 && change.method == "DELETE" => {}
            Some(answer) if (400..429).contains(&answer.code) => {
                self.kept.refused += 1;
                let Change { method, path, .. } = change;
                self.kept.told.push(format!("{method} {path} is refused: {}", answer.body));
            }
            // Late, it may still be made at any time.
            None if asked.elapsed() >= ANSWER => {
                self.kept.in_doubt += 1;
                thing.may_be = None;
            }
            _ => {
                self.kept.in_doubt += 1;
                if let Some(may_be) = &mut thing.may_be {
                    may_be.push(change.becomes);
                }
            }
        }
    }

    async fn call(&self, method: &str, path: &str, body: &[u8]) -> Option<Answer> {
        attempt_within(self.server, method, path, body, ANSWER).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::Server;

    /// Guards against: facts get lost and no one sees it.
    #[tokio::test(flavor = "multi_thread")]
    async fn what_is_gone_or_changed_behind_ones_back_is_counted() {
        let server = Server::start();
        let stops = AtomicU64::new(0);
        let facts = Facts::new(server.address, 1);
        facts.prepare().await;
        let kept = facts.run(tokio::time::sleep(Duration::from_secs(4)), &stops).await;
        assert!(kept.acknowledged > 10 && kept.checked > 10, "{kept:?}");
        assert_eq!((kept.lost, kept.in_doubt, kept.refused), (0, 0, 0), "{kept:?}");

        let mut facts = Facts::new(server.address, 2);
        for index in 0..facts.things.len() {
            assert!(facts.look_up(index, &stops).await);
            while facts.things[index].may_be == Some(vec![None]) {
                facts.change(index, &stops).await;
            }
        }
        for index in 0..facts.things.len() {
            let path = facts.things[index].path();
            let is_stopped = facts.things[index].may_be == Some(vec![Some(Value::Bool(true))]);
            let answer = match facts.things[index].sort {
                Sort::Stop if is_stopped => {
                    facts.call("POST", &format!("{path}/resume"), b"{}").await
                }
                Sort::Stop => facts.call("POST", &format!("{path}/stop"), b"{}").await,
                _ => facts.call("DELETE", &path, b"").await,
            };
            assert!(matches!(answer.unwrap().code, 200 | 204), "{path}");
            facts.look_up(index, &stops).await;
        }
        assert_eq!(facts.kept.lost, facts.things.len() as u64, "{:?}", facts.kept);
    }
}
