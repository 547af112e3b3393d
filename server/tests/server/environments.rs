//! Simulated environments by name.

use crate::api::{Api, config};
use crate::evolutions::small;
use crate::jobs::{Follower, serve};
use serde_json::{Value, json};
use std::sync::Arc;
use umwelt_server::store::MemoryStore;

fn pair(status: &str, reason: &str) -> (String, String) {
    (status.to_owned(), reason.to_owned())
}

fn names(page: &Value) -> Vec<&str> {
    let environments = page["environments"].as_array().unwrap().iter();
    environments.map(|it| it["environment"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn an_environment_is_put_shown_listed_and_removed() {
    let store = Arc::new(MemoryStore::default());
    let api = Api::with(config(), store.clone()).await;
    let hall = json!({"slip": "oily", "link": "bad", "fitness": "bad", "weight": 2.0, "note": "after rain"});
    let put = api.put("/v1/environments/hall", hall).await;
    assert_eq!(
        (put.code, &put.json()["slip"], &put.json()["built_in"]),
        (201, &json!("oily"), &json!(false))
    );
    let shown = api.get("/v1/environments/hall").await;
    assert_eq!((shown.json(), &shown.headers["etag"]), (put.json(), &put.headers["etag"]));
    let page = api.get("/v1/environments?page_size=4").await.json();
    assert_eq!(names(&page), ["bad-link", "bursty-link", "hall", "loaded"]);
    let token = page["next_page_token"].as_str().unwrap();
    let rest = api.get(&format!("/v1/environments?page_token={token}")).await.json();
    assert_eq!(names(&rest), ["normal", "slippery", "towing"]);
    for item in rest["environments"].as_array().unwrap() {
        assert_eq!(item["built_in"], true);
        let path = format!("/v1/environments/{}", item["environment"].as_str().unwrap());
        assert_eq!(&api.get(&path).await.json(), item);
        assert_eq!(api.delete(&path).await.problem(), pair("FAILED_PRECONDITION", "BUILT_IN"));
        let put = api.put(&path, json!({"slip": "oily", "link": "bad"})).await;
        assert_eq!(put.problem(), pair("FAILED_PRECONDITION", "BUILT_IN"));
    }
    let restarted = Api::with(config(), store).await;
    assert_eq!(restarted.get("/v1/environments/hall").await.json(), put.json());
    assert_eq!(restarted.delete("/v1/environments/hall").await.code, 204);
    for answer in [
        restarted.get("/v1/environments/hall").await,
        restarted.delete("/v1/environments/hall").await,
    ] {
        assert_eq!(answer.problem(), pair("NOT_FOUND", "NO_SUCH_RESOURCE"));
    }
}

#[tokio::test]
async fn what_is_wrong_with_an_environment_is_said_at_once() {
    let api = Api::new().await;
    let refused = api
        .put(
            "/v1/environments/hall",
            json!({"slip": "lava", "link": "none", "weight": 0, "colour": 1}),
        )
        .await;
    let mut fields = refused.fields();
    fields.sort_unstable();
    assert_eq!(
        (refused.code, fields),
        (400, ["colour", "link", "slip", "weight"].map(str::to_owned).to_vec())
    );
    assert_eq!(api.put("/v1/environments/hall", json!({"slip": "oily"})).await.code, 400);
    assert_eq!(
        api.get("/v1/environments?page_size=101&state=x").await.fields(),
        ["state", "page_size"]
    );
}

/// Guards against: an evolution that is resumed in another environment than it was begun in.
#[tokio::test]
async fn an_evolution_keeps_the_environment_that_it_was_submitted_with() {
    let api = serve(Arc::new(MemoryStore::default())).await;
    let hall = |slip: &str| json!({"slip": slip, "link": "normal"});
    let mut body = small();
    body["environments"] = json!(["hall"]);
    let unknown = api.submit(&body).await;
    assert_eq!(unknown.problem(), pair("INVALID_ARGUMENT", "UNKNOWN_ENVIRONMENT"));
    let mut champions = Vec::new();
    for slip in ["oily", "hard"] {
        api.put("/v1/environments/hall", hall(slip)).await;
        let path = api.begin(&body).await;
        // Changed or gone at once: the evolution has its own.
        api.put("/v1/environments/hall", hall("towing")).await;
        assert_eq!(api.delete("/v1/environments/hall").await.code, 204);
        let mut follower = Follower::open(&api, &path, None).await;
        follower.until(|event| event["state"] == "succeeded").await;
        champions.push(api.get(&path).await.json()["champion"].clone());
    }
    let hard = api.begin(&small()).await;
    Follower::open(&api, &hard, None).await.until(|event| event["state"] == "succeeded").await;
    let normal = api.get(&hard).await.json()["champion"].clone();
    let fitness = |champion: &Value| -> Vec<Value> {
        let entries = champion["entries"].as_array().unwrap().iter();
        entries.map(|entry| entry["fitness"].clone()).collect()
    };
    assert_eq!(fitness(&champions[1]), fitness(&normal), "the normal one by another name");
    assert_ne!(fitness(&champions[0]), fitness(&normal));
}
