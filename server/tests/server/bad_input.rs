//! No request, however bad, moves a robot or loses state; each is answered with the one error body.

use crate::api::{Answer, Api, JSON, step};
use serde_json::{Value, json};

/// Sends `body` as a step and holds that it is refused and nothing changes.
async fn refused(api: &Api, body: impl Into<Vec<u8>>) -> Answer {
    let before = api.state().await;
    let body: Vec<u8> = body.into();
    let answer = api.call("POST", "/v1/robots/r/step", &[JSON], body.clone()).await;
    let shown: String = String::from_utf8_lossy(&body).chars().take(100).collect();
    assert!((400..500).contains(&answer.code), "{shown}: {answer:?}");
    assert_eq!(answer.problem().0, "INVALID_ARGUMENT", "{shown}");
    assert_eq!(api.state().await, before, "{shown}");
    answer
}

fn with(path: &str, value: Value) -> String {
    let mut body = step(7, 2, 10.03, 0.01);
    *body.pointer_mut(path).expect(path) = value;
    body.to_string()
}

/// A good step after a first one, into which each test puts something bad.
async fn driving() -> Api {
    let api = Api::with_robot().await;
    assert_eq!(api.step(step(7, 1, 10.0, 0.0)).await.code, 200);
    api
}

#[tokio::test(start_paused = true)]
async fn numbers_that_are_none_or_huge() {
    let api = driving().await;
    for value in [json!("NaN"), json!(null), json!(1e308), json!(-1e5), json!("0.0"), json!([0.0])]
    {
        let answer = refused(&api, with("/observations/0/x_m", value)).await;
        assert_eq!(answer.fields(), ["observations[0].x_m"]);
    }
    for text in ["NaN", "Infinity", "-Infinity", "1e999", "0x10", "+1", "1.", ".5"] {
        let body = with("/sent_s", json!(10.03)).replace("10.03", text);
        refused(&api, body).await;
    }
    for value in [json!(-1), json!(1.5), json!(u64::MAX), json!("2"), json!(null)] {
        refused(&api, with("/sequence", value.clone())).await;
        refused(&api, with("/epoch", value)).await;
    }
    assert_eq!(api.step(step(7, 2, 10.03, 0.0)).await.code, 200, "the robot is unharmed");
}

#[tokio::test(start_paused = true)]
async fn every_bad_field_at_once() {
    let api = driving().await;
    let mut body = step(7, 2, 10.03, 1e9);
    body["observations"][0]["taken_s"] = json!(11.0);
    body["deliveries"] = json!([{"sequence": 99, "loop_delay_s": -1.0}]);
    body["playing"] = json!({"horizon": 1, "since_s": 1e12});
    let mut fields = refused(&api, body.to_string()).await.fields();
    fields.dedup();
    let expected = [
        "observations[0].x_m",
        "observations[0].taken_s",
        "deliveries[0].loop_delay_s",
        "deliveries[0].sequence",
        "playing.since_s",
    ];
    assert_eq!(fields, expected);
}

#[tokio::test(start_paused = true)]
async fn shapes_that_are_none() {
    let api = driving().await;
    let unknown = refused(&api, r#"{"epoch":7,"sequence":2,"sent_s":10.03,"speed":1}"#).await;
    assert_eq!(unknown.problem().1, "UNKNOWN_FIELD");
    let nested = format!("{}{}", "[".repeat(20_000), "]".repeat(20_000));
    for body in
        ["", "null", "[]", "{}", "7", "\"\"", "{", "{}{}", &nested, "{\"epoch\":7,\"epoch\":7}"]
    {
        refused(&api, body).await;
    }
    refused(&api, b"\xff\xfe{\"epoch\":7}".to_vec()).await;
    refused(&api, b"{\"epoch\xc3\x28\":7}".to_vec()).await;
    let twice = with("/observations/0/taken_s", json!(9.93));
    let pose = r#"{"x_m":0.0,"y_m":0.0,"heading_rad":0.0,"taken_s":9.93}"#;
    refused(&api, twice.replace("[{", &format!("[{pose},{{"))).await;
    let many = format!("[{}]", vec![pose; 33].join(","));
    let answer = refused(
        &api,
        format!(r#"{{"epoch":7,"sequence":2,"sent_s":10.03,"observations":{many}}}"#),
    );
    assert!(answer.await.fields().contains(&"observations".to_owned()));
}

#[tokio::test(start_paused = true)]
async fn bodies_that_are_too_large() {
    let api = driving().await;
    let answer = refused(&api, vec![b' '; 64 * 1024 + 1]).await;
    assert_eq!((answer.code, answer.problem().1.as_str()), (413, "BODY_TOO_LARGE"));
    // Elsewhere more is allowed, since a long task needs it, but not everything.
    let waypoints = vec![json!({"x_m": 0.123456789, "y_m": -0.123456789}); 1000];
    let task = json!({"waypoints": waypoints, "calibration": {}}).to_string();
    let padded = format!("{task}{}", " ".repeat(100_000));
    assert_eq!(api.call("PUT", "/v1/robots/r/task", &[JSON], padded).await.code, 200);
    let huge = api.call("PUT", "/v1/robots/r/task", &[JSON], vec![b' '; 1024 * 1024 + 1]).await;
    assert_eq!((huge.code, huge.problem().1.as_str()), (413, "BODY_TOO_LARGE"));
}

#[tokio::test(start_paused = true)]
async fn a_bad_description_or_task_changes_nothing() {
    let api = driving().await;
    let before = api.state().await;
    let spec = json!({"drive": {"track_width_m": -1, "colour": "red"}, "horizon_slots": 0});
    let answer = api.put("/v1/robots/r", spec).await;
    assert_eq!(answer.fields(), ["drive.colour", "drive.track_width_m", "horizon_slots"]);
    let task = json!({"waypoints": [{"x_m": 0, "y_m": 1e9}], "tolerance_m": 0});
    let answer = api.put("/v1/robots/r/task", task).await;
    assert_eq!(answer.fields(), ["waypoints[0].y_m", "tolerance_m"]);
    let nowhere = api.put("/v1/robots/r/task", json!({"waypoints": []})).await;
    assert_eq!((nowhere.code, nowhere.problem().1.as_str()), (409, "INCONSISTENT"));
    assert_eq!(api.put("/v1/robots/_new", json!({})).await.problem().1, "INVALID_ID");
    assert_eq!(api.state().await, before);
    assert_eq!(api.get("/v1/robots").await.json()["robots"].as_array().unwrap().len(), 1);
}

const TEXT: (&str, &str) = ("content-type", "text/plain");

/// Method, path, headers, body; HTTP status, name and reason of the problem.
type Case = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
    &'static str,
    u16,
    &'static str,
    &'static str,
);

/// Guards against: an answer of the framework instead of ours, in plain text.
#[tokio::test(start_paused = true)]
async fn whatever_is_wrong_the_body_is_the_same() {
    let api = driving().await;
    let cases: [Case; 26] = [
        ("GET", "/", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("GET", "/v1/robots/", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("GET", "/v1/robots/r/nothing", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("POST", "/v1/robots//step", &[JSON], "{}", 400, "INVALID_ARGUMENT", "INVALID_ID"),
        ("BREW", "/v1/robots", &[], "", 405, "UNIMPLEMENTED", "METHOD_NOT_ALLOWED"),
        ("POST", "/v1/robots/r", &[JSON], "{}", 405, "UNIMPLEMENTED", "METHOD_NOT_ALLOWED"),
        ("GET", "/v1/robots/r/step", &[], "", 405, "UNIMPLEMENTED", "METHOD_NOT_ALLOWED"),
        ("GET", "/v1/robots/%ff%fe", &[], "", 400, "INVALID_ARGUMENT", "INVALID_ID"),
        ("GET", "/v1/robots/%zz", &[], "", 400, "INVALID_ARGUMENT", "INVALID_ID"),
        ("GET", "/v1/robots/.r", &[], "", 400, "INVALID_ARGUMENT", "INVALID_ID"),
        ("PUT", "/v1/robots/..%2fr", &[JSON], "{}", 400, "INVALID_ARGUMENT", "INVALID_ID"),
        ("GET", "/v1/robots/unknown", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("GET", "/v1/robots/unknown/events", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("DELETE", "/v1/robots/unknown", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("PUT", "/v1/robots/unknown/task", &[JSON], "{}", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("POST", "/v1/robots/unknown/stop", &[], "", 404, "NOT_FOUND", "NO_SUCH_RESOURCE"),
        ("PUT", "/v1/robots/r", &[TEXT], "{}", 415, "INVALID_ARGUMENT", "UNSUPPORTED_MEDIA_TYPE"),
        ("PUT", "/v1/robots/r", &[], "{}", 415, "INVALID_ARGUMENT", "UNSUPPORTED_MEDIA_TYPE"),
        (
            "POST",
            "/v1/robots/r/step",
            &[TEXT],
            "{}",
            415,
            "INVALID_ARGUMENT",
            "UNSUPPORTED_MEDIA_TYPE",
        ),
        ("GET", "/v1/robots?page_size=0", &[], "", 400, "INVALID_ARGUMENT", "OUT_OF_RANGE"),
        ("GET", "/v1/robots?page_size=x", &[], "", 400, "INVALID_ARGUMENT", "MALFORMED"),
        ("GET", "/v1/robots?page_token=.a", &[], "", 400, "INVALID_ARGUMENT", "MALFORMED"),
        ("GET", "/v1/robots?colour=red", &[], "", 400, "INVALID_ARGUMENT", "UNKNOWN_FIELD"),
        ("GET", "/v1/events", &[("last-event-id", "x")], "", 400, "INVALID_ARGUMENT", "MALFORMED"),
        ("GET", "/v1/robots", &[("grpc-timeout", "1x")], "", 400, "INVALID_ARGUMENT", "MALFORMED"),
        (
            "PUT",
            "/v1/robots/r",
            &[JSON, ("if-none-match", "\"a\"")],
            "{}",
            400,
            "INVALID_ARGUMENT",
            "MALFORMED",
        ),
    ];
    for (method, path, headers, body, code, status, reason) in cases {
        let answer = api.call(method, path, headers, body.to_owned()).await;
        assert_eq!(answer.code, code, "{method} {path}: {answer:?}");
        assert_eq!(answer.problem(), (status.to_owned(), reason.to_owned()), "{method} {path}");
        if code == 405 {
            assert!(answer.headers.contains_key("allow"), "{method} {path}");
        }
    }
}

/// Guards against: a list that passes for an object, a file of an editor or a program's whole numbers that are refused
/// for no reason that one could see.
#[tokio::test(start_paused = true)]
async fn what_is_read_is_what_was_said() {
    let api = driving().await;
    let before = api.state().await;
    let task = "/v1/robots/r/task";
    for (path, body) in [
        ("/v1/robots/r", "[]"),
        ("/v1/robots/r", r#"{"drive": [0.05, 0.2]}"#),
        ("/v1/robots/r", r#"{"predictor": ["monte-carlo", 100, 0.01, 7]}"#),
        (task, r#"{"waypoints": [{"x_m": 0.3, "y_m": 0}], "calibration": []}"#),
        (task, r#"{"waypoints": [[0.3, 0]]}"#),
        ("/v1/priors/p", "[]"),
        ("/v1/environments/e", r#"["hard", "bad"]"#),
    ] {
        let answer = api.call("PUT", path, &[JSON], body).await;
        assert_eq!(answer.problem(), ("INVALID_ARGUMENT".into(), "MALFORMED".into()), "{body}");
        assert_eq!(answer.code, 400, "{body}");
    }
    refused(&api, r#"[1, 7, 10.03, [[0, 0, 0, 0.4]], [], null]"#).await;
    assert_eq!(api.state().await, before);
    assert_eq!(api.get("/v1/priors/p").await.code, 404);
    for path in ["/v1/evolutions", "/v1/comparisons"] {
        assert_eq!(api.call("POST", path, &[JSON], "[]").await.code, 400, "{path}");
    }

    let marked = "\u{feff}{\"horizon_slots\": 7.0}".to_owned();
    assert_eq!(api.call("PUT", "/v1/robots/r", &[JSON], marked).await.code, 200);
    assert_eq!(api.get("/v1/robots/r").await.json()["spec"]["horizon_slots"], 7);
    let words = api.call("PUT", "/v1/robots/r", &[JSON], r#"{"horizon_slots": NaN}"#).await;
    let detail = &words.json()["error"]["details"][0];
    assert_eq!(detail["field"], "horizon_slots");
    assert!(detail["remedy"].as_str().unwrap().starts_with("NaN is no number in JSON"), "{detail}");
}

/// Guards against: a compressed body is told that it is malformed at line 1 column 1.
#[tokio::test(start_paused = true)]
async fn a_body_that_is_encoded_is_refused_as_that() {
    let api = driving().await;
    for coding in ["gzip", "br", "identity, gzip", "x-own"] {
        let headers = [JSON, ("content-encoding", coding)];
        let answer = api.call("PUT", "/v1/robots/r", &headers, "{}").await;
        assert_eq!((answer.code, answer.problem().1.as_str()), (415, "UNSUPPORTED_ENCODING"));
        assert_eq!(answer.fields(), ["Content-Encoding"]);
        let step = api.call("POST", "/v1/robots/r/step", &headers, "{}").await;
        assert_eq!(step.code, 415);
    }
    let plain = [JSON, ("content-encoding", "identity")];
    assert_eq!(api.call("PUT", "/v1/robots/r", &plain, "{}").await.code, 200);
}

/// Guards against: a note that rewrites the terminal of whoever lists priors.
#[tokio::test(start_paused = true)]
async fn notes_show_as_what_they_are() {
    let api = Api::new().await;
    for (character, name) in [
        ('\u{1b}', "U+001B"),
        ('\n', "U+000A"),
        ('\u{9b}', "U+009B"),
        ('\u{202e}', "U+202E"),
        ('\u{2028}', "U+2028"),
    ] {
        let note = format!("äb{character}c");
        for (path, mut body) in [
            ("/v1/priors/p", json!({})),
            ("/v1/environments/e", json!({"slip": "none", "link": "bad"})),
        ] {
            body["note"] = json!(note);
            let answer = api.put(path, body).await;
            assert_eq!(answer.problem().1, "HIDDEN_CHARACTER", "{name}");
            let remedy = answer.json()["error"]["details"][0]["remedy"].to_string();
            assert!(
                remedy.contains(&format!("{name}, which stands behind 2 characters")),
                "{remedy}"
            );
        }
    }
    let note = "größer als 5 µm 👩\u{200d}🔧 床".repeat(40);
    let kept = api.put("/v1/priors/p", json!({"note": note})).await;
    assert_eq!((kept.code, &kept.json()["note"]), (201, &json!(note)));
}

/// What an earlier version took goes on: it is shown, described anew and removed; nothing new goes by such a name.
#[tokio::test(start_paused = true)]
async fn nothing_new_begins_with_a_hyphen() {
    let api = Api::new().await;
    for path in ["/v1/robots/-r", "/v1/priors/-p"] {
        let answer = api.put(path, json!({})).await;
        assert_eq!((answer.code, answer.problem().1.as_str()), (400, "INVALID_ID"), "{path}");
        assert_eq!(api.get(path).await.code, 404, "{path}");
    }
    let environment = json!({"slip": "none", "link": "bad"});
    assert_eq!(api.put("/v1/environments/-e", environment).await.problem().1, "INVALID_ID");
    let evolution = api.call("POST", "/v1/evolutions", &[JSON], r#"{"prior": "-p"}"#).await;
    assert_eq!(evolution.problem().1, "INVALID_ID");
}

/// Guards against: whoever sends a good request hears that it is bad, and looks for the mistake in it.
#[tokio::test(start_paused = true)]
async fn what_is_good_and_at_odds_is_a_conflict() {
    let api = driving().await;
    for (path, body, reason) in [
        ("/v1/robots/r", json!({"prior": "nobody"}), "UNKNOWN_PRIOR"),
        ("/v1/robots/r", json!({"steering": {"turn_beyond_rad": 0.01}}), "INCONSISTENT"),
        ("/v1/priors/thesis", json!({}), "BUILT_IN"),
        ("/v1/environments/normal", json!({"slip": "none", "link": "bad"}), "BUILT_IN"),
    ] {
        let answer = api.put(path, body).await;
        assert_eq!((answer.code, answer.problem().1.as_str()), (409, reason), "{path}");
    }
    let late = api.step(with("/observations/0/taken_s", json!(11.0))).await;
    assert_eq!((late.code, late.problem().1.as_str()), (409, "INCONSISTENT"));
    let unknown = r#"{"environments": ["nowhere"]}"#;
    let answer = api.call("POST", "/v1/evolutions", &[JSON], unknown).await;
    assert_eq!((answer.code, answer.problem().1.as_str()), (409, "UNKNOWN_ENVIRONMENT"));
    // One bad field more, and it is a bad request.
    let both = api.put("/v1/robots/r", json!({"prior": "nobody", "horizon_slots": 0})).await;
    assert_eq!(both.code, 400);
}

#[tokio::test(start_paused = true)]
async fn the_query_is_checked_as_a_whole() {
    let api = Api::new().await;
    let answer = api.get("/v1/robots?page_size=0&page_token=.a&state=gone&colour=red").await;
    let mut fields = answer.fields();
    fields.sort();
    assert_eq!(fields, ["colour", "page_size", "page_token", "state"]);
}
