//! Streams that break, resume and end.

use super::*;
use crate::test_server::{Server, answer, json};
use hyper::{HeaderMap, Method, StatusCode};
use std::sync::{Arc, Mutex};
use umwelt_api::comparison::ComparisonKind;
use umwelt_api::event::Kind;
use umwelt_api::evolution::EvolutionKind;
use umwelt_api::problem::Status;

const NOT_FOUND: &str =
    r#"{"error": {"code": 404, "status": "NOT_FOUND", "message": "m", "details": []}}"#;

#[tokio::test]
async fn a_broken_stream_resumes_behind_the_last_event_until_it_cannot() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            let last = last_event_id(request.headers());
            assert_eq!(request.method(), Method::GET);
            assert_eq!(request.headers().get("grpc-timeout"), None);
            let mut seen = seen.lock().unwrap();
            seen.push(last);
            let answer = match seen.len() {
                1 => answer(
                    StatusCode::OK,
                    "text/event-stream",
                    "id: 7\ndata: {\"id\": 7, \"robot\": \"a\", \"type\": \"stopped\"}\n\n:\n\nid: 8\ndata: nonsense\n\n",
                ),
                _ => json(StatusCode::NOT_FOUND, NOT_FOUND),
            };
            async { answer }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap();
    let mut events = client.events(None, Some(3)).await.unwrap();
    assert_eq!(events.next().await.unwrap().unwrap().kind, Kind::Stopped);
    let unreadable = events.next().await.unwrap().unwrap_err();
    assert!(matches!(unreadable, Error::Protocol { .. }));
    let interrupted = events.next().await.unwrap().unwrap_err();
    assert!(interrupted.is_transient(), "{interrupted:?}");
    let last = events.next().await.unwrap().unwrap_err();
    assert_eq!(last.status(), Some(Status::NotFound));
    assert!(events.next().await.is_none());
    assert_eq!(*seen.lock().unwrap(), [Some(3), Some(8)]);
}

#[tokio::test]
async fn what_is_no_event_stream_is_told_at_once() {
    let server = Server::start(|_| async { json(StatusCode::OK, "{}") }).await;
    let client = Client::new(&server.url).unwrap();
    let error = client.events(Some(&"a".parse().unwrap()), None).await.err().unwrap();
    assert!(error.to_string().contains("no event stream but application/json"), "{error}");
}

const GENERATION: &str = r#"{"id": 1, "evolution": "evolution-1", "type": "generation", "generation":
    {"index": 0, "best_fitness": 1.5, "mean_fitness": 1, "prior": {}, "environments": []}}"#;

fn state(id: u64, state: &str) -> String {
    let progress = format!(
        r#"{{"stage": "generations", "generation": {id}, "generations": 2, "best_fitness": null, "mean_fitness": null,
             "episodes": 5, "total_episodes": 9, "elapsed_s": 1.5, "remaining_s": null}}"#
    );
    let event = format!(
        r#"{{"id": {id}, "evolution": "evolution-1", "type": "state", "state": "{state}", "progress": {progress}, "error": null}}"#
    );
    format!("id: {id}\ndata: {}\n\n", event.replace('\n', ""))
}

#[tokio::test]
async fn an_evolution_is_followed_over_a_restart_until_it_has_ended() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            assert_eq!(request.uri(), "/v1/evolutions/evolution-1/events");
            let mut seen = seen.lock().unwrap();
            seen.push(last_event_id(request.headers()));
            let text = match seen.len() {
                1 => format!(
                    "id: 1\ndata: {}\n\n{}",
                    GENERATION.replace('\n', ""),
                    state(1, "running")
                ),
                _ => state(1, "running") + &state(2, "succeeded") + &state(2, "running"),
            };
            let answer = answer(StatusCode::OK, "text/event-stream", &text);
            async { answer }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap();
    let id = "evolution-1".parse().unwrap();
    let events = client.job_events::<EvolutionKind>(&id, None).await.unwrap();
    let words = events.map(|event| match event {
        Ok(event) => format!("{} {}", event.kind.name(), event.id),
        Err(error) => format!("transient {}", error.is_transient()),
    });
    // One more than it should have: a stream that does not end fails here rather than hangs.
    let words: Vec<_> = words.take(6).collect().await;
    let expected = ["generation 1", "state 1", "transient true", "state 1", "state 2"];
    assert_eq!(words, expected);
    assert_eq!(*seen.lock().unwrap(), [None, Some(1)]);
}

fn last_event_id(headers: &HeaderMap) -> Option<u64> {
    headers.get(LAST_EVENT_ID)?.to_str().ok()?.parse().ok()
}

#[tokio::test]
async fn a_comparison_is_followed_over_a_restart_until_it_has_ended() {
    fn state(id: u64, state: &str) -> String {
        let progress = format!(
            r#"{{"stage": "trials", "trials_done": {id}, "trials": 9, "episodes": 5, "total_episodes": 9, "elapsed_s": 1.5, "remaining_s": null}}"#
        );
        format!(
            "id: {id}\ndata: {{\"id\": {id}, \"comparison\": \"comparison-1\", \"type\": \"state\", \"state\": \"{state}\", \"progress\": {progress}, \"error\": null}}\n\n"
        )
    }
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            assert_eq!(request.uri(), "/v1/comparisons/comparison-1/events");
            let mut seen = seen.lock().unwrap();
            seen.push(last_event_id(request.headers()));
            let text = match seen.len() {
                1 => state(0, "queued") + &state(4, "running"),
                _ => state(4, "running") + &state(9, "succeeded") + &state(9, "running"),
            };
            let answer = answer(StatusCode::OK, "text/event-stream", &text);
            async { answer }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap();
    let events =
        client.job_events::<ComparisonKind>(&"comparison-1".parse().unwrap(), None).await.unwrap();
    let words = events.map(|event| match event {
        Ok(event) => format!("{} {}", event.kind.name(), event.id),
        Err(error) => format!("transient {}", error.is_transient()),
    });
    // One more than it should have: a stream that does not end fails here rather than hangs.
    let words: Vec<_> = words.take(6).collect().await;
    assert_eq!(words, ["state 0", "state 4", "transient true", "state 4", "state 9"]);
    assert_eq!(*seen.lock().unwrap(), [None, Some(4)]);
}
