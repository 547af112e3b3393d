//! Describing, listing and removing robots and their tasks; deadlines; what the server says of itself.

use crate::api::{Api, JSON, config, step};
use crate::stores::Gate;
use axum::body::Body;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use umwelt_server::Config;
use umwelt_server::store::MemoryStore;

#[tokio::test(start_paused = true)]
async fn a_robot_is_created_replaced_shown_and_removed() {
    let api = Api::new().await;
    let created = api.put("/v1/robots/r", json!({"horizon_slots": 5})).await;
    assert_eq!(created.code, 201);
    let robot = created.json();
    assert_eq!(robot["spec"]["horizon_slots"], 5);
    assert_eq!(robot["spec"]["method"], "adaptive", "defaults are filled in");
    assert_eq!(robot["state"], "never");
    assert_eq!(robot["last_seen_s_ago"], Value::Null);
    assert_eq!(created.headers["etag"], format!("\"{}\"", robot["etag"].as_str().unwrap()));
    assert_eq!(api.get("/v1/robots/r").await.json(), robot);

    let task = json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}]});
    assert_eq!(api.put("/v1/robots/r/task", task.clone()).await.code, 201);
    let replaced = api.put("/v1/robots/r", json!({"horizon_slots": 9})).await;
    assert_eq!(replaced.code, 200);
    assert_ne!(replaced.json()["etag"], robot["etag"]);
    assert_eq!(replaced.json()["task"]["legs"], 1, "the task is kept");

    assert_eq!(api.delete("/v1/robots/r").await.code, 204);
    assert_eq!(api.get("/v1/robots/r").await.code, 404);
    assert_eq!(api.delete("/v1/robots/r").await.code, 404);
    assert_eq!(api.put("/v1/robots/r/task", task).await.code, 404);
}

#[tokio::test(start_paused = true)]
async fn a_task_is_set_replaced_shown_and_cancelled() {
    let api = Api::new().await;
    api.put("/v1/robots/r", json!({})).await;
    assert_eq!(api.get("/v1/robots/r/task").await.problem().0, "NOT_FOUND");
    assert_eq!(api.delete("/v1/robots/r/task").await.problem().0, "NOT_FOUND");
    let spec = json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}, {"x_m": 0.0, "y_m": 0.0}]});
    let set = api.put("/v1/robots/r/task", spec.clone()).await;
    assert_eq!(set.code, 201);
    let shown = api.get("/v1/robots/r/task").await;
    assert_eq!(shown.json(), set.json());
    assert_eq!(shown.json()["progress"]["legs"], 2);
    assert_eq!(shown.json()["spec"]["waypoints"], spec["waypoints"]);
    let etag = shown.json()["etag"].as_str().unwrap().to_owned();
    assert_eq!(shown.headers["etag"], format!("\"{etag}\""));
    let other = json!({"waypoints": [{"x_m": 0.1, "y_m": 0.0}]});
    assert_eq!(api.put("/v1/robots/r/task", other).await.code, 200);
    assert_eq!(api.delete("/v1/robots/r/task").await.code, 204);
    assert_eq!(api.get("/v1/robots/r/task").await.code, 404);
    assert_eq!(api.get("/v1/robots/r").await.json()["task"], Value::Null);
}

/// Guards against: a PUT that is sent again, because its answer was lost, sends the robot back to its first waypoint.
#[tokio::test(start_paused = true)]
async fn the_very_task_that_is_under_way_goes_on() {
    let api = Api::with_robot().await;
    let task = "/v1/robots/r/task";
    let spec = json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}]});
    let mut now = 10.0;
    let mut drive = async |x: f64| {
        for _ in 0..10 {
            now += 0.1;
            api.step(step(7, (10.0 * now) as u64, now, x)).await;
        }
        api.state().await
    };
    let under_way = drive(0.05).await;
    assert!(under_way[1]["progress"]["elapsed_s"].as_f64() > Some(0.5), "{under_way:?}");
    // The same said in full, with a zero of another sign, is the same.
    let in_full =
        json!({"waypoints": [{"x_m": 0.2, "y_m": -0.0}], "reverse": false, "calibration": null});
    for spec in [spec.clone(), in_full] {
        let again = api.put(task, spec).await;
        assert_eq!((again.code, again.json()), (200, under_way[1].clone()));
        assert_eq!(again.headers["etag"], format!("{}", under_way[1]["etag"]));
        assert_eq!(api.state().await, under_way);
    }
    let etag = under_way[1]["etag"].as_str().unwrap();
    for (header, code) in [("if-match", 200), ("if-none-match", 412)] {
        let value = if code == 200 { etag } else { "*" };
        let again = api.call("PUT", task, &[JSON, (header, value)], spec.to_string()).await;
        assert_eq!(again.code, code, "{header}");
    }
    let stale = api.call("PUT", task, &[JSON, ("if-match", "0")], spec.to_string()).await;
    assert_eq!(stale.problem().1, "ETAG_MISMATCH");
    assert_eq!(api.state().await, under_way);

    // Its drive may go on for a while: it is to be seen at rest for as long.
    drive(0.2).await;
    let arrived = drive(0.2).await;
    assert_eq!(arrived[1]["progress"]["stage"], "arrived");
    assert_eq!(api.put(task, spec.clone()).await.json(), arrived[1], "it is done, and stays done");
    // Who wants to see it driven again says so.
    assert_eq!(api.delete(task).await.code, 204);
    assert_eq!(api.put(task, spec).await.code, 201);
    assert_eq!(drive(0.0).await[1]["progress"]["leg"], 0);

    let other = json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}], "reverse": true});
    let replaced = api.put(task, other).await;
    assert_eq!((replaced.code, &replaced.json()["progress"]["elapsed_s"]), (200, &json!(0.0)));
}

#[tokio::test(start_paused = true)]
async fn pages_hold_every_robot_once_in_the_order_of_their_ids() {
    let api = Api::new().await;
    let mut ids: Vec<String> = (0..7).map(|i| format!("r-{}", (i * 5) % 7)).collect();
    for id in &ids {
        api.put(&format!("/v1/robots/{id}"), json!({})).await;
    }
    ids.sort();
    for size in [1, 2, 3, 6, 7, 8] {
        let (mut seen, mut token) = (Vec::new(), String::new());
        loop {
            let page = api.get(&format!("/v1/robots?page_size={size}{token}")).await.json();
            let robots = page["robots"].as_array().unwrap().clone();
            assert!(!robots.is_empty() && robots.len() <= size);
            seen.extend(robots.iter().map(|robot| robot["robot"].as_str().unwrap().to_owned()));
            // A robot that is removed between pages must not break the walk.
            let Some(next) = page["next_page_token"].as_str() else { break };
            token = format!("&page_token={next}");
        }
        assert_eq!(seen, ids, "{size} per page");
    }
    assert_eq!(api.get("/v1/robots?state=lost").await.json()["robots"], json!([]));
    assert_eq!(
        api.get("/v1/robots?state=never").await.json()["robots"].as_array().unwrap().len(),
        7
    );
}

#[tokio::test(start_paused = true)]
async fn there_is_a_limit_to_the_number_of_robots() {
    let config = Config { max_robots: 2, ..config() };
    let api = Api::with(config, Arc::new(MemoryStore::default())).await;
    assert_eq!(api.put("/v1/robots/a", json!({})).await.code, 201);
    assert_eq!(api.put("/v1/robots/b", json!({})).await.code, 201);
    let third = api.put("/v1/robots/c", json!({})).await;
    assert_eq!(third.code, 429);
    assert_eq!(third.problem(), ("RESOURCE_EXHAUSTED".into(), "LIMIT_REACHED".into()));
    assert_eq!(third.headers["retry-after"], "1");
    assert_eq!(api.put("/v1/robots/a", json!({})).await.code, 200, "those there are may change");
    api.delete("/v1/robots/b").await;
    assert_eq!(api.put("/v1/robots/c", json!({})).await.code, 201, "and make room");
}

/// The store hangs; the caller hears in time, and the change still comes to its end.
#[tokio::test]
async fn a_deadline_is_kept_and_clamped() {
    let gate = Arc::new(Gate::default());
    let config = Config { max_deadline: Duration::from_millis(30), ..config() };
    let api = Api::with(config, gate.clone()).await;
    let shut = gate.shut();
    for timeout in ["20m", "99999999H"] {
        let headers = [crate::api::JSON, ("grpc-timeout", timeout)];
        let answer = api.call("PUT", "/v1/robots/r", &headers, Body::from("{}"));
        let answer = tokio::time::timeout(Duration::from_secs(10), answer).await.expect("in time");
        assert_eq!(answer.code, 504);
        assert_eq!(answer.problem().0, "DEADLINE_EXCEEDED");
    }
    drop(shut);
    // Behind the change that the first caller no longer waits for; on a busy machine not within the deadline.
    loop {
        let again = api.put("/v1/robots/r", json!({"horizon_slots": 3})).await;
        assert_ne!(again.code, 201, "what was begun was done");
        if again.code == 200 {
            return;
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_server_says_how_it_is_and_what_it_offers() {
    let api = Api::new().await;
    assert_eq!(api.get("/healthz").await.json()["status"], "ok");
    assert_eq!(api.get("/readyz").await.json()["status"], "ok");
    let contract = api.get("/openapi.json").await;
    assert_eq!(contract.headers["content-type"], "application/json");
    assert_eq!(contract.json(), serde_json::from_str::<Value>(umwelt_api::DOCUMENT).unwrap());
}

/// Guards against: a route of the contract that no one serves, or one with another method.
#[tokio::test(start_paused = true)]
async fn every_route_of_the_contract_is_served() {
    let api = Api::new().await;
    let contract = api.get("/openapi.json").await.json();
    let mut count = 0;
    for (path, operations) in contract["paths"].as_object().unwrap() {
        for method in operations.as_object().unwrap().keys() {
            let path = path.replace("{robot}", "r");
            if path.ends_with("/events") {
                continue; // A stream does not end; its own tests call it.
            }
            let answer = api.call(&method.to_uppercase(), &path, &[], Body::empty()).await;
            let is_missing = answer.code == 405
                || answer.json()["error"]["message"] == "there is nothing at this path";
            assert!(!is_missing, "{method} {path}: {answer:?}");
            count += 1;
        }
    }
    assert!(count >= 16, "{count}");
}
