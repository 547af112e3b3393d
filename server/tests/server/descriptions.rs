//! What is said of a robot: in parts, once for server and agent, and what follows from it.

use crate::api::{Api, JSON, config, step};
use serde_json::{Value, json};
use std::sync::Arc;
use umwelt_server::store::MemoryStore;

const PATH: &str = "/v1/robots/r";
const MERGE: (&str, &str) = ("content-type", "application/merge-patch+json");

async fn patch(api: &Api, body: Value) -> crate::api::Answer {
    api.call("PATCH", PATH, &[MERGE], body.to_string()).await
}

fn number(robot: &Value, pointer: &str) -> f64 {
    robot["spec"].pointer(pointer).unwrap().as_f64().unwrap()
}

/// Guards against: whoever chooses another prior for a robot gives it other wheels and limits.
#[tokio::test(start_paused = true)]
async fn a_patch_changes_what_it_names_and_what_follows_from_that() {
    let api = Api::new().await;
    let drive = json!({"wheel_radius_m": 0.021, "track_width_m": 0.09, "max_linear_m_per_s": 0.26});
    let before = api.put(PATH, json!({"drive": drive, "method": "statistic"})).await.json();
    assert_eq!(number(&before, "/steering/alpha_m_per_s"), 0.4);
    let changed = patch(&api, json!({"prior": "flat", "method": null})).await;
    assert_eq!(changed.code, 200);
    let changed = changed.json();
    assert_eq!(changed["described"], json!({"drive": drive, "prior": "flat"}));
    assert_eq!(changed["spec"]["method"], "adaptive");
    assert_eq!(changed["spec"]["drive"], before["spec"]["drive"]);
    assert_ne!(changed["etag"], before["etag"]);
    let slower = patch(&api, json!({"drive": {"max_linear_m_per_s": 0.13}})).await.json();
    assert_eq!(number(&slower, "/steering/alpha_m_per_s"), 0.2);
    assert_eq!(number(&slower, "/drive/wheel_radius_m"), 0.021);
    let set = patch(&api, json!({"steering": {"alpha_m_per_s": 0.3}})).await.json();
    let set = (set, patch(&api, json!({"drive": {"max_linear_m_per_s": 0.2}})).await.json());
    assert_eq!(number(&set.0, "/steering/alpha_m_per_s"), 0.3);
    assert_eq!(number(&set.1, "/steering/alpha_m_per_s"), 0.3, "what was said stays");
}

#[tokio::test(start_paused = true)]
async fn a_patch_that_is_wrong_or_comes_too_late_changes_nothing() {
    let api = Api::new().await;
    let before = api.put(PATH, json!({"horizon_slots": 5})).await.json();
    for (body, field) in [
        (json!({"drive": {"lag": 1}}), "drive.lag"),
        (json!({"drive": {"min_linear_m_per_s": 1.0}}), "drive.min_linear_m_per_s"),
        (json!({"prior": "nobody"}), "prior"),
        (json!({"horizon_slots": 68}), "horizon_slots"),
        (json!({"drive": [1]}), "drive"),
    ] {
        let refused = patch(&api, body.clone()).await;
        assert!(matches!(refused.code, 400 | 409), "{body}: {refused:?}");
        assert!(refused.fields().iter().any(|it| it == field), "{body}: {refused:?}");
    }
    for (headers, body, code) in [
        (&[MERGE, ("if-match", "\"other\"")][..], "{}", 412),
        (&[MERGE], "[]", 400),
        (&[MERGE], "", 400),
        (&[("content-type", "text/plain")], "{}", 415),
        (&[], "{}", 415),
    ] {
        let refused = api.call("PATCH", PATH, headers, body).await;
        assert_eq!(refused.code, code, "{headers:?} {body}");
    }
    assert_eq!(api.get(PATH).await.json(), before);
    assert_eq!(api.call("PATCH", "/v1/robots/nobody", &[JSON], "{}").await.code, 404);
    let etag = before["etag"].as_str().unwrap();
    let headers = [JSON, ("if-match", etag)];
    let changed = api.call("PATCH", PATH, &headers, r#"{"drift": true}"#).await;
    assert_eq!((changed.code, &changed.json()["spec"]["drift"]), (200, &json!(true)));
}

/// Guards against: two people change different parts of a robot at once, and one of them is undone.
#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn patches_of_different_parts_at_once_are_all_made() {
    let api = Arc::new(Api::new().await);
    api.put(PATH, json!({})).await;
    let parts = [
        ("drive", json!({"lag_s": 0.1})),
        ("noise", json!({"position_m": 0.002})),
        ("steering", json!({"alpha_m_per_s": 0.3})),
        ("drift", json!(true)),
        ("loop_delay_s", json!(0.3)),
        ("watchdog_s", json!(0.5)),
    ];
    let all = parts.clone().map(|(field, value)| {
        let api = Arc::clone(&api);
        tokio::spawn(async move { patch(&api, json!({ field: value })).await.code })
    });
    for made in all {
        assert_eq!(made.await.unwrap(), 200);
    }
    let described = api.get(PATH).await.json()["described"].clone();
    assert_eq!(
        described,
        Value::Object(parts.map(|(field, it)| (field.to_owned(), it)).into_iter().collect())
    );
}

/// Guards against: a robot that moves by other wheels than the server plans for, and the floor is blamed.
#[tokio::test(start_paused = true)]
async fn a_robot_gets_its_drive_where_it_asks_and_has_another() {
    let api = Api::new().await;
    api.put(PATH, json!({"drive": {"wheel_radius_m": 0.021}})).await;
    let ask = |sequence: u64, tag: Value| {
        let mut body = step(7, sequence, sequence as f64, 0.0);
        body["drive_tag"] = tag;
        body
    };
    assert_eq!(api.step(step(7, 1, 1.0, 0.0)).await.json().get("drive"), None, "it does not ask");
    let given = api.step(ask(2, json!(0))).await.json()["drive"].clone();
    assert_eq!(given["drive"], api.get(PATH).await.json()["spec"]["drive"]);
    let tag = given["tag"].clone();
    assert_eq!(api.step(ask(3, tag.clone())).await.json().get("drive"), None, "it has it");
    patch(&api, json!({"drive": {"lag_s": 0.1}})).await;
    let other = api.step(ask(4, tag.clone())).await.json()["drive"].clone();
    assert_eq!(other["drive"]["lag_s"], 0.1);
    assert_ne!(other["tag"], tag);
    // Also where the answer is that of a request that was sent twice.
    assert_eq!(api.step(ask(4, tag)).await.json()["drive"], other);
}

#[tokio::test]
async fn what_was_said_is_kept() {
    let store = Arc::new(MemoryStore::default());
    let said = json!({"drive": {"wheel_radius_m": 0.033}, "prior": "flat"});
    let serve = || Api::with(config(), store.clone());
    let before = {
        let api = serve().await;
        api.put(PATH, said.clone()).await;
        api.get(PATH).await.json()
    };
    let after = serve().await.get(PATH).await.json();
    assert_eq!((&after["described"], &after["spec"]), (&said, &before["spec"]));
    assert_eq!(after["etag"], before["etag"]);
}

/// Guards against: a robot that is to meet a point more exactly than its tracker sees it, and hunts for ever.
#[tokio::test(start_paused = true)]
async fn a_task_without_a_tolerance_has_that_of_the_robot() {
    let api = Api::new().await;
    api.put(PATH, json!({"noise": {"position_m": 0.01}})).await;
    let task = |tolerance: Value| json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}], "tolerance_m": tolerance});
    let path = format!("{PATH}/task");
    let set = api.put(&path, task(Value::Null)).await.json();
    assert_eq!(set["spec"]["tolerance_m"], 0.025);
    let set = api.put(&path, task(json!(0.03))).await.json();
    assert_eq!(set["spec"]["tolerance_m"], 0.03);
}
