//! Named priors: who may change them, and what robots make of them.

use crate::api::{Api, JSON, config};
use crate::stores::Gate;
use serde_json::{Value, json};
use std::sync::Arc;
use umwelt_server::store::MemoryStore;

fn pair(status: &str, reason: &str) -> (String, String) {
    (status.to_owned(), reason.to_owned())
}

fn dune() -> Value {
    json!({"forward": {"mu": -0.2, "k": 5.0, "r": 8.0, "s": 0.1}, "note": "sand"})
}

fn names(page: &Value) -> Vec<&str> {
    page["priors"].as_array().unwrap().iter().map(|it| it["prior"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn a_prior_is_put_shown_listed_and_removed() {
    let store = Arc::new(MemoryStore::default());
    let api = Api::with(config(), store.clone()).await;
    let put = api.put("/v1/priors/dune", dune()).await;
    assert_eq!(put.code, 201);
    let shown = api.get("/v1/priors/dune").await;
    assert_eq!((shown.json(), &shown.headers["etag"]), (put.json(), &put.headers["etag"]));
    let shown = shown.json();
    assert_eq!((&shown["forward"]["mu"], &shown["note"]), (&json!(-0.2), &json!("sand")));
    assert_eq!((&shown["source"], &shown["robots"]), (&json!({"kind": "put"}), &json!([])));
    let default = api.get("/v1/priors/default").await.json();
    assert_eq!(shown["turn"], default["turn"], "what is left out is the weak default");
    let all = api.get("/v1/priors").await.json();
    assert_eq!(
        (names(&all), &all["next_page_token"]),
        (vec!["default", "dune", "empirical", "flat", "thesis", "thesis-20"], &Value::Null)
    );
    let page = api.get("/v1/priors?page_size=3").await.json();
    let token = page["next_page_token"].as_str().unwrap();
    let rest = api.get(&format!("/v1/priors?page_size=3&page_token={token}")).await.json();
    assert_eq!(
        (names(&page), names(&rest)),
        (vec!["default", "dune", "empirical"], vec!["flat", "thesis", "thesis-20"])
    );

    let stale = [JSON, ("if-match", "\"0000000000000000\"")];
    let refused = api.call("PUT", "/v1/priors/dune", &stale, dune().to_string()).await;
    assert_eq!(refused.problem(), pair("ABORTED", "ETAG_MISMATCH"));
    assert_eq!(api.put("/v1/priors/dune", json!({"note": "mud"})).await.code, 200);
    let restarted = Api::with(config(), store).await;
    assert_eq!(restarted.get("/v1/priors/dune").await.json()["note"], "mud");
    assert_eq!(restarted.delete("/v1/priors/dune").await.code, 204);
    for answer in
        [restarted.get("/v1/priors/dune").await, restarted.delete("/v1/priors/dune").await]
    {
        assert_eq!(answer.problem(), pair("NOT_FOUND", "NO_SUCH_RESOURCE"));
    }
}

#[tokio::test]
async fn what_is_wrong_with_a_prior_is_said_at_once() {
    let api = Api::new().await;
    let refused = api
        .put(
            "/v1/priors/dune",
            json!({"forward": {"mu": 11, "k": 0, "r": -1, "s": 0}, "note": "x".repeat(1001), "colour": 1}),
        )
        .await;
    let fields = refused.fields();
    assert_eq!(refused.code, 400);
    for field in ["forward.mu", "forward.k", "forward.r", "forward.s", "note", "colour"] {
        assert!(fields.iter().any(|it| it == field), "{field} is not in {fields:?}");
    }
    assert_eq!(
        api.put("/v1/priors/_dune", dune()).await.problem(),
        pair("INVALID_ARGUMENT", "INVALID_ID")
    );
    for built_in in ["default", "empirical", "flat", "thesis", "thesis-20"] {
        let path = format!("/v1/priors/{built_in}");
        assert_eq!(api.put(&path, dune()).await.problem(), pair("FAILED_PRECONDITION", "BUILT_IN"));
        assert_eq!(api.delete(&path).await.problem(), pair("FAILED_PRECONDITION", "BUILT_IN"));
        assert_eq!(api.get(&path).await.json()["source"], json!({"kind": "built-in"}));
    }
}

#[tokio::test]
async fn a_robot_goes_by_the_name_and_says_why() {
    let store = Arc::new(MemoryStore::default());
    let api = Api::with(config(), store.clone()).await;
    let unknown = api.put("/v1/robots/r", json!({"prior": "dune", "horizon_slots": 0})).await;
    assert_eq!(
        (unknown.code, unknown.fields()),
        (400, vec!["horizon_slots".into(), "prior".into()])
    );
    assert!(unknown.json()["error"]["details"][1]["remedy"].as_str().unwrap().contains("thesis"));
    assert_eq!(api.get("/v1/robots/r").await.code, 404);
    api.put("/v1/priors/dune", dune()).await;
    let own = json!({"forward": {"mu": 0.1, "k": 1.0, "r": 4.0, "s": 0.1}});
    for (prior, name, kind) in [
        (json!("dune"), json!("dune"), "put"),
        (json!("flat"), json!("flat"), "built-in"),
        (own, Value::Null, "inline"),
        (json!("dune"), json!("dune"), "put"),
    ] {
        // Of adaptive it is one of many priors.
        let body = json!({"prior": prior, "method": "bayesian"});
        assert!(api.put("/v1/robots/r", body).await.code < 300);
        let used = api.get("/v1/robots/r/environment").await.json()["prior"].clone();
        assert_eq!((&used["name"], &used["source"]["kind"]), (&name, &json!(kind)), "{used}");
        assert!(!used["why"].as_str().unwrap().is_empty());
    }
    // It means what it is made of: the identified environment begins there.
    let environment = api.get("/v1/robots/r/environment").await.json();
    assert_eq!(environment["channels"]["forward"]["mean"], -0.2);
    assert_eq!(api.get("/v1/robots/r").await.json()["spec"]["prior"], "dune");
    let restarted = Api::with(config(), store).await;
    assert_eq!(restarted.get("/v1/robots/r/environment").await.json(), environment);
}

#[tokio::test]
async fn a_prior_in_use_neither_changes_nor_goes() {
    let api = Api::new().await;
    api.put("/v1/priors/dune", dune()).await;
    for robot in 0..102 {
        let path = format!("/v1/robots/r{robot:03}");
        assert_eq!(api.put(&path, json!({"prior": "dune"})).await.code, 201);
    }
    let other = json!({"forward": {"mu": 0.2, "k": 5.0, "r": 8.0, "s": 0.1}});
    for refused in [api.delete("/v1/priors/dune").await, api.put("/v1/priors/dune", other).await] {
        assert_eq!(
            (refused.code, refused.problem()),
            (409, pair("FAILED_PRECONDITION", "PRIOR_IN_USE"))
        );
        let error = &refused.json()["error"];
        let robots: Vec<_> =
            error["details"].as_array().unwrap().iter().map(|it| &it["value"]).collect();
        assert_eq!((robots.len(), robots[0], robots[99]), (100, &json!("r000"), &json!("r099")));
        let message = error["message"].as_str().unwrap();
        assert!(message.contains("102 robots") && message.contains("2 more"), "{message}");
    }
    let shown = api.get("/v1/priors/dune").await.json();
    assert_eq!(
        (shown["robots"].as_array().unwrap().len(), &shown["robot_count"]),
        (100, &json!(102))
    );
    let mut noted = dune();
    noted["note"] = "wet sand".into();
    assert_eq!(api.put("/v1/priors/dune", noted).await.code, 200, "the same values");
    for robot in 0..102 {
        let path = format!("/v1/robots/r{robot:03}");
        let gone =
            if robot % 2 == 0 { api.delete(&path).await } else { api.put(&path, json!({})).await };
        assert!(gone.code < 300);
    }
    assert_eq!(api.delete("/v1/priors/dune").await.code, 204);
}

/// Guards against: a robot whose prior goes at the very moment it is given.
#[tokio::test]
async fn a_prior_that_is_being_given_cannot_go() {
    let gate = Arc::new(Gate::default());
    let api = Api::with(config(), gate.clone()).await;
    api.put("/v1/priors/dune", dune()).await;
    let shut = gate.shut();
    let giving = tokio::spawn({
        let api = api.clone();
        async move { api.put("/v1/robots/r", json!({"prior": "dune"})).await }
    });
    gate.reached(1).await;
    // The robot is not there yet, but its prior is spoken for; whoever gave it may even have gone.
    giving.abort();
    let removing = tokio::spawn({
        let api = api.clone();
        async move { api.delete("/v1/priors/dune").await }
    });
    for _ in 0..100 {
        tokio::task::yield_now().await;
    }
    drop(shut);
    assert_eq!(removing.await.unwrap().problem(), pair("FAILED_PRECONDITION", "PRIOR_IN_USE"));
    assert_eq!(api.get("/v1/robots/r").await.json()["spec"]["prior"], "dune");
}
