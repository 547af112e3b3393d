//! Writing only what is still as it was seen.

use crate::api::{Api, JSON};
use crate::stores::Gate;
use serde_json::json;
use std::sync::Arc;

const ROBOT: &str = "/v1/robots/r";
const TASK: &str = "/v1/robots/r/task";
const MISMATCH: (&str, &str) = ("ABORTED", "ETAG_MISMATCH");

fn pair((status, reason): (&str, &str)) -> (String, String) {
    (status.to_owned(), reason.to_owned())
}

#[tokio::test(start_paused = true)]
async fn a_robot_is_only_written_over_as_it_was_seen() {
    let api = Api::new().await;
    let first = api.put(ROBOT, json!({"horizon_slots": 1})).await.headers["etag"].clone();
    let first = first.to_str().unwrap();
    let put = async |etag: &str, body: &str| {
        api.call("PUT", ROBOT, &[JSON, ("if-match", etag)], body.to_owned()).await
    };
    let second = put(first, r#"{"horizon_slots": 2}"#).await;
    assert_eq!(second.code, 200);
    let lost_update = put(first, r#"{"horizon_slots": 3}"#).await;
    assert_eq!(lost_update.code, 412);
    assert_eq!(lost_update.problem(), pair(MISMATCH));
    assert_eq!(api.get(ROBOT).await.json()["spec"]["horizon_slots"], 2);
    // The etag of the body, without quotes, is as good.
    let bare = second.json()["etag"].as_str().unwrap().to_owned();
    assert_eq!(put(&bare, "{}").await.code, 200);

    let stale = api.call("DELETE", ROBOT, &[("if-match", first)], "").await;
    assert_eq!(stale.problem(), pair(MISMATCH));
    assert_eq!(api.call("DELETE", ROBOT, &[("if-match", "*")], "").await.code, 204);
    assert_eq!(put("*", "{}").await.problem(), pair(MISMATCH), "there is none any more");
}

#[tokio::test(start_paused = true)]
async fn a_task_has_its_own_version() {
    let api = Api::with_robot().await;
    let of_robot = api.get(ROBOT).await.headers["etag"].clone();
    let of_task = api.get(TASK).await.headers["etag"].clone();
    let (of_robot, of_task) = (of_robot.to_str().unwrap(), of_task.to_str().unwrap());
    let body = r#"{"waypoints": [{"x_m": 0.1, "y_m": 0.0}]}"#;
    let wrong = api.call("PUT", TASK, &[JSON, ("if-match", of_robot)], body).await;
    assert_eq!(wrong.problem(), pair(MISMATCH));
    assert_eq!(api.call("PUT", TASK, &[JSON, ("if-match", of_task)], body).await.code, 200);
    let stale = api.call("DELETE", TASK, &[("if-match", of_task)], "").await;
    assert_eq!(stale.problem(), pair(MISMATCH));
    let exists = api.call("PUT", TASK, &[JSON, ("if-none-match", "*")], body).await;
    assert_eq!((exists.code, exists.problem().0.as_str()), (412, "ALREADY_EXISTS"));
}

/// Guards against: between looking and writing someone else has written. The gate holds both writers there.
#[tokio::test]
async fn of_two_who_create_the_same_robot_one_is_told_that_it_exists() {
    let gate = Arc::new(Gate::default());
    let api = Api::with(crate::api::config(), gate.clone()).await;
    let shut = gate.shut();
    let create = |api: Api| async move {
        api.call("PUT", ROBOT, &[JSON, ("if-none-match", "*")], "{}").await.code
    };
    let first = tokio::spawn(create(api.clone()));
    let second = tokio::spawn(create(api.clone()));
    gate.reached(1).await;
    drop(shut);
    let mut codes = [first.await.unwrap(), second.await.unwrap()];
    codes.sort_unstable();
    assert_eq!(codes, [201, 412]);
}
