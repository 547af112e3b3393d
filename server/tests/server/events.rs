//! Following what happens.

use crate::api::{Api, config, step};
use axum::body::{Body, BodyDataStream};
use axum::http::Request;
use futures_util::{FutureExt, StreamExt};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use tower::ServiceExt;
use umwelt_server::Config;
use umwelt_server::store::MemoryStore;

/// A follower, as a client would read the stream.
pub(crate) struct Stream {
    body: BodyDataStream,
    text: String,
}

impl Stream {
    pub(crate) async fn open(api: &Api, path: &str, after: Option<u64>) -> Self {
        let mut request = Request::builder().uri(path).header("host", "localhost");
        if let Some(after) = after {
            request = request.header("last-event-id", after.to_string());
        }
        let response = api.0.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
        assert_eq!(response.status(), 200);
        assert_eq!(response.headers()["content-type"], "text/event-stream");
        assert_eq!(response.headers()["cache-control"], "no-cache");
        assert_eq!(response.headers()["x-accel-buffering"], "no", "nginx would hold it back");
        Self { body: response.into_body().into_data_stream(), text: String::new() }
    }

    /// The next block of the stream: an event or a comment. None at its end.
    pub(crate) async fn block(&mut self) -> Option<String> {
        loop {
            if let Some((block, rest)) = self.text.split_once("\n\n") {
                let block = block.to_owned();
                self.text = rest.to_owned();
                return Some(block);
            }
            let bytes = self.body.next().await?.unwrap();
            self.text.push_str(std::str::from_utf8(&bytes).unwrap());
        }
    }

    /// The next event, whose three lines must agree. None at the end of the stream.
    async fn next(&mut self) -> Option<Value> {
        let event = async {
            loop {
                let block = self.block().await?;
                if !block.starts_with(':') {
                    return Some(block);
                }
            }
        };
        let event = tokio::time::timeout(Duration::from_secs(60), event);
        let block = event.await.expect("an event, or the end, within a minute")?;
        let field = |name: &str| block.lines().find_map(|line| line.strip_prefix(name));
        let event: Value = serde_json::from_str(field("data: ").unwrap()).unwrap();
        assert_eq!(field("id: ").unwrap(), event["id"].to_string());
        assert_eq!(field("event: ").unwrap(), event["type"]);
        Some(event)
    }

    /// What is there without waiting.
    fn ready(&mut self) -> Vec<Value> {
        std::iter::from_fn(|| self.next().now_or_never().flatten()).collect()
    }
}

fn types(events: &[Value]) -> Vec<&str> {
    events.iter().map(|event| event["type"].as_str().unwrap()).collect()
}

async fn drive(api: &Api, sequences: std::ops::Range<u64>) {
    for sequence in sequences {
        let answer = api.step(step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0)).await;
        assert_eq!(answer.code, 200);
        tokio::time::advance(Duration::from_millis(30)).await;
    }
}

#[tokio::test(start_paused = true)]
async fn what_happens_to_a_robot_is_told_in_order() {
    let api = Api::new().await;
    let mut all = Stream::open(&api, "/v1/events", None).await;
    api.add("other").await;
    api.add("r").await;
    let mut stream = Stream::open(&api, "/v1/robots/r/events", None).await;
    drive(&api, 1..2).await;
    api.post("/v1/robots/r/stop").await;
    api.post("/v1/robots/r/stop").await;
    api.post("/v1/robots/r/resume").await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    api.delete("/v1/robots/r/task").await;
    api.delete("/v1/robots/r").await;
    let mut events = Vec::new();
    while let Some(event) = stream.next().await {
        events.push(event);
    }
    let told = types(&events);
    let told: Vec<_> = told.into_iter().filter(|name| *name != "calibration_ended").collect();
    assert_eq!(told[..2], ["link", "epoch"]);
    assert_eq!(told[told.len() - 5..], ["stopped", "resumed", "link", "task", "removed"]);
    for name in ["pose", "horizon", "environment"] {
        assert!(told.contains(&name), "{name}");
    }
    let lost = events.iter().rfind(|event| event["type"] == "link").unwrap();
    assert_eq!(lost["state"], "lost");
    assert!(events.iter().all(|event| event["robot"] == "r"));

    let everything = all.ready();
    let ids: Vec<_> = everything.iter().map(|event| event["id"].as_u64().unwrap()).collect();
    assert!(ids.windows(2).all(|pair| pair[0] + 1 == pair[1]), "none is left out: {ids:?}");
    let of_robot: Vec<_> = everything.iter().filter(|event| event["robot"] == "r").collect();
    assert_eq!(of_robot[of_robot.len() - events.len()..], events.iter().collect::<Vec<_>>());
}

/// Browsers' event sources and their stand-ins send it before they have received anything.
#[tokio::test]
async fn an_empty_last_event_id_is_none() {
    let api = Api::with_robot().await;
    for path in ["/v1/events", "/v1/robots/r/events"] {
        let request = Request::builder().uri(path).header("host", "localhost");
        let request = request.header("last-event-id", "").body(Body::empty()).unwrap();
        let response = api.0.clone().oneshot(request).await.unwrap();
        assert_eq!(response.status(), 200, "{path}");
    }
}

#[tokio::test(start_paused = true)]
async fn arriving_is_told() {
    let api = Api::new().await;
    api.put("/v1/robots/r", json!({})).await;
    // The first waypoint is where the robot stands; no one can miss it.
    api.put("/v1/robots/r/task", json!({"waypoints": [{"x_m": 0.0, "y_m": 0.0}]})).await;
    let mut stream = Stream::open(&api, "/v1/robots/r/events", None).await;
    drive(&api, 1..40).await;
    let events = stream.ready();
    let reached = events.iter().find(|event| event["type"] == "waypoint_reached").unwrap();
    assert_eq!(reached["leg"], 0);
    let arrived = events.iter().find(|event| event["type"] == "arrived").unwrap();
    assert!(arrived["elapsed_s"].as_f64().unwrap() < 2.0);
    let done = events.iter().rfind(|event| event["type"] == "task").unwrap();
    assert_eq!(done["stage"], "arrived");
}

#[tokio::test(start_paused = true)]
async fn a_stream_resumes_where_it_broke_off() {
    let api = Api::with_robot().await;
    for path in ["/v1/robots/r/events", "/v1/events"] {
        let mut whole = Stream::open(&api, path, None).await;
        let mut broken = Stream::open(&api, path, None).await;
        for _ in 0..10 {
            api.post("/v1/stop").await;
            api.post("/v1/resume").await;
        }
        let last = broken.next().await.unwrap()["id"].as_u64().unwrap();
        drop(broken);
        let rest = Stream::open(&api, path, Some(last)).await.ready();
        assert_eq!(rest, whole.ready()[1..], "{path}");
    }
}

/// Guards against: a follower that reads nothing holds up the robot, or fills the memory.
#[tokio::test(start_paused = true)]
async fn a_slow_follower_misses_events_and_holds_up_no_one() {
    let api = Api::with_robot().await;
    let mut slow = Stream::open(&api, "/v1/robots/r/events", None).await;
    drive(&api, 1..2000).await;
    let events = slow.ready();
    assert_eq!(events[0]["type"], "missed");
    assert_eq!(events.len(), 257, "no more is kept than the ring holds");
    let resumed = Stream::open(&api, "/v1/robots/r/events", events[0]["id"].as_u64()).await.ready();
    assert_eq!(resumed, events[1..], "nothing more is missed behind it");
    assert_eq!(types(&Stream::open(&api, "/v1/events", Some(0)).await.ready())[0], "missed");
}

#[tokio::test(start_paused = true)]
async fn poses_and_horizons_are_told_at_most_ten_times_a_second() {
    let api = Api::with_robot().await;
    let mut stream = Stream::open(&api, "/v1/robots/r/events", None).await;
    drive(&api, 1..334).await;
    let events = stream.ready();
    let count = |name| types(&events).iter().filter(|told| **told == name).count();
    // Ten seconds at one step per 30 ms; 120 ms is the first multiple of that above 100 ms.
    assert!((80..=101).contains(&count("pose")), "{}", count("pose"));
    assert!((80..=101).contains(&count("horizon")), "{}", count("horizon"));
    assert!((9..=11).contains(&count("environment")), "{}", count("environment"));
}

#[tokio::test(start_paused = true)]
async fn a_silent_stream_is_kept_alive() {
    let api = Api::with_robot().await;
    let mut stream = Stream::open(&api, "/v1/events", None).await;
    let comment = tokio::time::timeout(Duration::from_secs(16), stream.block()).await;
    assert!(comment.unwrap().unwrap().starts_with(':'));
}

#[tokio::test(start_paused = true)]
async fn there_is_a_limit_to_the_number_of_streams() {
    let config = Config { max_event_streams: 2, ..config() };
    let api = Api::with(config, Arc::new(MemoryStore::default())).await;
    let first = Stream::open(&api, "/v1/events", None).await;
    let _second = Stream::open(&api, "/v1/events", None).await;
    let third = api.get("/v1/events").await;
    assert_eq!(third.code, 429);
    assert_eq!(third.problem(), ("RESOURCE_EXHAUSTED".into(), "LIMIT_REACHED".into()));
    drop(first);
    Stream::open(&api, "/v1/events", None).await;
}

/// Guards against: a frame and a wake-up for each event and each follower.
#[tokio::test(start_paused = true)]
async fn what_happens_at_once_comes_in_one_frame_and_in_order() {
    let api = Api::with_robot().await;
    let mut stream = Stream::open(&api, "/v1/robots/r/events", None).await;
    api.post("/v1/stop").await;
    api.post("/v1/resume").await;
    let first = stream.body.next().await.unwrap().unwrap();
    let first = std::str::from_utf8(&first).unwrap();
    assert_eq!(first.matches("\n\n").count(), 2, "{first}");
    assert!(first.find("stopped") < first.find("resumed"), "{first}");
    // Shortly after a frame, what happens is gathered for the next one.
    api.put("/v1/robots/r", json!({})).await;
    assert!(stream.body.next().now_or_never().is_none());
    api.put("/v1/robots/r", json!({})).await;
    let second = stream.body.next().await.unwrap().unwrap();
    assert_eq!(std::str::from_utf8(&second).unwrap().matches("\n\n").count(), 2);
}
