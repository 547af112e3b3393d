//! What is found again after a restart, and what a store that fails does to a server that runs.

use crate::api::{Api, config, step};
use crate::stores::{Faulty, Gate, UNAVAILABLE, WORKS};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use tempfile::tempdir;
use umwelt_server::store::{DATA_FILE, JobId, SqliteStore, StoredKind};
use umwelt_server::{Server, Store};

const A_SECOND: Duration = Duration::from_secs(1);

/// Longer than what a crash may cost. The clock stands still while the store works and while a step is answered.
const A_ROUND: Duration = Duration::from_secs(6);

/// Lets robot `r` take steps `from..to`, in which it learns.
async fn drive(api: &Api, from: u64, to: u64) {
    for sequence in from..to {
        let mut body = step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0);
        let delay = 0.1 + 0.001 * sequence as f64;
        body["deliveries"] = json!([{"sequence": sequence - 1, "loop_delay_s": delay}]);
        assert_eq!(api.step(body).await.code, 200);
    }
}

async fn learned(api: &Api) -> Value {
    api.get("/v1/robots/r/environment").await.json()
}

fn sqlite(directory: &tempfile::TempDir) -> Arc<dyn Store> {
    Arc::new(SqliteStore::open(directory.path()).unwrap())
}

#[tokio::test(start_paused = true)]
async fn a_server_finds_everything_again_in_its_data_directory() {
    let directory = tempdir().unwrap();
    let data = Some(directory.path().to_path_buf());
    let config = || umwelt_server::Config { data: data.clone(), ..config() };
    let before = {
        let server = Server::bind(config()).await.unwrap();
        let api = Api(server.router());
        api.add("r").await;
        api.add("s").await;
        api.post("/v1/robots/s/stop").await;
        drive(&api, 1, 40).await;
        tokio::time::sleep(A_ROUND).await;
        [api.get("/v1/robots/r/task").await.json(), learned(&api).await]
    };
    // The one before has let go of the directory when the last of its tasks has ended.
    let server = loop {
        match Server::bind(config()).await {
            Ok(server) => break server,
            Err(error) => assert!(error.to_string().contains("in use"), "{error}"),
        }
        tokio::task::yield_now().await;
    };
    let api = Api(server.router());
    let [mut task_before, learned_before] = before;
    // A leg that was begun is taken up again with a turn toward its waypoint.
    assert_eq!(task_before["progress"]["stage"].take(), "driving");
    // What limits the speed is known again with the first step.
    assert!(task_before["progress"]["limited_by"].take().is_string());
    let mut task = api.get("/v1/robots/r/task").await.json();
    assert_eq!(task["progress"]["stage"].take(), "turning");
    assert_eq!((task, learned(&api).await), (task_before, learned_before.clone()));
    assert!(learned_before["link"]["samples"].as_u64() > Some(30), "{learned_before}");
    assert_eq!(api.get("/v1/robots/s").await.json()["stopped"], true);
    let refused = Server::bind(config()).await.err().unwrap().to_string();
    assert!(refused.contains("in use by another umwelt-server"), "{refused}");
}

#[tokio::test(start_paused = true)]
async fn what_a_robot_learns_is_kept_within_some_seconds() {
    let directory = tempdir().unwrap();
    let store = sqlite(&directory);
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    let mut seen = Vec::new();
    for round in 0..3 {
        drive(&api, 1 + 20 * round, 21 + 20 * round).await;
        tokio::time::sleep(A_ROUND).await;
        let restarted = Api::with(config(), store.clone()).await;
        assert_eq!(learned(&restarted).await, learned(&api).await);
        seen.push(learned(&api).await["link"]["samples"].as_u64());
    }
    assert!(seen[0] < seen[1] && seen[1] < seen[2], "it learns: {seen:?}");
}

/// Guards against: a fleet that drives wears out the card it is kept on. What is little news waits, what is much does not,
/// and nothing waits for ever.
#[tokio::test(start_paused = true)]
async fn what_robots_learn_is_written_seldom_and_by_how_much_it_is() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    let mut sequence = 1;
    let mut learn = async |count: u64| {
        drive(&api, sequence, sequence + count).await;
        sequence += count;
    };
    // A third of a second more each time: at most one write in five seconds, however much is learned.
    let before = store.saves();
    for _ in 0..60 {
        learn(10).await;
        tokio::time::sleep(A_SECOND / 3).await;
    }
    let saves = store.saves() - before;
    assert!((3..=5).contains(&saves), "{saves} in 20 s");
    tokio::time::sleep(20 * A_SECOND).await;
    // Some more among 600.
    let before = store.saves();
    for _ in 0..4 {
        learn(2).await;
        tokio::time::sleep(A_ROUND).await;
    }
    assert_eq!(store.saves(), before, "eight more are no news");
    tokio::time::sleep(60 * A_SECOND).await;
    assert_eq!(store.saves(), before + 1, "they are kept all the same");
    learn(60).await;
    tokio::time::sleep(A_ROUND).await;
    assert_eq!(store.saves(), before + 2, "these are news");
    tokio::time::sleep(200 * A_SECOND).await;
    assert_eq!(store.saves(), before + 2, "nothing new is not written again");
}

/// Guards against: a change is acknowledged, the server dies at once, and what was learned is gone, or the new task
/// begins where the old one was.
#[tokio::test(start_paused = true)]
async fn a_change_keeps_what_was_learned_with_it() {
    let directory = tempdir().unwrap();
    let store = sqlite(&directory);
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    drive(&api, 1, 40).await;
    let other = json!({"waypoints": [{"x_m": 0.0, "y_m": 0.3}, {"x_m": 0.0, "y_m": 0.0}]});
    for change in 0..3 {
        let (code, relearns) = match change {
            0 => (api.put("/v1/robots/r/task", other.clone()).await.code, false),
            1 => (api.put("/v1/robots/r", json!({"horizon_slots": 3})).await.code, false),
            _ => (api.put("/v1/robots/r", json!({"method": "statistic"})).await.code, true),
        };
        assert_eq!(code, 200);
        let restarted = Api::with(config(), store.clone()).await;
        assert_eq!(learned(&restarted).await, learned(&api).await, "{change}");
        let [robot, task, _] = restarted.state().await;
        let [robot_before, task_before, _] = api.state().await;
        assert_eq!((&robot["spec"], &task), (&robot_before["spec"], &task_before), "{change}");
        let samples = learned(&restarted).await["link"]["samples"].as_u64();
        assert_eq!(samples == Some(0), relearns, "{change}: {samples:?}");
        assert_eq!(task["progress"]["legs"], 2);
    }
}

/// Guards against: what was read off a robot before a change is written after it.
#[tokio::test(start_paused = true)]
async fn what_was_learned_for_an_earlier_task_is_never_taken_up() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    drive(&api, 1, 40).await;
    tokio::time::sleep(A_ROUND).await;
    let earlier = store.last_posteriors();
    let other = json!({"waypoints": [{"x_m": 0.0, "y_m": 0.3}], "calibration": null});
    assert_eq!(api.put("/v1/robots/r/task", other).await.code, 200);
    store.commit(earlier.clone()).unwrap();
    let restarted = Api::with(config(), store.clone()).await;
    let [_, task, _] = restarted.state().await;
    assert_eq!(task["progress"], api.get("/v1/robots/r/task").await.json()["progress"]);
    assert_eq!(task["progress"]["stage"], "stopping", "not calibrating any more");
    assert_eq!(earlier.len(), 1, "there was one");
}

/// A robot drives on a store that fails; what it learns is tried again until it is kept.
#[tokio::test(start_paused = true)]
async fn a_store_that_fails_shows_in_readiness_until_it_works_again() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    assert_eq!(api.get("/readyz").await.code, 200);
    let mut sequence = 1;
    for _ in 0..2 {
        store.set(UNAVAILABLE);
        for _ in 0..5 {
            drive(&api, sequence, sequence + 10).await;
            sequence += 10;
            // It is written to after that long at the latest.
            tokio::time::sleep(2 * A_ROUND).await;
            let ready = api.get("/readyz").await;
            assert_eq!((ready.code, ready.problem().1.as_str()), (503, "STORE_FAILED"));
            assert!(ready.json()["error"]["message"].as_str().unwrap().contains("disk full"));
            assert_eq!(api.get("/healthz").await.code, 200, "it need not be restarted");
        }
        store.set(WORKS);
        tokio::time::sleep(A_SECOND).await;
        assert_eq!(api.get("/readyz").await.code, 200);
        tokio::time::sleep(A_ROUND).await;
        let restarted = Api::with(config(), store.clone()).await;
        assert_eq!(learned(&restarted).await, learned(&api).await, "nothing was left out");
    }
}

/// Guards against: a robot that was stopped while the disk was full drives on after the next restart.
#[tokio::test(start_paused = true)]
async fn a_stop_that_could_not_be_kept_is_kept_once_the_store_works_again() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    api.add("s").await;
    store.set(UNAVAILABLE);
    assert_eq!(api.post("/v1/stop").await.code, 200);
    tokio::time::sleep(A_SECOND).await;
    store.set(WORKS);
    // One that someone has let go on in the meantime is not stopped again.
    assert_eq!(api.post("/v1/robots/s/resume").await.code, 200);
    tokio::time::sleep(A_SECOND).await;
    let restarted = Api::with(config(), store.clone()).await;
    assert_eq!(restarted.get("/v1/robots/r").await.json()["stopped"], true);
    assert_eq!(restarted.get("/v1/robots/s").await.json()["stopped"], false);
}

/// Guards against: a server on which nothing happens is ready for ever, whatever its disk does.
#[tokio::test(start_paused = true)]
async fn an_idle_server_notices_that_its_store_fails() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    store.set(UNAVAILABLE);
    tokio::time::sleep(15 * A_SECOND).await;
    assert_eq!(api.get("/readyz").await.code, 503);
    store.set(WORKS);
    tokio::time::sleep(A_SECOND).await;
    assert_eq!(api.get("/readyz").await.code, 200);
}

/// Guards against: an orderly end that waits for ever for a disk.
#[tokio::test]
async fn a_server_ends_although_its_store_hangs() {
    let gate = Arc::new(Gate::default());
    let short = Duration::from_millis(50);
    let config = umwelt_server::Config { drain: short, close: short, ..config() };
    let server = Server::with_store(config, gate.clone()).await.unwrap();
    let api = Api(server.router());
    api.add("r").await;
    let _shut = gate.shut();
    drive(&api, 1, 3).await;
    let ended = tokio::time::timeout(60 * A_SECOND, server.run(std::future::ready(()))).await;
    ended.expect("it ends").unwrap();
}

/// Guards against: an update of the program that loses evolutions, or ends those that were running.
#[tokio::test]
async fn a_data_file_of_version_1_is_taken_up_with_its_evolutions() {
    let directory = tempdir().unwrap();
    let file = rusqlite::Connection::open(directory.path().join(DATA_FILE)).unwrap();
    file.execute_batch(include_str!("version-1.sql")).unwrap();
    let body = |number: u64| -> String {
        let select = "SELECT body FROM generations WHERE evolution = ?1 ORDER BY position";
        let mut select = file.prepare(select).unwrap();
        let found = select.query_map([format!("evolution-{number}")], |row| row.get(0)).unwrap();
        found.collect::<Result<Vec<String>, _>>().unwrap().concat()
    };
    let before = [body(1), body(2)];
    drop(file);
    let store = Arc::new(SqliteStore::open(directory.path()).unwrap());
    let id = |number| JobId { kind: StoredKind::Evolution, number };
    let kept = |number| {
        let parts = store.parts(id(number), 0, 2).unwrap();
        parts.into_iter().map(|part| part.body).collect::<String>()
    };
    assert_eq!([kept(1), kept(2)], before);

    let api = crate::jobs::serve(store.clone()).await;
    let first = api.get("/v1/evolutions/evolution-1").await.json();
    assert_eq!((&first["state"], &first["prior"]), (&json!("succeeded"), &json!("evolution-1")));
    assert_eq!(first["champion"]["entries"].as_array().unwrap().len(), 4);
    let prior = api.get("/v1/priors/evolution-1").await.json();
    assert_eq!(prior["forward"], first["champion"]["prior"]["forward"]);
    let second = crate::jobs::ended(&api, "/v1/evolutions/evolution-2").await;
    assert_eq!((&second["state"], &second["prior"]), (&json!("succeeded"), &json!("meadow")));
    assert_eq!((&second["interrupted"], &second["error"]), (&json!(1), &Value::Null));
    let generations = api.get("/v1/evolutions/evolution-2/generations").await.json();
    let indices: Vec<_> = generations["generations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|generation| generation["index"].as_u64().unwrap())
        .collect();
    assert_eq!(indices, [0, 1, 2, 3]);
    assert_eq!(kept(2), before[1], "what was there has stayed");
    let key = [crate::api::JSON, ("idempotency-key", "night")];
    let body = json!({
        "preset": "quick", "environments": ["normal"], "population": 2, "generations": 2, "trials": 1,
        "selection_trials": 1, "report_trials": 2, "seed": 7
    });
    let again = api.call("POST", "/v1/evolutions", &key, body.to_string()).await;
    assert_eq!((again.code, &again.json()["evolution"]), (200, &json!("evolution-1")));
    assert_eq!(api.begin(&crate::evolutions::small()).await, "/v1/evolutions/evolution-3");
}
