//! Comparisons in the background: the life that they share with evolutions, and what is theirs alone.

use crate::api::{Answer, Api, JSON};
use crate::evolutions;
use crate::jobs::{Follower, ended, hurried, serve, serve_and_stop};
use serde_json::{Value, json};
use std::sync::Arc;
use umwelt_api::comparison::{Request, TRIALS_COLUMNS};
use umwelt_server::offline::{Order, compare};
use umwelt_server::store::{JobId, MemoryStore, StoredKind};
use umwelt_server::{Config, Store};

const PATH: &str = "/v1/comparisons";

/// A comparison of a second or so: two contenders in two environments, which have to be told apart.
fn small() -> Value {
    json!({"methods": ["statistic/1", "bayesian/1"], "trials": 6, "seed": 7})
}

/// One that does not end while a test lasts.
fn long() -> Value {
    json!({"methods": ["statistic/1"], "trials": 10_000})
}

async fn submit(api: &Api, body: &Value) -> Answer {
    api.call("POST", PATH, &[JSON], body.to_string()).await
}

/// Submits a comparison and returns its path.
async fn begin(api: &Api, body: &Value) -> String {
    let answer = submit(api, body).await;
    assert_eq!(answer.code, 201, "{}", String::from_utf8_lossy(&answer.bytes));
    answer.headers["location"].to_str().unwrap().to_owned()
}

fn pair(status: &str, reason: &str) -> (String, String) {
    (status.to_owned(), reason.to_owned())
}

fn id(number: u64) -> JobId {
    JobId { kind: StoredKind::Comparison, number }
}

#[tokio::test]
async fn a_comparison_lives_from_its_submission_to_its_trials() {
    let store = Arc::new(MemoryStore::default());
    let api = serve(store.clone()).await;
    let answer = submit(&api, &small()).await;
    let path = "/v1/comparisons/comparison-1";
    assert_eq!((answer.code, &answer.headers["location"]), (201, &path.parse().unwrap()));
    let spec = answer.json()["spec"].clone();
    assert_eq!(spec["methods"], json!(["statistic/1", "bayesian/1"]));
    assert_eq!(spec["environments"], json!(["normal", "bad-link"]));
    assert_eq!((&spec["prior"], &answer.json()["report"]), (&json!("thesis"), &Value::Null));

    let events = Follower::open(&api, path, None).await.rest().await;
    assert!(events.is_sorted_by_key(|event| event["id"].as_u64()), "{events:?}");
    let last = events.last().unwrap();
    assert_eq!((&last["state"], &last["id"]), (&json!("succeeded"), &json!(6)));

    let shown = api.get(path).await.json();
    assert_eq!(shown["progress"]["stage"], "done");
    assert_eq!(shown["progress"]["episodes"], shown["progress"]["total_episodes"]);
    let environments = shown["report"]["environments"].as_array().unwrap();
    let entries = environments[1]["entries"].as_array().unwrap();
    assert_eq!(entries[1]["difference"]["against"], "statistic/1");
    assert_eq!(shown["report"]["claims"].as_array().unwrap().len(), 2);
    let listed = api.get(PATH).await.json();
    assert_eq!(listed["comparisons"][0]["state"], "succeeded");
    assert_eq!(listed["comparisons"][0]["report"], Value::Null, "a list is no place for it");

    let trials = api.get(&format!("{path}/trials.csv")).await;
    assert_eq!((trials.code, &trials.headers["content-type"]), (200, &"text/csv".parse().unwrap()));
    let text = String::from_utf8(trials.bytes).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(TRIALS_COLUMNS.join(",").as_str()));
    let begins: Vec<_> = lines.map(|line| line.rsplitn(7, ',').last().unwrap()).collect();
    let expected = ["normal", "bad-link"].into_iter().flat_map(|environment| {
        let contenders = ["statistic/1", "bayesian/1"].into_iter();
        contenders
            .flat_map(move |it| (0..6).map(move |trial| format!("{environment},{it},{trial}")))
    });
    assert_eq!(begins, expected.collect::<Vec<_>>());

    for figure in ["deviation", "time", "pareto"] {
        let figure = api.get(&format!("{path}/figures/{figure}")).await;
        assert_eq!(
            (figure.code, &figure.headers["content-type"]),
            (200, &"image/svg+xml".parse().unwrap())
        );
        assert!(figure.bytes.starts_with(b"<svg"));
    }
    assert_eq!(api.get(&format!("{path}/figures/cost")).await.code, 404);

    let report = api.get(&format!("{path}/report.md")).await;
    assert_eq!(report.headers["content-type"], "text/markdown");
    let report = String::from_utf8(report.bytes).unwrap();
    assert!(report.starts_with("# ") && report.contains("bayesian/1"), "{report}");

    // Who has it does not get it again, not from another server either.
    let restarted = serve(store.clone()).await;
    for document in ["trials.csv", "figures/pareto", "report.md"] {
        let document = format!("{path}/{document}");
        let first = api.get(&document).await;
        let etag = first.headers["etag"].to_str().unwrap();
        for server in [&api, &restarted] {
            assert_eq!(server.get(&document).await.bytes, first.bytes);
            let again = server.call("GET", &document, &[("if-none-match", etag)], "").await;
            assert_eq!((again.code, again.bytes.len()), (304, 0), "{document}");
            let other = server.call("GET", &document, &[("if-none-match", "\"other\"")], "").await;
            assert_eq!((other.code, &other.bytes), (200, &first.bytes), "{document}");
        }
    }
    // Another server has it all from the store.
    assert_eq!(restarted.get(path).await.json(), shown);
    assert_eq!(restarted.get(&format!("{path}/trials.csv")).await.bytes, text.as_bytes());
    assert_eq!(restarted.delete(path).await.code, 204);
    for gone in [path.to_owned(), format!("{path}/trials.csv")] {
        let gone = restarted.get(&gone).await;
        assert_eq!(gone.problem(), pair("NOT_FOUND", "NO_SUCH_RESOURCE"));
    }
    assert_eq!(store.parts(id(1), 0, 9).unwrap(), []);
    assert_eq!(begin(&restarted, &long()).await, "/v1/comparisons/comparison-2");
}

/// Guards against: two doors to the same comparison that lead to different numbers, and a restart that changes them.
#[tokio::test]
async fn a_comparison_goes_on_after_a_restart_to_the_report_of_the_offline_command() {
    let body = json!({"methods": ["statistic/1", "bayesian/1"], "trials": 60, "seed": 7});
    let request: Request = serde_json::from_value(body.clone()).unwrap();
    let order = Order { request, threads: Some(1), json: true, folder: None };
    let offline = tokio::task::spawn_blocking(move || {
        let mut output = Vec::new();
        compare(&order, &mut output).unwrap();
        serde_json::from_slice::<Value>(&output).unwrap()
    });

    let store = Arc::new(MemoryStore::default());
    // By this very server: only then it is known how long it will take.
    let is_driving = |event: &Value| {
        event["progress"]["stage"] == "trials" && event["progress"]["remaining_s"].is_number()
    };
    let mut waiting = String::new();
    serve_and_stop(store.clone(), async |api| {
        let path = begin(&api, &body).await;
        waiting = begin(&api, &small()).await;
        Follower::open(&api, &path, None).await.until(is_driving).await;
    })
    .await;
    let kept = &store.load().unwrap().jobs[0];
    assert!(kept.body.contains(r#""state":"running""#) && !kept.finished, "{}", kept.body);
    assert!(store.checkpoint(id(1)).unwrap().is_some(), "behind the reference");

    // The second one dies without a word.
    let path = "/v1/comparisons/comparison-1";
    let second = serve(store.clone()).await;
    Follower::open(&second, path, None).await.until(is_driving).await;
    drop(second);

    let third = serve(store.clone()).await;
    let shown = ended(&third, path).await;
    let expected = offline.await.unwrap();
    assert_eq!((&shown["state"], &shown["interrupted"]), (&json!("succeeded"), &json!(2)));
    assert_eq!(shown["report"], expected["report"]);
    assert_eq!(shown["spec"], expected["spec"]);
    assert_eq!(shown["progress"]["episodes"], expected["episodes"]);
    assert_eq!(store.parts(id(1), 0, 9).unwrap().len(), 4);
    assert_eq!(store.checkpoint(id(1)).unwrap(), None);
    let waited = ended(&third, &waiting).await;
    assert_eq!((&waited["state"], &waited["interrupted"]), (&json!("succeeded"), &json!(0)));
}

#[tokio::test]
async fn a_cancelled_comparison_stops_in_the_queue_and_while_it_runs() {
    let store = Arc::new(MemoryStore::default());
    let api = serve(store.clone()).await;
    let running = begin(&api, &long()).await;
    let mut follower = Follower::open(&api, &running, None).await;
    follower.until(|event| event["progress"]["stage"] == "trials").await;
    let waiting = begin(&api, &small()).await;
    for path in [&running, &waiting] {
        let refused = api.delete(path).await;
        assert_eq!(refused.problem(), pair("FAILED_PRECONDITION", "NOT_ENDED"));
        for early in ["trials.csv", "report.md", "figures/pareto"] {
            let early = api.get(&format!("{path}/{early}")).await;
            assert_eq!(early.problem(), pair("FAILED_PRECONDITION", "NOTHING_YET"));
        }
    }
    let cancel = async |path: &str| api.post(&format!("{path}/cancel")).await;
    let cancelled = cancel(&waiting).await.json();
    assert_eq!(
        (&cancelled["state"], &cancelled["progress"]["stage"]),
        (&json!("cancelled"), &json!("queued"))
    );
    let cancelled = cancel(&running).await.json();
    assert_eq!((&cancelled["state"], &cancelled["report"]), (&json!("cancelled"), &Value::Null));
    assert_eq!(cancel(&running).await.json(), cancelled, "once more is no harm");
    assert_eq!(store.checkpoint(id(1)).unwrap(), None);
    assert_eq!(store.parts(id(1), 0, 9).unwrap(), []);

    let done = begin(&api, &small()).await;
    assert_eq!(ended(&api, &done).await["state"], "succeeded", "the next has its turn");
    assert_eq!(cancel(&done).await.problem(), pair("FAILED_PRECONDITION", "ENDED"));
    assert_eq!(cancel("/v1/comparisons/comparison-9").await.code, 404);
    let restarted = serve(store).await;
    for path in [&running, &waiting, &done] {
        assert_eq!(restarted.get(path).await.json(), api.get(path).await.json());
    }
}

/// Guards against: one kind of job that keeps the other from its turn.
#[tokio::test]
async fn comparisons_and_evolutions_run_beside_each_other_and_have_queues_of_their_own() {
    let config = Config { max_queued_comparisons: 1, max_queued_evolutions: 1, ..hurried() };
    let api = Api::with(config, Arc::new(MemoryStore::default())).await;
    let is_running = |event: &Value| event["state"] == "running";
    let evolution = api.begin(&evolutions::long()).await;
    Follower::open(&api, &evolution, None).await.until(is_running).await;
    api.begin(&evolutions::long()).await;
    let full = api.submit(&evolutions::long()).await;
    assert_eq!(full.problem(), pair("RESOURCE_EXHAUSTED", "QUEUE_FULL"));

    let comparison = begin(&api, &small()).await;
    assert_eq!(ended(&api, &comparison).await["state"], "succeeded");
    assert_eq!(api.get(&evolution).await.json()["state"], "running");
    let comparison = begin(&api, &long()).await;
    let mut follower = Follower::open(&api, &comparison, None).await;
    follower.until(is_running).await;
    begin(&api, &long()).await;
    let full = submit(&api, &long()).await;
    assert_eq!((full.code, full.problem()), (429, pair("RESOURCE_EXHAUSTED", "QUEUE_FULL")));
    assert!(full.json()["error"]["message"].as_str().unwrap().contains("comparisons wait"));

    // Both get on.
    let before = follower.until(is_running).await["progress"]["episodes"].as_u64();
    let generation = api.get(&evolution).await.json()["progress"]["generation"].as_u64();
    let goes_on = |event: &Value| event["progress"]["episodes"].as_u64() > before;
    follower.until(goes_on).await;
    let mut other = Follower::open(&api, &evolution, None).await;
    other.until(|event| event["progress"]["generation"].as_u64() > generation).await;

    let ids = |page: &Value| -> Vec<String> {
        let comparisons = page["comparisons"].as_array().unwrap().iter();
        comparisons.map(|it| it["comparison"].as_str().unwrap().to_owned()).collect()
    };
    let page = api.get(&format!("{PATH}?page_size=2")).await.json();
    assert_eq!(ids(&page), ["comparison-3", "comparison-2"]);
    let token = page["next_page_token"].as_str().unwrap();
    let rest = api.get(&format!("{PATH}?page_token={token}")).await.json();
    assert_eq!(ids(&rest), ["comparison-1"]);
    let queued = api.get(&format!("{PATH}?state=queued")).await.json();
    assert_eq!(ids(&queued), ["comparison-3"]);
}

#[tokio::test]
async fn the_same_key_gives_the_same_comparison_also_after_a_restart() {
    let store = Arc::new(MemoryStore::default());
    let post = async |api: &Api, key: &str, body: &str| {
        let headers = [JSON, ("idempotency-key", key)];
        api.call("POST", PATH, &headers, body.to_owned()).await
    };
    let api = serve(store.clone()).await;
    // A key of an evolution is another one.
    let evolution = evolutions::small().to_string();
    let headers = [JSON, ("idempotency-key", "night")];
    assert_eq!(api.call("POST", "/v1/evolutions", &headers, evolution).await.code, 201);
    let body = small().to_string();
    assert_eq!(post(&api, "night", &body).await.code, 201);
    let spaced = serde_json::to_string_pretty(&small()).unwrap();
    let again = post(&api, "night", &spaced).await;
    assert_eq!((again.code, &again.json()["comparison"]), (200, &json!("comparison-1")));
    ended(&api, "/v1/comparisons/comparison-1").await;
    drop(api);
    let restarted = serve(store).await;
    let again = post(&restarted, "night", &body).await;
    assert_eq!((again.code, &again.json()["state"]), (200, &json!("succeeded")));
    assert_eq!(again.headers["location"], "/v1/comparisons/comparison-1");
    let other = post(&restarted, "night", "{}").await;
    assert_eq!(other.problem(), pair("FAILED_PRECONDITION", "IDEMPOTENCY_KEY_REUSED"));
}

#[tokio::test]
async fn what_makes_no_sense_is_refused_all_of_it_at_once() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let wrong = json!({
        "methods": ["statistic", "luck", "statistic/1"], "trials": 1, "prior": "oasis", "colour": "red"
    });
    let fields = submit(&api, &wrong).await.fields();
    for field in ["methods[1]", "methods[2]", "trials", "prior", "colour"] {
        assert!(fields.iter().any(|it| it == field), "{field} is not in {fields:?}");
    }
    let long = submit(&api, &json!({"trials": 10_000})).await;
    assert_eq!((long.code, long.fields()), (409, vec!["trials".to_owned()]));
    assert_eq!(api.get(PATH).await.json()["comparisons"], json!([]));
    for path in ["x", "comparison-01", "evolution-1"] {
        assert_eq!(api.get(&format!("{PATH}/{path}")).await.code, 404, "{path}");
    }
    let refused = api.get(&format!("{PATH}/_a")).await;
    assert_eq!((refused.problem(), refused.fields()), {
        (pair("INVALID_ARGUMENT", "INVALID_ID"), vec!["comparison".to_owned()])
    });
}

/// Guards against: a comparison that is resumed with another prior than it was begun with.
#[tokio::test]
async fn a_comparison_keeps_the_prior_that_it_was_submitted_with() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let prior = |mu: f64| json!({"forward": {"mu": mu, "k": 50.0, "r": 40.0, "s": 0.5}});
    assert_eq!(api.put("/v1/priors/mine", prior(0.1)).await.code, 201);
    // What runs holds the others up until the prior has changed.
    let first = begin(&api, &long()).await;
    let mut body = small();
    body["prior"] = json!("mine");
    let then = begin(&api, &body).await;
    assert_eq!(api.put("/v1/priors/mine", prior(0.4)).await.code, 200);
    let changed = begin(&api, &body).await;
    assert_eq!(api.delete("/v1/priors/mine").await.code, 204);
    assert_eq!(api.post(&format!("{first}/cancel")).await.code, 200);
    let [then, changed] = [ended(&api, &then).await, ended(&api, &changed).await];
    for shown in [&then, &changed] {
        assert_eq!(
            (&shown["state"], &shown["spec"]["prior"]),
            (&json!("succeeded"), &json!("mine"))
        );
    }
    assert_ne!(then["report"], changed["report"]);
}

#[tokio::test]
async fn the_oldest_that_have_ended_are_forgotten() {
    let store = Arc::new(MemoryStore::default());
    let config = Config { keep_comparisons: 1, ..hurried() };
    let api = Api::with(config, store.clone()).await;
    let evolution = api.begin(&evolutions::small()).await;
    let first = begin(&api, &small()).await;
    ended(&api, &first).await;
    ended(&api, &evolution).await;
    let second = begin(&api, &small()).await;
    ended(&api, &second).await;
    assert_eq!((api.get(&first).await.code, api.get(&second).await.code), (404, 200));
    assert_eq!(
        (store.parts(id(1), 0, 9).unwrap().len(), store.parts(id(2), 0, 9).unwrap().len()),
        (0, 4)
    );
    assert_eq!(api.get(&evolution).await.code, 200, "each kind has a number of its own");
}
