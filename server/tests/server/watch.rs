//! What the watch finds shows, is kept, and holds until a resume. Time stands still but where a test moves it.

use crate::api::{Api, config, step};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use umwelt_server::store::MemoryStore;

/// Robot `r` takes steps `from..to`, 33 a second, and its tracker shows the same pose in all of them.
async fn frozen(api: &Api, from: u64, to: u64) -> Value {
    let mut reply = Value::Null;
    for sequence in from..to {
        reply = api.step(step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0)).await.json();
    }
    reply
}

fn is_rest(reply: &Value) -> bool {
    let speeds = reply["horizon"]["wheel_speeds"].as_array().unwrap();
    speeds.iter().all(|it| it["left_rad_per_s"] == 0.0 && it["right_rad_per_s"] == 0.0)
}

/// Guards against: a robot that drives blind for ever and is shown as driving; one that a restart sets in motion again.
#[tokio::test(start_paused = true)]
async fn a_frozen_tracker_brings_the_robot_to_rest_until_it_is_resumed() {
    let store = Arc::new(MemoryStore::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    assert_eq!(api.get("/v1/robots/r").await.json()["watch"], Value::Null);
    let reply = frozen(&api, 1, 100).await;
    assert!(is_rest(&reply), "{reply}");
    let [robot, task, _] = api.state().await;
    assert_eq!(
        (&robot["watch"]["state"], &robot["watch"]["rests"]),
        (&json!("frozen"), &json!(true))
    );
    assert!(robot["watch"]["seen"].as_str().unwrap().contains("equal poses"), "{robot}");
    assert!(robot["watch"]["remedy"].as_str().unwrap().contains("resume"), "{robot}");
    assert_eq!(task["progress"]["watch"], "frozen");
    assert_eq!(task["progress"]["limited_by"], "watch");
    assert_eq!(robot["stopped"], false, "nobody stopped it");

    tokio::time::sleep(Duration::from_secs(1)).await;
    let restarted = Api::with(config(), store).await;
    let [robot, task, _] = restarted.state().await;
    assert_eq!(
        (&robot["watch"]["state"], &task["progress"]["watch"]),
        (&json!("frozen"), &json!("frozen"))
    );
    assert!(is_rest(&frozen(&restarted, 200, 205).await));
    assert_eq!(restarted.post("/v1/robots/r/resume").await.code, 200);
    assert_eq!(restarted.get("/v1/robots/r").await.json()["watch"], Value::Null);
    assert!(!is_rest(&frozen(&restarted, 205, 215).await), "it goes on");
    assert!(is_rest(&frozen(&restarted, 215, 320).await), "and the tracker is as frozen as before");
    let task = json!({"waypoints": [{"x_m": 0.3, "y_m": 0.0}]});
    assert_eq!(restarted.put("/v1/robots/r/task", task).await.code, 200);
    assert_eq!(restarted.get("/v1/robots/r").await.json()["watch"], Value::Null);
}

#[tokio::test(start_paused = true)]
async fn missing_poses_are_said_and_the_robot_goes_on_by_itself() {
    let api = Api::with_robot().await;
    assert_eq!(api.get("/v1/robots/r").await.json()["pose_age_s"], Value::Null);
    frozen(&api, 1, 11).await;
    let age = |robot: &Value| robot["pose_age_s"].as_f64().unwrap();
    assert!((age(&api.get("/v1/robots/r").await.json()) - 0.1).abs() < 1e-6);
    let mut reply = Value::Null;
    for sequence in 11..80 {
        let sent = 10.0 + 0.03 * sequence as f64;
        reply = api.step(json!({"epoch": 7, "sequence": sequence, "sent_s": sent})).await.json();
        tokio::time::advance(Duration::from_millis(30)).await;
    }
    assert!(is_rest(&reply), "{reply}");
    let robot = api.get("/v1/robots/r").await.json();
    assert_eq!(
        (&robot["watch"]["state"], &robot["watch"]["rests"]),
        (&json!("no-poses"), &json!(true))
    );
    assert!((age(&robot) - 2.17).abs() < 0.02, "{robot}");
    // Without any request it grows on.
    tokio::time::advance(Duration::from_secs(3)).await;
    let later = api.get("/v1/robots/r").await.json();
    assert!((age(&later) - age(&robot) - 3.0).abs() < 0.01, "{later}");

    frozen(&api, 200, 202).await;
    let robot = api.get("/v1/robots/r").await.json();
    assert_eq!(robot["watch"], Value::Null, "{robot}");
    assert!(age(&robot) < 0.11);
}

#[tokio::test(start_paused = true)]
async fn a_task_may_say_how_far_the_robot_may_stray() {
    let api = Api::with_robot().await;
    let task = |deviation: f64| json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}], "max_deviation_m": deviation});
    assert_eq!(api.put("/v1/robots/r/task", task(0.05)).await.code, 200);
    assert_eq!(api.get("/v1/robots/r/task").await.json()["spec"]["max_deviation_m"], 0.05);
    let refused = api.put("/v1/robots/r/task", task(-1.0)).await;
    assert_eq!((refused.code, refused.fields()), (400, vec!["max_deviation_m".to_owned()]));
}
