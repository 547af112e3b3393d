//! What the methods send, and what they make of the answers.

use super::*;
use crate::samples::EVOLUTION;
use crate::test_server::{Server, answer, json};
use futures_util::TryStreamExt;
use http_body_util::BodyExt;
use hyper::{HeaderMap, Method, StatusCode};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use umwelt_api::evolution;
use umwelt_api::evolution::EvolutionKind;
use umwelt_api::problem::Status;

const UNAVAILABLE: &str =
    r#"{"error": {"code": 503, "status": "UNAVAILABLE", "message": "m", "details": []}}"#;
const PRECONDITION: &str =
    r#"{"error": {"code": 409, "status": "FAILED_PRECONDITION", "message": "m", "details": []}}"#;

fn key(headers: &HeaderMap) -> String {
    headers["idempotency-key"].to_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_submit_that_is_sent_again_has_the_same_key() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            assert_eq!((request.method(), request.uri().path()), (&Method::POST, "/v1/evolutions"));
            let seen = Arc::clone(&seen);
            async move {
                let key = key(request.headers());
                let body = request.into_body().collect().await.unwrap().to_bytes();
                let mut seen = seen.lock().unwrap();
                seen.push((key, body));
                match seen.len() {
                    1 => json(StatusCode::SERVICE_UNAVAILABLE, UNAVAILABLE),
                    _ => json(StatusCode::CREATED, EVOLUTION),
                }
            }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap();
    let request = evolution::Request { seed: Some(7), ..Default::default() };
    let submitted = client.submit::<EvolutionKind>(&request, None).await.unwrap();
    assert_eq!(submitted.id.as_str(), "evolution-12");
    let given = "mine-1".parse().unwrap();
    client.submit::<EvolutionKind>(&request, Some(&given)).await.unwrap();
    client.submit::<EvolutionKind>(&request, None).await.unwrap();
    let seen = seen.lock().unwrap();
    let keys: Vec<_> = seen.iter().map(|(key, _)| key.as_str()).collect();
    assert_eq!((keys[0], keys[2], keys[0].len()), (keys[1], "mine-1", 32));
    assert_ne!(keys[3], keys[0]);
    assert_eq!(evolution::Request::read(&seen[0].1).unwrap().into_inner(), request);
}

#[tokio::test]
async fn lists_are_walked_over_all_their_pages() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            let path = request.uri().path_and_query().unwrap().to_string();
            let next = if path.contains("page_token=t") { "null" } else { "\"t\"" };
            let page = match request.uri().path() {
                "/v1/evolutions" => {
                    format!(r#"{{"evolutions": [{EVOLUTION}], "next_page_token": {next}}}"#)
                }
                "/v1/evolutions/e/generations" => {
                    format!(r#"{{"generations": [], "next_page_token": {next}}}"#)
                }
                "/v1/priors" => format!(r#"{{"priors": [], "next_page_token": {next}}}"#),
                _ => format!(r#"{{"environments": [], "next_page_token": {next}}}"#),
            };
            seen.lock().unwrap().push(path);
            async move { json(StatusCode::OK, &page) }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap();
    let failed = Some(evolution::State::Failed);
    let evolutions: Vec<_> = client.jobs::<EvolutionKind>(failed).try_collect().await.unwrap();
    assert_eq!(evolutions.len(), 2);
    let generations: Vec<_> =
        client.generations(&"e".parse().unwrap()).try_collect().await.unwrap();
    let priors: Vec<_> = client.priors().try_collect().await.unwrap();
    let environments: Vec<_> = client.training_environments().try_collect().await.unwrap();
    assert_eq!((generations.len(), priors.len(), environments.len()), (0, 0, 0));
    let expected = [
        "/v1/evolutions?page_size=50&state=failed",
        "/v1/evolutions?page_size=50&page_token=t&state=failed",
        "/v1/evolutions/e/generations",
        "/v1/evolutions/e/generations?page_token=t",
        "/v1/priors?page_size=500",
        "/v1/priors?page_size=500&page_token=t",
        "/v1/environments?page_size=100",
        "/v1/environments?page_size=100&page_token=t",
    ];
    assert_eq!(*seen.lock().unwrap(), expected);
}

#[tokio::test]
async fn a_page_that_leads_to_itself_is_refused() {
    let page = r#"{"priors": [], "next_page_token": "t"}"#;
    let asked = Arc::new(AtomicUsize::new(0));
    let server = {
        let asked = Arc::clone(&asked);
        Server::start(move |_| {
            // A client that follows it for ever fails here rather than hangs.
            assert!(asked.fetch_add(1, Ordering::SeqCst) < 2);
            async move { json(StatusCode::OK, page) }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap();
    let error = client.priors().try_collect::<Vec<_>>().await.unwrap_err();
    assert!(error.to_string().contains("page t is followed by itself"), "{error}");
}

#[tokio::test]
async fn a_figure_is_svg_or_an_error() {
    let server = Server::start(|request| async move {
        match request.uri().path() {
            "/v1/evolutions/evolution-1/figures/time" => {
                assert_eq!(request.headers()["accept"], "image/svg+xml");
                answer(
                    StatusCode::OK,
                    "image/svg+xml",
                    "<svg xmlns=\"http://www.w3.org/2000/svg\"/>",
                )
            }
            "/v1/evolutions/evolution-2/figures/time" => json(StatusCode::OK, "{}"),
            _ => json(StatusCode::BAD_REQUEST, PRECONDITION),
        }
    })
    .await;
    let client = Client::new(&server.url).unwrap();
    let figure = async |id: &str| client.figure(&id.parse().unwrap(), Figure::Time).await;
    assert!(figure("evolution-1").await.unwrap().starts_with("<svg"));
    assert!(matches!(figure("evolution-2").await.unwrap_err(), Error::Protocol { .. }));
    assert_eq!(figure("evolution-3").await.unwrap_err().status(), Some(Status::FailedPrecondition));
}

#[tokio::test]
async fn every_method_asks_its_route() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            let if_match =
                request.headers().get("if-match").map(|it| it.to_str().unwrap().to_owned());
            let line = format!(
                "{} {} {}",
                request.method(),
                request.uri().path(),
                if_match.unwrap_or_default()
            );
            seen.lock().unwrap().push(line);
            async { json(StatusCode::BAD_REQUEST, PRECONDITION) }
        })
        .await
    };
    let client = Client::new(&server.url).unwrap().if_match("\"7\"");
    let (prior, environment, evolution) =
        ("p".parse().unwrap(), "e".parse().unwrap(), "evolution-1".parse().unwrap());
    let training = training::Spec::read(br#"{"slip": "hard", "link": "bad"}"#).unwrap();
    let statuses = [
        client.put_prior(&prior, &prior::Spec::default()).await.err(),
        client.get_prior(&prior).await.err(),
        client.delete_prior(&prior).await.err(),
        client.put_training_environment(&environment, &training).await.err(),
        client.get_training_environment(&environment).await.err(),
        client.delete_training_environment(&environment).await.err(),
        client.job::<EvolutionKind>(&evolution).await.err(),
        client.cancel::<EvolutionKind>(&evolution).await.err(),
        client.remove::<EvolutionKind>(&evolution).await.err(),
    ]
    .map(|error| error.and_then(|error| error.status()));
    assert_eq!(statuses, [Some(Status::FailedPrecondition); 9]);
    let expected = [
        "PUT /v1/priors/p \"7\"",
        "GET /v1/priors/p ",
        "DELETE /v1/priors/p \"7\"",
        "PUT /v1/environments/e \"7\"",
        "GET /v1/environments/e ",
        "DELETE /v1/environments/e \"7\"",
        "GET /v1/evolutions/evolution-1 ",
        "POST /v1/evolutions/evolution-1/cancel ",
        "DELETE /v1/evolutions/evolution-1 \"7\"",
    ];
    assert_eq!(*seen.lock().unwrap(), expected);
}
