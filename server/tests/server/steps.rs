//! The exchange with a robot's agent. Time stands still but where a test moves it.

use crate::api::{Api, JSON, step};
use futures_util::future::join_all;
use serde_json::{Value, json};
use std::time::Duration;

fn samples(environment: &Value) -> u64 {
    environment["link"]["samples"].as_u64().unwrap()
}

fn with_delivery(mut step: Value, of: u64) -> Value {
    step["deliveries"] = json!([{"sequence": of, "loop_delay_s": 0.2}]);
    step
}

#[tokio::test(start_paused = true)]
async fn a_step_is_answered_with_a_horizon_and_shows() {
    let api = Api::with_robot().await;
    let answer = api.step(step(7, 1, 10.0, 0.0)).await;
    assert_eq!(answer.code, 200, "{answer:?}");
    let reply: umwelt_api::step::Reply = serde_json::from_slice(&answer.bytes).unwrap();
    assert_eq!((reply.horizon.sequence, reply.horizon.answers), (1, 1));
    assert!(reply.horizon.start_s > 10.0);
    assert!(reply.horizon.to_core().is_ok());
    let robot = api.get("/v1/robots/r").await.json();
    assert_eq!(robot["state"], "connected");
    assert_eq!(robot["last_seen_s_ago"], 0.0);
    assert_eq!(robot["epoch"], 7);
    assert_eq!(robot["pose"]["taken_s"], 9.9);
}

#[tokio::test(start_paused = true)]
async fn a_robot_that_holds_is_told_to_rest_and_shows_at_once() {
    let api = Api::with_robot().await;
    let path = "/v1/robots/r/task";
    let task = json!({"waypoints": [{"x_m": 1.0, "y_m": 0.0}], "calibration": null});
    assert_eq!(api.put(path, task).await.code, 200);
    let moves = async |sequence: u64, more: Value| {
        let mut body = step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0);
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let answer = api.step(body).await;
        let reply: umwelt_api::step::Reply = serde_json::from_slice(&answer.bytes).unwrap();
        let robot = api.get("/v1/robots/r").await.json();
        let speeds = reply.horizon.wheel_speeds;
        let moves = speeds.iter().any(|wheels| wheels.left_rad_per_s != 0.0);
        (moves, robot["held"].clone(), robot["max_speed_m_per_s"].clone())
    };
    let (none, slow) = (json!({}), json!({"max_speed_m_per_s": 0.05}));
    for sequence in 1..30 {
        moves(sequence, none.clone()).await;
    }
    assert_eq!(moves(30, none.clone()).await, (true, json!(false), Value::Null));
    let held = json!({"hold": true});
    moves(31, held.clone()).await;
    for sequence in 32..60 {
        assert_eq!(moves(sequence, held.clone()).await.1, true);
    }
    assert_eq!(moves(60, held).await, (false, json!(true), Value::Null));
    assert_eq!(moves(61, slow).await, (true, json!(false), json!(0.05)));
    let too_slow = json!({"max_speed_m_per_s": 0.01});
    assert_eq!(moves(62, too_slow).await.1, true);
    assert_eq!(moves(63, none).await.1, false);
}

/// Guards against: a retry of the transport counts its deliveries twice, or plans anew from the same pose.
#[tokio::test(start_paused = true)]
async fn a_repeat_gets_the_same_bytes_and_changes_nothing() {
    let api = Api::with_robot().await;
    let mut first = Vec::new();
    for sequence in 1..=8 {
        let sent = 10.0 + 0.03 * sequence as f64;
        let step = with_delivery(step(7, sequence, sent, 0.0), sequence - 1);
        first.push((step.clone(), api.step(step).await));
    }
    let before = api.state().await;
    for (step, answer) in first {
        assert_eq!(api.step(step).await.bytes, answer.bytes);
    }
    assert_eq!(api.state().await, before);
}

#[tokio::test(start_paused = true)]
async fn a_late_one_gets_the_newest_horizon_and_teaches_the_link_and_nothing_else() {
    let api = Api::with_robot().await;
    api.step(step(7, 1, 10.0, 0.0)).await;
    let newest = api.step(step(7, 10, 10.3, 0.01)).await.json();
    let [robot, task, environment] = api.state().await;

    let late = api.step(with_delivery(step(7, 5, 10.15, 0.5), 1)).await;
    assert_eq!(late.code, 200);
    let mut expected = newest.clone();
    expected["horizon"]["answers"] = 5.into();
    assert_eq!(late.json(), expected);

    let [robot_then, task_then, environment_then] = api.state().await;
    assert_eq!(robot_then["pose"], robot["pose"]);
    assert_eq!(task_then, task);
    assert_eq!(samples(&environment_then), samples(&environment) + 1);
    // Once: the late one's repeat is a repeat.
    assert_eq!(api.step(with_delivery(step(7, 5, 10.15, 0.5), 1)).await.bytes, late.bytes);
    assert_eq!(samples(&api.state().await[2]), samples(&environment_then));
}

/// Guards against: an overtaken request gets a horizon with a higher number and the robot plays it.
#[tokio::test(start_paused = true)]
async fn however_steps_are_reordered_the_newest_horizon_wins() {
    let api = Api::with_robot().await;
    let mut newest = 0;
    // 1..=60 in an order that overtakes by up to 16, each some time once.
    for index in 0..60_u64 {
        let sequence = 1 + (index / 17) * 17 + (index * 5) % 17;
        let reply = api.step(step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0)).await.json();
        newest = newest.max(sequence);
        assert_eq!(reply["horizon"]["sequence"], newest, "{reply}");
        assert_eq!(reply["horizon"]["answers"], sequence);
    }
}

#[tokio::test(start_paused = true)]
async fn a_new_epoch_takes_over_with_the_task_and_what_was_learned() {
    let api = Api::with_robot().await;
    api.step(step(7, 1000, 5000.0, 0.1)).await;
    api.step(with_delivery(step(7, 1001, 5000.03, 0.1), 1000)).await;
    // The robot restarted: its clock and its sequences begin again.
    let answer = api.step(step(8, 1, 0.5, 0.1)).await;
    assert_eq!(answer.code, 200);
    assert_eq!(answer.json()["horizon"]["sequence"], 1);
    assert!(answer.json()["horizon"]["start_s"].as_f64().unwrap() < 1.0);
    let [robot, task, environment] = api.state().await;
    assert_eq!(robot["epoch"], 8);
    assert_eq!(robot["pose"]["taken_s"], 0.4);
    assert_eq!(task["progress"]["legs"], 1);
    assert_eq!(samples(&environment), 1);
    // One that has seen nothing yet does not take the last known pose off the list.
    api.step(json!({"epoch": 9, "sequence": 1, "sent_s": 0.1})).await;
    assert_eq!(api.state().await[0]["pose"], robot["pose"]);
}

#[tokio::test(start_paused = true)]
async fn a_second_agent_takes_over_and_the_first_is_refused_for_good() {
    let api = Api::with_robot().await;
    api.step(step(7, 1, 10.0, 0.0)).await;
    api.step(step(8, 1, 20.0, 0.0)).await;
    let before = api.state().await;
    for sequence in 1..5 {
        let refused = api.step(step(7, sequence, 10.0 + sequence as f64, 0.3)).await;
        assert_eq!(refused.code, 409);
        assert_eq!(refused.problem(), ("ABORTED".into(), "EPOCH_SUPERSEDED".into()));
        assert_eq!(refused.fields(), ["epoch"]);
    }
    assert_eq!(api.state().await, before);
    assert_eq!(api.step(step(8, 2, 20.03, 0.0)).await.code, 200);
}

#[tokio::test(start_paused = true)]
async fn a_clock_that_runs_backwards_needs_a_new_epoch() {
    let api = Api::with_robot().await;
    api.step(step(7, 1, 100.0, 0.0)).await;
    let before = api.state().await;
    let refused = api.step(step(7, 2, 0.5, 0.3)).await;
    assert_eq!(refused.code, 409);
    assert_eq!(refused.problem(), ("FAILED_PRECONDITION".into(), "CLOCK_WENT_BACK".into()));
    assert_eq!(api.state().await, before);
    assert_eq!(api.step(step(7, 2, 100.03, 0.0)).await.code, 200, "the epoch goes on");
    assert_eq!(api.step(step(8, 1, 0.5, 0.0)).await.code, 200, "and a new one may begin");
}

#[tokio::test(start_paused = true)]
async fn a_silent_robot_is_lost_but_stays_with_its_last_pose() {
    let api = Api::with_robot().await;
    assert_eq!(api.get("/v1/robots/r").await.json()["state"], "never");
    api.step(step(7, 1, 10.0, 0.05)).await;
    tokio::time::sleep(Duration::from_millis(1999)).await;
    assert_eq!(api.get("/v1/robots/r").await.json()["state"], "connected");
    tokio::time::sleep(Duration::from_millis(2)).await;
    let robot = api.get("/v1/robots/r").await.json();
    assert_eq!(robot["state"], "lost");
    assert_eq!(robot["pose"]["x_m"], 0.05);
    assert!((robot["last_seen_s_ago"].as_f64().unwrap() - 2.001).abs() < 1e-9);
    let lost = api.get("/v1/robots?state=lost").await.json();
    assert_eq!(lost["robots"][0]["robot"], "r");
    // It comes back without anybody doing anything; a repeat is a sign of life too.
    api.step(step(7, 1, 10.0, 0.05)).await;
    assert_eq!(api.get("/v1/robots/r").await.json()["state"], "connected");
    assert_eq!(api.get("/v1/robots?state=lost").await.json()["robots"], json!([]));
}

/// Guards against: steps pile up behind a busy robot and are answered long after they are of use.
#[tokio::test(start_paused = true)]
async fn a_flood_of_steps_is_refused_rather_than_queued_and_a_stop_gets_through() {
    let api = Api::with_robot().await;
    let flood = (1..=60).map(|sequence| api.step(step(7, sequence, 10.0, 0.0)));
    let (answers, stopped) = tokio::join!(join_all(flood), api.post("/v1/robots/r/stop"));
    let (fine, refused): (Vec<_>, Vec<_>) = answers.iter().partition(|answer| answer.code == 200);
    assert_eq!(fine.len(), 16, "as many as the queue holds");
    for answer in refused {
        assert_eq!(answer.code, 429);
        assert_eq!(answer.problem(), ("RESOURCE_EXHAUSTED".into(), "QUEUE_FULL".into()));
        assert_eq!(answer.headers["retry-after"], "1");
    }
    assert_eq!(stopped.code, 200);
    assert_eq!(api.step(step(7, 100, 10.1, 0.0)).await.json()["stopped"], true);
}

#[tokio::test(start_paused = true)]
async fn a_stopped_robot_gets_a_horizon_that_ends_at_rest_until_it_is_resumed() {
    let api = Api::with_robot().await;
    api.add("s").await;
    for sequence in 1..=20 {
        api.step(step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0)).await;
    }
    assert_eq!(
        api.post("/v1/stop").await.json(),
        json!({"robots": 2, "stopped": true, "kept": true})
    );
    let reply = api.step(step(7, 21, 10.63, 0.0)).await.json();
    assert_eq!(reply["stopped"], true);
    let last = reply["horizon"]["wheel_speeds"].as_array().unwrap().last().unwrap().clone();
    assert_eq!(last, json!({"left_rad_per_s": 0.0, "right_rad_per_s": 0.0}));
    let robot = api.get("/v1/robots/r").await.json();
    assert_eq!(robot["stopped"], true);
    assert_eq!(robot["task"]["legs"], 1, "the task is kept");

    let resumed = api.post("/v1/robots/r/resume").await.json();
    assert_eq!(resumed, json!({"robot": "r", "stopped": false, "kept": true}));
    assert_eq!(api.get("/v1/robots/s").await.json()["stopped"], true);
    let moves = |reply: &Value| {
        let speeds = reply["horizon"]["wheel_speeds"].as_array().unwrap().clone();
        speeds.iter().any(|speeds| speeds["left_rad_per_s"] != 0.0)
    };
    assert!(moves(&api.step(step(7, 22, 10.66, 0.0)).await.json()));
    assert_eq!(
        api.post("/v1/resume").await.json(),
        json!({"robots": 2, "stopped": false, "kept": true})
    );
    assert_eq!(api.get("/v1/robots/s").await.json()["stopped"], false);
}

#[tokio::test(start_paused = true)]
async fn without_a_task_the_robot_rests() {
    let api = Api::with_robot().await;
    assert_eq!(api.delete("/v1/robots/r/task").await.code, 204);
    let reply = api.step(step(7, 1, 10.0, 0.0)).await.json();
    assert_eq!(reply["stage"], "idle");
    let speeds = reply["horizon"]["wheel_speeds"].as_array().unwrap();
    assert!(speeds.iter().all(|speeds| speeds["left_rad_per_s"] == 0.0));
}

#[tokio::test(start_paused = true)]
async fn what_was_learned_can_be_forgotten() {
    let api = Api::with_robot().await;
    let prior = api.get("/v1/robots/r/environment").await.json();
    api.step(step(7, 1, 10.0, 0.0)).await;
    api.step(with_delivery(step(7, 2, 10.03, 0.0), 1)).await;
    assert_eq!(samples(&api.get("/v1/robots/r/environment").await.json()), 1);
    assert_eq!(api.post("/v1/robots/r/environment/reset").await.json(), prior);
    assert_eq!(api.get("/v1/robots/r/environment").await.json(), prior);
}

#[tokio::test(start_paused = true)]
async fn steps_of_unknown_and_removed_robots_are_not_answered() {
    let api = Api::with_robot().await;
    let path = "/v1/robots/other/step";
    let unknown = api.call("POST", path, &[JSON], step(7, 1, 10.0, 0.0).to_string()).await;
    assert_eq!(unknown.problem(), ("NOT_FOUND".into(), "NO_SUCH_RESOURCE".into()));
    // The removal and a step behind it in the queue.
    let (removed, behind) =
        tokio::join!(api.delete("/v1/robots/r"), api.step(step(7, 1, 10.0, 0.0)));
    assert_eq!(removed.code, 204);
    assert!(behind.code == 200 || behind.code == 404, "{behind:?}");
    assert_eq!(api.step(step(7, 2, 10.03, 0.0)).await.code, 404);
    // The same id described again is another robot: no task, no session.
    api.put("/v1/robots/r", json!({})).await;
    assert_eq!(api.get("/v1/robots/r/task").await.code, 404);
    assert_eq!(api.get("/v1/robots/r").await.json()["epoch"], Value::Null);
}
