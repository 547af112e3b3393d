//! Evolutions that go on through all deaths of the server, one after the other.

use serde_json::{Value, json};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::task::JoinHandle;
use umwelt_tests::http::{Answer, attempt, call};
use umwelt_tests::said;
use umwelt_tests::server::Server;
use umwelt_tests::wait;

/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Time for an evolution that no one disturbs any more: it takes some ten seconds of one core.
const UNDISTURBED: Duration = Duration::from_secs(60);

/// What is asked for: a generation takes a twentieth of a second of one core, all of them some lives of the server.
const GENERATIONS: u64 = 100;
const POPULATION: u64 = 12;

/// Kills that must have fallen into the last evolution or one before: otherwise nothing was shown.
const INTERRUPTED: u64 = 6;

fn body(seed: u64) -> Value {
    json!({
        "preset": "quick", "environments": ["normal"], "population": POPULATION, "generations": GENERATIONS,
        "trials": 1, "selection_trials": 2, "report_trials": 4, "seed": seed,
    })
}

fn arguments(seed: u64) -> String {
    format!(
        "--preset quick --environments normal --population {POPULATION} --generations {GENERATIONS} --trials 1 \
         --selection-trials 2 --report-trials 4 --seed {seed}"
    )
}

/// Asks for the evolution with `seed`, under a key of its own; none where there is no answer.
async fn ask(server: SocketAddr, seed: u64) -> Option<Answer> {
    let key = format!("seed-{seed}");
    let headers = [("Idempotency-Key", key.as_str())];
    attempt(server, "POST", "/v1/evolutions", &headers, body(seed).to_string().as_bytes()).await
}

/// One evolution, as it was last seen.
#[derive(Debug)]
struct Seen {
    evolution: Value,
    generations: Vec<Value>,
}

impl Seen {
    fn id(&self) -> &str {
        self.evolution["evolution"].as_str().unwrap()
    }

    fn state(&self) -> &str {
        self.evolution["state"].as_str().unwrap()
    }

    fn path(&self) -> String {
        format!("/v1/evolutions/{}", self.id())
    }

    /// It is what was asked for, and not farther back than it was.
    fn see(&mut self, now: Value) {
        let before = &self.evolution;
        for field in ["evolution", "spec", "created_unix_s"] {
            assert_eq!(now[field], before[field], "{field} of {now}");
        }
        assert!(now["interrupted"].as_u64() >= before["interrupted"].as_u64(), "{before} {now}");
        if before["state"] == "succeeded" {
            assert_eq!(now["champion"], before["champion"], "a champion stays: {before} {now}");
        }
        let order = ["queued", "running", "succeeded"];
        let rank = |it: &Value| order.iter().position(|state| it["state"] == *state);
        assert!(rank(&now).is_some(), "{now}");
        let generation = |it: &Value| it["progress"]["generation"].as_u64();
        assert!(generation(&now) >= generation(before), "{before} {now}");
        self.evolution = now;
    }

    /// Its generations stay as they are, and more come: none is left out.
    fn see_generations(&mut self, now: &[Value]) {
        let (id, count) = (self.id(), self.generations.len());
        assert!(now.len() >= count, "{id}: {} generations, there were {count}", now.len());
        assert_eq!(&now[..count], &self.generations[..], "{id}: what has ended changes no more");
        for (index, generation) in now.iter().enumerate() {
            assert_eq!(generation["index"], index, "{id}: {generation}");
        }
        self.generations = now.to_vec();
    }
}

/// All that were submitted; the last one runs, the others have succeeded.
#[derive(Debug)]
pub(super) struct Evolutions {
    seen: Vec<Seen>,
}

impl Evolutions {
    /// Submits the first.
    pub(super) async fn begin(server: SocketAddr) -> Self {
        let mut evolutions = Self { seen: Vec::new() };
        assert_eq!(evolutions.submit(server).await, Some(201));
        evolutions
    }

    /// Submits the next one, or finds it where it was submitted without an answer; none where there is no answer.
    async fn submit(&mut self, server: SocketAddr) -> Option<u16> {
        let answer = ask(server, self.seen.len() as u64 + 1).await?;
        assert!([200, 201].contains(&answer.code), "{answer:?}");
        self.seen.push(Seen { evolution: answer.json(), generations: Vec::new() });
        Some(answer.code)
    }

    fn last(&mut self) -> &mut Seen {
        self.seen.last_mut().unwrap()
    }

    /// Waits until the first one is where it can be interrupted.
    pub(super) async fn until_first_generation(&mut self, server: &Server) {
        wait::until("a generation", UNDISTURBED, async || {
            self.look(server.address).await?;
            (!self.last().generations.is_empty()).then_some(())
        })
        .await;
    }

    /// Looks at the last one; none where there is no answer.
    async fn look(&mut self, server: SocketAddr) -> Option<()> {
        let path = self.last().path();
        let now = attempt(server, "GET", &path, &[], b"").await?.json();
        self.last().see(now);
        let path = format!("{path}/generations");
        let page = attempt(server, "GET", &path, &[], b"").await?.json();
        self.last().see_generations(page["generations"].as_array().unwrap());
        let ended = self.last().evolution["progress"]["generation"].as_u64().unwrap() as usize;
        let kept = self.last().generations.len();
        assert!(kept >= ended, "{kept} generations are kept, {ended} were shown to have ended");
        Some(())
    }

    /// Looks at the last one until the server dies; submits another one whenever it has succeeded.
    pub(super) fn follow(mut self, server: SocketAddr) -> Following {
        Following(tokio::spawn(async move {
            loop {
                if self.look(server).await.is_none() {
                    return self;
                }
                if self.last().state() == "succeeded" && self.submit(server).await.is_none() {
                    return self;
                }
                tokio::time::sleep(PAUSE).await;
            }
        }))
    }

    /// All of them are there, each once, and no farther back than they were.
    pub(super) async fn check(&mut self, server: SocketAddr) {
        for (seed, seen) in (1..).zip(&mut self.seen) {
            let again = ask(server, seed).await.unwrap();
            assert_eq!(again.code, 200, "it is there: {again:?}");
            seen.see(again.json());
            let path = seen.path();
            seen.see(call(server, "GET", &path, &[], b"").await.json());
            let path = format!("{path}/generations");
            let page = call(server, "GET", &path, &[], b"").await.json();
            seen.see_generations(page["generations"].as_array().unwrap());
        }
        if self.last().state() == "succeeded" {
            // One was submitted that was not answered, or is now.
            self.submit(server).await.unwrap();
        }
        let page = call(server, "GET", "/v1/evolutions", &[], b"").await.json();
        let mut listed: Vec<_> = page["evolutions"].as_array().unwrap().iter().collect();
        listed.reverse();
        let ids: Vec<_> = listed.iter().map(|it| it["evolution"].as_str().unwrap()).collect();
        let known: Vec<_> = self.seen.iter().map(Seen::id).collect();
        assert_eq!(ids, known, "each was submitted under one key");
    }

    /// Waits for the last one; the one that was interrupted most has the champion of an undisturbed run. Returns how
    /// often each was interrupted.
    pub(super) async fn succeed(mut self, server: &Server) -> Vec<u64> {
        wait::until("the last evolution succeeds", UNDISTURBED, async || {
            self.look(server.address).await.unwrap();
            (self.last().state() == "succeeded").then_some(())
        })
        .await;
        let interrupted = |seen: &Seen| seen.evolution["interrupted"].as_u64().unwrap();
        let times: Vec<_> = self.seen.iter().map(interrupted).collect();
        assert!(times.iter().sum::<u64>() >= INTERRUPTED, "interrupted {times:?} times");
        let (index, seen) =
            self.seen.iter().enumerate().max_by_key(|it| interrupted(it.1)).unwrap();
        assert!(interrupted(seen) > 1, "interrupted {times:?} times");
        assert_eq!(seen.generations.len() as u64, GENERATIONS);
        let alone = said::evolve(&arguments(index as u64 + 1), UNDISTURBED).await;
        assert_eq!(seen.evolution["champion"], alone["champion"], "as without any kill");
        for seen in &self.seen {
            let prior = format!("/v1/priors/{}", seen.evolution["prior"].as_str().unwrap());
            let prior = call(server.address, "GET", &prior, &[], b"").await.json();
            for channel in ["forward", "lateral", "turn", "drift"] {
                assert_eq!(prior[channel], seen.evolution["champion"]["prior"][channel], "{prior}");
            }
        }
        times
    }
}

/// Someone who looks at evolutions.
#[derive(Debug)]
pub(super) struct Following(JoinHandle<Evolutions>);

impl Following {
    /// Waits until it has noticed that the server is dead.
    pub(super) async fn ended(self) -> Evolutions {
        self.0.await.unwrap()
    }
}
