//! What means nothing is refused in one shape, all of it at once, and changes nothing.

use super::{describe, shown, straight_to};
use serde_json::{Value, json};
use umwelt_api::RobotId;
use umwelt_tests::http::{self, Answer};
use umwelt_tests::rover::request;
use umwelt_tests::server::Server;

/// The values that the error body of the contract may name, with the HTTP status of each.
const STATUSES: [(&str, u16); 6] = [
    ("INVALID_ARGUMENT", 400),
    // Good by every schema, and at odds with itself.
    ("INVALID_ARGUMENT", 409),
    ("FAILED_PRECONDITION", 409),
    ("NOT_FOUND", 404),
    ("ABORTED", 409),
    ("UNIMPLEMENTED", 501),
];

/// The statuses for which HTTP has a better word: too large, other media type, other method.
const BETTER_WORDS: [(&str, u16); 3] =
    [("INVALID_ARGUMENT", 413), ("INVALID_ARGUMENT", 415), ("UNIMPLEMENTED", 405)];

/// A robot that has a task, has been seen, and is known to the server with all it can hold.
async fn driven(server: &Server) -> RobotId {
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(0.3)).await.unwrap();
    let steps = server.client.step_connection();
    for sequence in 1..=3 {
        let sent = 10.0 + sequence as f64 * 0.03;
        steps.step(&robot, &request(4711, sequence, sent)).await.unwrap();
    }
    robot
}

/// Checks the shape of the error body and returns its details as (reason, field).
fn details(answer: &Answer, what: &str) -> Vec<(String, String)> {
    let body = answer.json();
    let error = &body["error"];
    let status = error["status"].as_str().unwrap_or_default();
    let said = (status, answer.code);
    assert!(STATUSES.contains(&said) || BETTER_WORDS.contains(&said), "{what}: {answer:?}");
    assert_eq!(error["code"], answer.code, "{what}: {answer:?}");
    assert!(error["message"].as_str().is_some_and(|message| !message.is_empty()), "{what}");
    assert_eq!(answer.header("content-type"), Some("application/json"), "{what}");
    let details = error["details"].as_array().unwrap_or_else(|| panic!("{what}: {body}"));
    details
        .iter()
        .map(|detail| {
            let text = |name: &str| detail[name].as_str().map(str::to_owned);
            let (Some(reason), Some(field)) = (text("reason"), text("field")) else {
                panic!("{what}: {detail}")
            };
            assert!(text("remedy").is_some_and(|remedy| !remedy.is_empty()), "{what}: {detail}");
            assert!(detail.get("value").is_some(), "{what}: {detail}");
            (reason, field)
        })
        .collect()
}

/// The next request of [`driven`]'s agent, as JSON, changed by `change`.
fn step_with(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut body = serde_json::to_value(request(4711, 4, 10.12)).unwrap();
    change(&mut body);
    serde_json::to_vec(&body).unwrap()
}

/// The same with the text `"HERE"` replaced by what JSON itself does not know.
fn step_saying(field: &str, literal: &str) -> Vec<u8> {
    let body = step_with(|body| *body.pointer_mut(field).unwrap() = json!("HERE"));
    String::from_utf8(body).unwrap().replace("\"HERE\"", literal).into_bytes()
}

/// A change to a request in JSON.
type Change = fn(&mut Value);

/// Names and values.
type Headers = &'static [(&'static str, &'static str)];

/// Guards against: a field that no one checks reaches the controller and moves the robot, or ends its task.
#[tokio::test]
async fn a_step_that_means_nothing_is_refused_and_changes_nothing() {
    let server = Server::start();
    let robot = driven(&server).await;
    let path = format!("/v1/robots/{robot}/step");
    let observation = || json!({"x_m": 0, "y_m": 0, "heading_rad": 0, "taken_s": 10.0});
    let changed: [(&str, Change, &str, &str); 12] = [
        ("unknown field", |body| body["speed_m_per_s"] = json!(9), "UNKNOWN_FIELD", ""),
        (
            "inner one",
            |body| body["observations"][0]["z_m"] = json!(1),
            "UNKNOWN_FIELD",
            "observations[0]",
        ),
        ("text for a number", |body| body["sequence"] = json!("4"), "MALFORMED", "sequence"),
        ("negative", |body| body["sequence"] = json!(-4), "MALFORMED", "sequence"),
        ("fraction", |body| body["epoch"] = json!(0.5), "MALFORMED", "epoch"),
        ("null", |body| body["sent_s"] = json!(null), "MALFORMED", "sent_s"),
        ("object for a list", |body| body["observations"] = json!({}), "MALFORMED", "observations"),
        (
            "huge",
            |body| body["observations"][0]["x_m"] = json!(1e308),
            "OUT_OF_RANGE",
            "observations[0].x_m",
        ),
        ("beyond 2^53", |body| body["epoch"] = json!(u64::MAX), "OUT_OF_RANGE", "epoch"),
        (
            "from the future",
            |body| body["observations"][0]["taken_s"] = json!(10.2),
            "INCONSISTENT",
            "observations[0].taken_s",
        ),
        (
            "reply to itself",
            |body| body["deliveries"] = json!([{"sequence": 4, "loop_delay_s": 0.2}]),
            "INCONSISTENT",
            "deliveries[0].sequence",
        ),
        (
            "delay below nothing",
            |body| body["deliveries"] = json!([{"sequence": 3, "loop_delay_s": -0.2}]),
            "OUT_OF_RANGE",
            "deliveries[0].loop_delay_s",
        ),
    ];
    let mut bad: Vec<(&str, Vec<u8>, &str, &str)> = changed
        .into_iter()
        .map(|(what, change, reason, field)| (what, step_with(change), reason, field))
        .collect();
    let many: Vec<Value> = (0..33)
        .map(|index| {
            let mut one = observation();
            one["taken_s"] = json!(9.0 + f64::from(index) * 0.03);
            one
        })
        .collect();
    let truncated = step_with(|_| {});
    bad.extend([
        ("not a number", step_saying("/sent_s", "NaN"), "MALFORMED", ""),
        ("infinite", step_saying("/sent_s", "-Infinity"), "MALFORMED", ""),
        ("beyond f64", step_saying("/observations/0/y_m", "1e999"), "MALFORMED", ""),
        (
            "too many poses",
            step_with(|body| body["observations"] = json!(many)),
            "WRONG_LENGTH",
            "observations",
        ),
        (
            "same pose twice",
            step_with(|body| body["observations"] = json!([observation(), observation()])),
            "INCONSISTENT",
            "observations[1].taken_s",
        ),
        ("nothing", Vec::new(), "MALFORMED", ""),
        ("an array", b"[]".to_vec(), "MALFORMED", ""),
        ("a half", truncated[..truncated.len() / 2].to_vec(), "MALFORMED", ""),
        ("two", [truncated.clone(), truncated.clone()].concat(), "MALFORMED", ""),
        ("no text", vec![0xff; 100], "MALFORMED", ""),
        ("very deep", vec![b'['; 60_000], "MALFORMED", ""),
        (
            "very long name",
            format!("{{\"{}\": 1}}", "x".repeat(60_000)).into_bytes(),
            "UNKNOWN_FIELD",
            "",
        ),
        ("a field twice", [b"{\"epoch\": 1, ", &truncated[1..]].concat(), "MALFORMED", ""),
    ]);
    let before = shown(&server, &robot).await;
    for (what, body, reason, field) in bad {
        let answer = http::call(server.address, "POST", &path, &[], &body).await;
        let details = details(&answer, what);
        let code = if reason == "INCONSISTENT" { 409 } else { 400 };
        assert_eq!(answer.code, code, "{what}: {answer:?}");
        let named = details.iter().any(|(given, at)| given == reason && at.starts_with(field));
        assert!(named, "{what}: no {reason} at {field:?} in {details:?}");
        assert!(answer.body.len() < 4096, "{what}: it is not sent back");
        assert_eq!(shown(&server, &robot).await, before, "{what} changed the robot");
    }
    // The agent notices nothing: its next request is the newest, its last one is a repeat.
    let steps = server.client.step_connection();
    let next = steps.step(&robot, &request(4711, 4, 10.12)).await.unwrap();
    assert_eq!(next.horizon.answers, 4);
}

/// Guards against: people who set up a robot are told of one mistake at a time.
#[tokio::test]
async fn all_problems_are_told_at_once() {
    let server = Server::start();
    let robot = driven(&server).await;
    let before = shown(&server, &robot).await;
    let path = format!("/v1/robots/{robot}");
    let step = step_with(|body| {
        body["sent_s"] = json!(1e12);
        body["observations"][0]["x_m"] = json!(1e308);
        body["observations"][0]["heading_rad"] = json!(-1e7);
        body["playing"] = json!({"horizon": 1u64 << 60, "since_s": 0});
    });
    let spec = json!({
        "horizon_slots": 0, "watchdog_s": -1, "colour": "red",
        "drive": {"wheel_radius_m": 0, "lag": 0.1, "min_linear_m_per_s": 1.0},
    });
    let task = json!({
        "waypoints": [{"x_m": 1e308, "y_m": 0}, {"x_m": 0, "y_m": -1e5, "z_m": 0}],
        "tolerance_m": 0, "calibration": {"rotations": 5000}, "speed": 1,
    });
    let to_bytes = |value: Value| serde_json::to_vec(&value).unwrap();
    let cases: [(&str, String, Vec<u8>, &[&str]); 3] = [
        (
            "POST",
            format!("{path}/step"),
            step,
            &["sent_s", "observations[0].x_m", "observations[0].heading_rad", "playing.horizon"],
        ),
        (
            "PUT",
            path.clone(),
            to_bytes(spec),
            &[
                "horizon_slots",
                "watchdog_s",
                "colour",
                "drive.wheel_radius_m",
                "drive.lag",
                "drive.min_linear_m_per_s",
            ],
        ),
        (
            "PUT",
            format!("{path}/task"),
            to_bytes(task),
            &[
                "waypoints[0].x_m",
                "waypoints[1].y_m",
                "waypoints[1].z_m",
                "tolerance_m",
                "calibration.rotations",
                "speed",
            ],
        ),
    ];
    for (method, path, body, wrong) in cases {
        let answer = http::call(server.address, method, &path, &[], &body).await;
        let what = format!("{method} {path}");
        let fields: Vec<String> = details(&answer, &what).into_iter().map(|(_, at)| at).collect();
        for field in wrong {
            assert!(fields.iter().any(|at| at == field), "{what}: {field} is not in {fields:?}");
        }
        assert_eq!(shown(&server, &robot).await, before, "{what} changed the robot");
    }
}

/// Guards against: a body that is refused unread costs the agent its answer, or the server its memory.
#[tokio::test]
async fn a_body_that_is_too_large_is_refused_with_words() {
    let server = Server::start();
    let robot = driven(&server).await;
    let before = shown(&server, &robot).await;
    let padded = |length: usize| {
        let mut body = step_with(|_| {});
        body.resize(length, b' ');
        body
    };
    for (path, largest) in [("step", 64 << 10), ("task", 256 << 10)] {
        let method = if path == "step" { "POST" } else { "PUT" };
        let path = format!("/v1/robots/{robot}/{path}");
        for length in [largest + 1, 8 << 20] {
            let what = format!("{length} bytes to {path}");
            let answer = http::call(server.address, method, &path, &[], &padded(length)).await;
            let details = details(&answer, &what);
            assert!(matches!(answer.code, 400 | 413), "{what}: {answer:?}");
            assert_eq!(details[0].0, "BODY_TOO_LARGE", "{what}: {answer:?}");
        }
    }
    assert_eq!(shown(&server, &robot).await, before);
    let path = format!("/v1/robots/{robot}/step");
    let answer = http::call(server.address, "POST", &path, &[], &padded(64 << 10)).await;
    assert_eq!(answer.code, 200, "the largest is taken: {answer:?}");
}

/// Guards against: an id that is none makes a robot that no one can name again, or a path that leads elsewhere.
#[tokio::test]
async fn ids_and_paths_that_are_none_are_refused() {
    let server = Server::start();
    let robot = driven(&server).await;
    let before = shown(&server, &robot).await;
    let long = "a".repeat(64);
    for name in [
        "_rover",
        ".rover",
        "rover%207",
        "%C3%A4",
        "%ff%fe",
        "..%2Fstop",
        &long,
        "a%00",
        "%2e",
        "a%5Cb",
    ] {
        for (method, below) in [("PUT", ""), ("GET", ""), ("POST", "/step"), ("POST", "/stop")] {
            let path = format!("/v1/robots/{name}{below}");
            let answer = http::call(server.address, method, &path, &[], b"{}").await;
            let details = details(&answer, &path);
            assert_eq!(answer.code, 400, "{method} {path}: {answer:?}");
            assert_eq!(details[0].0, "INVALID_ID", "{method} {path}: {answer:?}");
        }
    }
    let cases: [(&str, &str, Headers, u16); 10] = [
        ("GET", "/v1/robots/", &[], 404),
        ("POST", "/v1/robots//step", &[], 400),
        ("GET", "/v1/robots/nobody", &[], 404),
        ("POST", "/v1/robots/nobody/step", &[], 404),
        ("POST", "/v1/robots/rover-7", &[], 405),
        ("GET", "/v1/robots?page_size=0", &[], 400),
        ("GET", "/v1/robots?page_size=many&state=gone&colour=red", &[], 400),
        ("GET", "/v1/robots", &[("grpc-timeout", "soon")], 400),
        ("GET", "/v1/events", &[("last-event-id", "yesterday")], 400),
        ("POST", "/v1/robots/rover-7/step", &[("Content-Type", "text/plain")], 415),
    ];
    for (method, path, headers, code) in cases {
        let answer = http::call(server.address, method, path, headers, b"{}").await;
        details(&answer, path);
        assert_eq!(answer.code, code, "{method} {path}: {answer:?}");
    }
    assert_eq!(shown(&server, &robot).await, before);
    let page = server.client.list_robots(&Default::default()).await.unwrap();
    assert_eq!(page.robots.len(), 1, "no robot came into being");
}
