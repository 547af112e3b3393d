//! What may be submitted as an evolution, and what is listed.

use crate::api::{Api, JSON};
use crate::evolutions::{long, small};
use crate::jobs::{Follower, hurried, serve};
use serde_json::{Value, json};
use std::sync::Arc;
use umwelt_server::Config;
use umwelt_server::store::MemoryStore;

fn pair(status: &str, reason: &str) -> (String, String) {
    (status.to_owned(), reason.to_owned())
}

#[tokio::test]
async fn everything_that_is_wrong_is_said_at_once() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let refused = api
        .submit(&json!({
            "environments": ["normal", "lava", "normal"], "population": 1, "generations": 1001, "trials": 0,
            "selection_trials": 1001, "report_trials": 1, "crossover_probability": 0.9,
            "reproduction_probability": -0.1, "expansion": 11, "max_deviation_m": 0, "max_time_s": 601,
            "horizon_slots": 0, "seed": -1.5, "prior": "Thesis!"
        }))
        .await;
    // The type of a field is seen before its range.
    assert_eq!((refused.code, refused.fields()), (400, vec!["seed".to_owned()]));
    let refused = api
        .submit(&json!({
            "environments": ["normal", "lava", "normal"], "population": 1, "generations": 1001, "trials": 0,
            "selection_trials": 1001, "report_trials": 1, "crossover_probability": 0.9,
            "reproduction_probability": -0.1, "expansion": 11, "max_deviation_m": 0, "max_time_s": 601,
            "horizon_slots": 0, "prior": "Thesis!", "elites": 4, "colour": "red"
        }))
        .await;
    let fields = refused.fields();
    for field in [
        "environments[1]",
        "environments[2]",
        "population",
        "generations",
        "trials",
        "selection_trials",
        "report_trials",
        "crossover_probability",
        "reproduction_probability",
        "expansion",
        "max_deviation_m",
        "max_time_s",
        "horizon_slots",
        "prior",
        "elites",
        "colour",
    ] {
        assert!(fields.iter().any(|it| it == field), "{field} is not in {fields:?}");
    }
    assert_eq!(api.get("/v1/evolutions").await.json()["evolutions"], json!([]));
    for (body, reason, field) in [
        (json!({"crossover_probability": 0.5}), "INCONSISTENT", "crossover_probability"),
        (json!({"environments": []}), "WRONG_LENGTH", "environments"),
        (json!({"environments": vec!["normal"; 33]}), "WRONG_LENGTH", "environments"),
        (json!({"prior": "thesis"}), "BUILT_IN", "prior"),
        (json!({"preset": "huge"}), "MALFORMED", "preset"),
        (
            json!({"population": 1000, "generations": 1000, "trials": 100}),
            "INCONSISTENT",
            "population",
        ),
    ] {
        let refused = api.submit(&body).await;
        assert_eq!(refused.problem(), pair("INVALID_ARGUMENT", reason), "{body}");
        assert_eq!(refused.fields()[0], field);
    }
    for path in ["/v1/evolutions/x", "/v1/evolutions/evolution-01", "/v1/evolutions/evolution--1"] {
        assert_eq!(api.get(path).await.code, 404, "{path}");
    }
    assert_eq!(
        api.get("/v1/evolutions/_a").await.problem(),
        pair("INVALID_ARGUMENT", "INVALID_ID")
    );
    let query = "/v1/evolutions?page_size=0&state=dead&page_token=x&sort=up";
    assert_eq!(api.get(query).await.fields(), ["state", "page_token", "sort", "page_size"]);
}

#[tokio::test]
async fn champions_never_take_a_name_that_is_taken() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let flat = json!({"forward": {"mu": 0.1, "k": 1.0, "r": 4.0, "s": 0.1}});
    assert_eq!(api.put("/v1/priors/mine", flat.clone()).await.code, 201);
    assert_eq!(api.put("/v1/priors/evolution-1", flat.clone()).await.code, 201);
    let named = |name: &str| {
        let mut body = long();
        body["prior"] = name.into();
        body
    };
    let taken = api.submit(&named("mine")).await;
    assert_eq!((taken.code, taken.problem()), (409, pair("ALREADY_EXISTS", "NAME_TAKEN")));
    // Without a name it has that of the evolution, which is then a free one.
    assert_eq!(api.begin(&long()).await, "/v1/evolutions/evolution-2");
    assert_eq!(api.get("/v1/evolutions/evolution-2").await.json()["spec"]["prior"], "evolution-2");
    api.begin(&named("oasis")).await;
    for reserved in ["oasis", "evolution-2"] {
        let taken = api.submit(&named(reserved)).await;
        assert_eq!(taken.problem(), pair("ALREADY_EXISTS", "NAME_TAKEN"));
        let put = api.put(&format!("/v1/priors/{reserved}"), flat.clone()).await;
        assert_eq!(put.problem(), pair("ALREADY_EXISTS", "NAME_TAKEN"));
    }
    assert_eq!(api.post("/v1/evolutions/evolution-3/cancel").await.code, 200);
    assert_eq!(api.put("/v1/priors/oasis", flat).await.code, 201, "it is free again");
}

/// Guards against: a client that asks again after a broken connection starts an evolution of hours twice.
#[tokio::test]
async fn the_same_key_gives_the_same_evolution_also_after_a_restart() {
    let store = Arc::new(MemoryStore::default());
    let api = serve(store.clone()).await;
    let post = async |api: &Api, key: &str, body: &str| {
        let headers = [JSON, ("idempotency-key", key)];
        api.call("POST", "/v1/evolutions", &headers, body.to_owned()).await
    };
    let body = small().to_string();
    let posts = (0..8).map(|_| {
        let (api, body) = (api.clone(), body.clone());
        tokio::spawn(async move {
            let headers = [JSON, ("idempotency-key", "night")];
            api.call("POST", "/v1/evolutions", &headers, body).await
        })
    });
    let mut codes = Vec::new();
    for post in posts.collect::<Vec<_>>() {
        let answer = post.await.unwrap();
        assert_eq!(answer.json()["evolution"], "evolution-1");
        assert_eq!(answer.headers["location"], "/v1/evolutions/evolution-1");
        codes.push(answer.code);
    }
    codes.sort_unstable();
    assert_eq!(codes, [200, 200, 200, 200, 200, 200, 200, 201]);
    let spaced = serde_json::to_string_pretty(&small()).unwrap();
    assert_eq!(
        post(&api, "night", &spaced).await.code,
        200,
        "the meaning counts, not the spelling"
    );
    let other = post(&api, "night", "{}").await;
    assert_eq!(other.problem(), pair("FAILED_PRECONDITION", "IDEMPOTENCY_KEY_REUSED"));
    // Its own prior, once it is there, is no obstacle.
    Follower::open(&api, "/v1/evolutions/evolution-1", None)
        .await
        .until(|event| event["state"] == "succeeded")
        .await;
    assert_eq!(post(&api, "night", &body).await.code, 200);
    drop(api);
    let restarted = serve(store).await;
    let again = post(&restarted, "night", &body).await;
    assert_eq!((again.code, &again.json()["state"]), (200, &json!("succeeded")));
    let other = post(&restarted, "night", "{}").await;
    assert_eq!(other.problem(), pair("FAILED_PRECONDITION", "IDEMPOTENCY_KEY_REUSED"));
    for wrong in ["", "two words", &"x".repeat(129)] {
        let refused = post(&restarted, wrong, &body).await;
        assert_eq!(refused.fields(), ["Idempotency-Key"], "{wrong:?}");
    }
    let twice = [JSON, ("idempotency-key", "a"), ("idempotency-key", "b")];
    let refused = restarted.call("POST", "/v1/evolutions", &twice, body).await;
    assert_eq!(refused.fields(), ["Idempotency-Key"]);
}

#[tokio::test]
async fn a_full_queue_refuses_and_the_newest_are_listed_first() {
    let config = Config { max_queued_evolutions: 2, ..hurried() };
    let api = Api::with(config, Arc::new(MemoryStore::default())).await;
    let running = api.begin(&long()).await;
    Follower::open(&api, &running, None).await.until(|event| event["state"] == "running").await;
    api.begin(&long()).await;
    api.begin(&long()).await;
    let full = api.submit(&long()).await;
    assert_eq!((full.code, full.problem()), (429, pair("RESOURCE_EXHAUSTED", "QUEUE_FULL")));
    assert_eq!(full.headers["retry-after"], "1");

    let ids = |page: &Value| -> Vec<String> {
        let evolutions = page["evolutions"].as_array().unwrap().iter();
        evolutions.map(|it| it["evolution"].as_str().unwrap().to_owned()).collect()
    };
    let page = api.get("/v1/evolutions?page_size=2").await.json();
    assert_eq!(ids(&page), ["evolution-3", "evolution-2"]);
    let token = page["next_page_token"].as_str().unwrap();
    let rest = api.get(&format!("/v1/evolutions?page_size=2&page_token={token}")).await.json();
    assert_eq!(
        (ids(&rest), &rest["next_page_token"]),
        (vec!["evolution-1".to_owned()], &Value::Null)
    );
    assert_eq!(api.post("/v1/evolutions/evolution-2/cancel").await.code, 200);
    for (state, expected) in [
        ("running", vec!["evolution-1"]),
        ("queued", vec!["evolution-3"]),
        ("cancelled", vec!["evolution-2"]),
        ("failed", vec![]),
    ] {
        let page = api.get(&format!("/v1/evolutions?state={state}")).await.json();
        assert_eq!(ids(&page), expected, "{state}");
    }
    let figure = api.get("/v1/evolutions/evolution-3/figures/time").await;
    assert_eq!(figure.problem(), pair("FAILED_PRECONDITION", "NOTHING_YET"));
    assert_eq!(api.submit(&long()).await.code, 201, "there is a place again");
}
