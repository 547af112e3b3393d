//! Evolutions in the background: their life, their end, and that a restart changes nothing.

use crate::api::Api;
use crate::jobs::{Follower, ended, hurried, serve, serve_and_stop};
use crate::stores::{Faulty, UNAVAILABLE, WORKS};
use axum::body::Body;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use umwelt_api::evolution::Request;
use umwelt_server::offline::{Order, evolve};
use umwelt_server::store::{Change, JobId, MemoryStore, StoredKind};
use umwelt_server::{Config, Store};

/// An evolution of a second or so.
pub(crate) fn small() -> Value {
    json!({
        "preset": "quick", "environments": ["normal"], "population": 4, "generations": 3, "trials": 1,
        "selection_trials": 1, "report_trials": 2, "seed": 7
    })
}

/// One that does not end while a test lasts.
pub(crate) fn long() -> Value {
    json!({"preset": "quick", "environments": ["normal"], "population": 4, "generations": 1000, "trials": 1})
}

fn generations(events: &[Value]) -> Vec<&Value> {
    events.iter().filter(|event| event["type"] == "generation").collect()
}

fn ids(events: &[Value]) -> Vec<u64> {
    generations(events).iter().map(|event| event["id"].as_u64().unwrap()).collect()
}

#[tokio::test]
async fn an_evolution_lives_from_its_submission_to_a_prior_that_a_robot_uses() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let answer = api.submit(&small()).await;
    assert_eq!(
        (answer.code, &answer.headers["location"]),
        (201, &"/v1/evolutions/evolution-1".parse().unwrap())
    );
    let path = "/v1/evolutions/evolution-1";
    let begun = answer.json();
    assert_eq!(
        (begun["spec"]["population"].as_u64(), begun["spec"]["seed"].as_u64()),
        (Some(4), Some(7))
    );
    assert_eq!(begun["champion"], Value::Null);

    let events = Follower::open(&api, path, None).await.rest().await;
    assert_eq!(ids(&events), [1, 2, 3]);
    for (place, event) in events.iter().enumerate().filter(|(_, event)| event["type"] == "state") {
        let told = generations(&events[..place]).len() as u64;
        assert_eq!(event["progress"]["generation"].as_u64(), Some(told), "nothing untold counts");
    }
    assert_eq!(events.last().unwrap()["state"], "succeeded");

    let shown = api.get(path).await.json();
    assert_eq!((&shown["state"], &shown["prior"]), (&json!("succeeded"), &json!("evolution-1")));
    assert_eq!(shown["progress"]["episodes"], shown["progress"]["total_episodes"]);
    let names: Vec<_> =
        shown["champion"]["entries"].as_array().unwrap().iter().map(|it| &it["name"]).collect();
    assert_eq!(names, ["champion", "first-generation", "default", "flat"]);
    let page = api.get(&format!("{path}/generations?page_size=2")).await.json();
    assert_eq!(page["generations"].as_array().unwrap().len(), 2);
    let token = page["next_page_token"].as_str().unwrap();
    let rest = api.get(&format!("{path}/generations?page_token={token}")).await.json();
    assert_eq!(
        (rest["generations"][0]["index"].as_u64(), &rest["next_page_token"]),
        (Some(2), &Value::Null)
    );
    for name in ["deviation", "time"] {
        let figure = api.get(&format!("{path}/figures/{name}")).await;
        assert_eq!(
            (figure.code, &figure.headers["content-type"]),
            (200, &"image/svg+xml".parse().unwrap())
        );
        assert!(figure.bytes.starts_with(b"<svg"));
        let known = [("if-none-match", figure.headers["etag"].to_str().unwrap())];
        let again = format!("{path}/figures/{name}");
        assert_eq!(api.call("GET", &again, &known, "").await.code, 304);
    }
    assert_eq!(api.get(&format!("{path}/figures/cost")).await.code, 404);

    let prior = api.get("/v1/priors/evolution-1").await.json();
    assert_eq!(prior["forward"], shown["champion"]["prior"]["forward"]);
    assert_eq!(prior["source"]["evolution"], "evolution-1");
    assert_eq!(api.put("/v1/robots/r", json!({"prior": "evolution-1"})).await.code, 201);
    let used = api.get("/v1/robots/r/environment").await.json()["prior"].clone();
    assert_eq!((&used["name"], &used["source"]["seed"]), (&json!("evolution-1"), &json!(7)));
    assert!(used["why"].as_str().unwrap().contains("evolution-1 found"), "{used}");

    assert_eq!(api.delete(path).await.code, 204);
    assert_eq!(api.get(path).await.problem(), ("NOT_FOUND".into(), "NO_SUCH_RESOURCE".into()));
    assert_eq!(api.get(&format!("{path}/generations")).await.code, 404);
    assert_eq!(api.get("/v1/priors/evolution-1").await.code, 200);
}

/// Guards against: two doors to the same evolution that lead to different champions.
#[tokio::test]
async fn a_server_finds_the_champion_that_the_offline_command_finds() {
    let request: Request = serde_json::from_value(small()).unwrap();
    let order = Order { request, threads: Some(1), json: true, folder: None };
    let offline = tokio::task::spawn_blocking(move || {
        let mut output = Vec::new();
        evolve(&order, &mut output).unwrap();
        serde_json::from_slice::<Value>(&output).unwrap()
    });
    let api = serve(Arc::new(MemoryStore::default())).await;
    let path = api.begin(&small()).await;
    let (online, offline) = (ended(&api, &path).await, offline.await.unwrap());
    assert_eq!(online["champion"], offline["champion"]);
    assert_eq!(online["progress"]["episodes"], offline["episodes"]);
}

#[tokio::test]
async fn a_cancelled_evolution_stops_in_the_queue_and_while_it_runs() {
    let store = Arc::new(MemoryStore::default());
    let api = serve(store.clone()).await;
    let running = api.begin(&long()).await;
    Follower::open(&api, &running, None).await.until(|event| event["id"] == 2).await;
    let waiting = api.begin(&small()).await;
    for path in [&running, &waiting] {
        let refused = api.delete(path).await;
        assert_eq!(refused.problem(), ("FAILED_PRECONDITION".into(), "NOT_ENDED".into()));
    }
    let cancel = async |path: &str| api.post(&format!("{path}/cancel")).await;
    let cancelled = cancel(&waiting).await.json();
    assert_eq!(
        (&cancelled["state"], &cancelled["progress"]["stage"]),
        (&json!("cancelled"), &json!("queued"))
    );
    let asked = std::time::Instant::now();
    let cancelled = cancel(&running).await;
    assert!(asked.elapsed() < Duration::from_secs(10), "{:?}", asked.elapsed());
    let cancelled = cancelled.json();
    assert_eq!((&cancelled["state"], &cancelled["prior"]), (&json!("cancelled"), &Value::Null));
    assert!(cancelled["progress"]["generation"].as_u64() >= Some(2), "{cancelled}");
    let generations = api.get(&format!("{running}/generations")).await.json();
    let kept = generations["generations"].as_array().unwrap().len() as u64;
    assert_eq!(Some(kept), cancelled["progress"]["generation"].as_u64());
    assert_eq!(cancel(&running).await.json(), cancelled, "once more is no harm");
    assert_eq!(api.get("/v1/priors/evolution-1").await.code, 404);

    let done = api.begin(&small()).await;
    assert_eq!(ended(&api, &done).await["state"], "succeeded", "the next has its turn");
    assert_eq!(cancel(&done).await.problem(), ("FAILED_PRECONDITION".into(), "ENDED".into()));
    assert_eq!(cancel("/v1/evolutions/evolution-9").await.code, 404);
    let restarted = serve(store).await;
    for path in [&running, &waiting, &done] {
        assert_eq!(restarted.get(path).await.json(), api.get(path).await.json());
    }
    assert_eq!(restarted.delete(&running).await.code, 204);
}

/// Guards against: a cancellation that waits for a batch of minutes.
#[tokio::test]
async fn a_cancellation_does_not_wait_for_a_long_batch() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let mut body = long();
    (body["generations"], body["population"], body["trials"]) = (json!(1), json!(1000), json!(100));
    let path = api.begin(&body).await;
    let mut follower = Follower::open(&api, &path, None).await;
    follower.until(|event| event["progress"]["stage"] == "generations").await;
    let asked = std::time::Instant::now();
    assert_eq!(api.post(&format!("{path}/cancel")).await.json()["state"], "cancelled");
    assert!(asked.elapsed() < Duration::from_secs(5), "{:?}", asked.elapsed());
}

/// Guards against: a generation lost, told twice or driven on other seeds after a restart.
#[tokio::test]
async fn an_evolution_goes_on_after_a_restart_as_if_nothing_had_been() {
    let uninterrupted = serve(Arc::new(MemoryStore::default())).await;
    let path = uninterrupted.begin(&small()).await;
    let expected = ended(&uninterrupted, &path).await;

    let store = Arc::new(MemoryStore::default());
    let mut before = Vec::new();
    serve_and_stop(store.clone(), async |api| {
        let path = api.begin(&small()).await;
        let waiting = Value::from("second");
        api.begin(&json!({"prior": waiting, "preset": "quick", "seed": 7})).await;
        let mut follower = Follower::open(&api, &path, None).await;
        before.push(follower.until(|event| event["type"] == "generation").await);
    })
    .await;
    let last = before[0]["id"].as_u64().unwrap();
    let body = &store.load().unwrap().jobs[0].body;
    assert!(body.contains(r#""state":"running""#), "{body}");

    // The second one dies without a word.
    let second = serve(store.clone()).await;
    let mut follower = Follower::open(&second, &path, Some(last)).await;
    before.push(follower.until(|event| event["type"] == "generation").await);
    drop((second, follower));

    let third = serve(store).await;
    let shown = third.get(&path).await.json();
    assert!(shown["progress"]["generation"].as_u64() >= Some(2), "{shown}");
    let after = Follower::open(&third, &path, Some(last + 1)).await.rest().await;
    before.extend(after);
    assert_eq!(ids(&before), [1, 2, 3]);
    let resumed = third.get(&path).await.json();
    for field in ["state", "champion", "spec", "prior"] {
        assert_eq!(resumed[field], expected[field], "{field}");
    }
    assert_eq!(resumed["interrupted"], 2);
    assert!(resumed["progress"]["elapsed_s"].as_f64() > Some(0.0));
    let generations = async |api: &Api| api.get(&format!("{path}/generations")).await.json();
    assert_eq!(generations(&third).await, generations(&uninterrupted).await);
    // What waited has its turn, and does not count as interrupted.
    let second = "/v1/evolutions/evolution-2";
    let mut follower = Follower::open(&third, second, None).await;
    follower.until(|event| event["state"] == "running").await;
    assert_eq!(third.get(second).await.json()["interrupted"], 0);
}

/// Guards against: a server that dies of what an older or newer one has left.
#[tokio::test]
async fn a_checkpoint_that_cannot_be_used_ends_its_evolution_and_nothing_else() {
    for (checkpoint, said) in [
        (r#"{"version":9}"#, "version 9"),
        (r#"{"version":1,"content":{"evolution":{"version":77}}}"#, "version 77"),
        ("nonsense", "no body"),
    ] {
        let store = Arc::new(MemoryStore::default());
        let (mut path, mut next) = (String::new(), String::new());
        // Told to end, and waited for: one that was only dropped may still write its own checkpoint.
        serve_and_stop(store.clone(), async |first| {
            path = first.begin(&long()).await;
            Follower::open(&first, &path, None).await.until(|event| event["id"] == 1).await;
            next = first.begin(&small()).await;
        })
        .await;
        let job = JobId { kind: StoredKind::Evolution, number: 1 };
        let change = Change::PutCheckpoint { job, body: checkpoint.to_owned() };
        store.commit(vec![change]).unwrap();
        let second = serve(store.clone()).await;
        let failed = ended(&second, &path).await;
        assert_eq!(failed["state"], "failed");
        let error = failed["error"].as_str().unwrap();
        assert!(error.contains(said) && error.contains("submit it again"), "{error}");
        assert_eq!(ended(&second, &next).await["state"], "succeeded");
    }
}

/// Guards against: an evolution lost to a full disk, or shown as further than what a restart would find.
#[tokio::test]
async fn a_store_that_fails_delays_an_evolution_and_ends_none() {
    let store = Arc::new(Faulty::default());
    let api = serve(store.clone()).await;
    let path = api.begin(&small()).await;
    let mut follower = Follower::open(&api, &path, None).await;
    store.set(UNAVAILABLE);
    let delayed =
        follower.until(|event| event["error"] != Value::Null && event["type"] == "state").await;
    assert!(delayed["error"].as_str().unwrap().contains("disk full"), "{delayed}");
    let shown = api.get(&path).await.json();
    assert!(["queued", "running"].contains(&shown["state"].as_str().unwrap()), "{shown}");
    let refused = api.submit(&small()).await;
    assert_eq!(refused.problem(), ("UNAVAILABLE".into(), "STORE_FAILED".into()));
    assert_eq!(api.get("/v1/evolutions").await.json()["evolutions"].as_array().unwrap().len(), 1);
    store.set(WORKS);
    let listed = api.get(&format!("{path}/generations")).await.json();
    let shown = api.get(&path).await.json()["progress"]["generation"].as_u64().unwrap();
    assert!(listed["generations"].as_array().unwrap().len() as u64 <= shown);
    let after = ended(&api, &path).await;
    assert_eq!((&after["state"], &after["error"]), (&json!("succeeded"), &Value::Null));

    let reference = serve(Arc::new(MemoryStore::default())).await;
    let path = reference.begin(&small()).await;
    assert_eq!(ended(&reference, &path).await["champion"], after["champion"]);
}

/// Guards against: a cancellation that is acknowledged and undone by the next start.
#[tokio::test]
async fn a_cancellation_that_cannot_be_kept_is_not_acknowledged() {
    let store = Arc::new(Faulty::default());
    let api = serve(store.clone()).await;
    let path = api.begin(&long()).await;
    Follower::open(&api, &path, None).await.until(|event| event["id"] == 1).await;
    store.set(UNAVAILABLE);
    let refused = api.post(&format!("{path}/cancel")).await;
    assert_eq!(refused.problem(), ("UNAVAILABLE".into(), "STORE_FAILED".into()));
    assert_eq!(api.get(&path).await.json()["state"], "running");
    store.set(WORKS);
    assert_eq!(ended(&api, &path).await["state"], "cancelled");
    let restarted = serve(store).await;
    assert_eq!(restarted.get(&path).await.json()["state"], "cancelled");
}

#[tokio::test]
async fn a_stream_resumes_behind_the_last_event() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let path = api.begin(&small()).await;
    ended(&api, &path).await;
    for (after, expected) in [(0, vec![1, 2, 3]), (2, vec![3]), (3, vec![]), (99, vec![])] {
        let events = Follower::open(&api, &path, Some(after)).await.rest().await;
        assert_eq!(ids(&events), expected, "{after}");
        assert_eq!(events.last().unwrap()["state"], "succeeded");
    }
    let headers = [("last-event-id", "first")];
    let wrong = api.call("GET", &format!("{path}/events"), &headers, Body::empty()).await;
    assert_eq!(wrong.problem(), ("INVALID_ARGUMENT".into(), "MALFORMED".into()));
}

#[tokio::test]
async fn the_oldest_that_have_ended_are_forgotten() {
    let store = Arc::new(MemoryStore::default());
    let config = || Config { keep_evolutions: 1, ..hurried() };
    let api = Api::with(config(), store.clone()).await;
    let first = api.begin(&small()).await;
    ended(&api, &first).await;
    let second = api.begin(&small()).await;
    ended(&api, &second).await;
    assert_eq!((api.get(&first).await.code, api.get(&second).await.code), (404, 200));
    let gone = JobId { kind: StoredKind::Evolution, number: 1 };
    assert_eq!(store.parts(gone, 0, 9).unwrap(), []);
    assert_eq!(api.get("/v1/priors/evolution-1").await.code, 200);
    assert_eq!(api.delete(&second).await.code, 204);
    let restarted = Api::with(config(), store).await;
    let third = restarted.begin(&long()).await;
    assert_eq!(third, "/v1/evolutions/evolution-3", "numbers never come back");
    // One that has just ended stays, however old it is.
    let fourth = restarted.begin(&long()).await;
    for path in [&fourth, &third] {
        assert_eq!(restarted.post(&format!("{path}/cancel")).await.code, 200);
    }
    assert_eq!((restarted.get(&third).await.code, restarted.get(&fourth).await.code), (200, 404));
}

/// Guards against: an evolution in which no one ever arrives "succeeds", and what it drew at random is offered for use.
#[tokio::test]
async fn where_no_one_arrives_an_evolution_fails_and_says_why() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let dead = json!({"slip": "none", "link": {"rtt": {"kind": "constant", "rtt_s": 60}}});
    assert_eq!(api.put("/v1/environments/dead", dead).await.code, 201);
    let mut body = small();
    body["environments"] = json!(["dead"]);
    let path = api.begin(&body).await;
    let events = Follower::open(&api, &path, None).await.rest().await;
    assert_eq!(ids(&events), [1, 2, 3], "its generations are kept");
    let last = events.last().unwrap();
    let error = last["error"].as_str().unwrap();
    assert_eq!(last["state"], "failed");
    assert!(error.starts_with("nobody arrives in dead: "), "{error}");
    assert!(error.contains("use environments that can be driven"), "{error}");
    let shown = api.get(&path).await.json();
    assert_eq!(
        (&shown["error"], &shown["prior"], &shown["champion"]),
        (&json!(error), &Value::Null, &Value::Null)
    );
    assert_eq!(api.get("/v1/priors/evolution-1").await.code, 404);
    assert_eq!(shown["progress"]["generation"], 3);

    // Beside one that can be driven it is only told.
    body["environments"] = json!(["normal", "dead"]);
    let path = api.begin(&body).await;
    Follower::open(&api, &path, None).await.rest().await;
    let shown = api.get(&path).await.json();
    assert_eq!(shown["state"], "succeeded", "{shown}");
    let notes = shown["champion"]["notes"].as_array().unwrap();
    assert_eq!(notes.len(), 1);
    assert!(notes[0].as_str().unwrap().starts_with("in dead nobody arrives"), "{notes:?}");
}
