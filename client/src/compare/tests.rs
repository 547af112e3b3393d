//! What the methods send, and what they make of the answers.

use super::*;
use crate::test_server::{Server, answer, json};
use hyper::StatusCode;
use std::sync::{Arc, Mutex};
use umwelt_api::comparison::ComparisonKind;
use umwelt_api::problem::Status;

const PRECONDITION: &str =
    r#"{"error": {"code": 409, "status": "FAILED_PRECONDITION", "message": "m", "details": []}}"#;

/// A server that answers everything with FAILED_PRECONDITION, and the lines of what it was asked.
async fn refusing() -> (Server, Arc<Mutex<Vec<String>>>) {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let server = {
        let seen = Arc::clone(&seen);
        Server::start(move |request| {
            let accept = request.headers()["accept"].to_str().unwrap();
            let line = format!("{} {} {accept}", request.method(), request.uri());
            seen.lock().unwrap().push(line);
            async { json(StatusCode::BAD_REQUEST, PRECONDITION) }
        })
        .await
    };
    (server, seen)
}

#[tokio::test]
async fn every_method_asks_its_route_for_its_kind() {
    let (server, seen) = refusing().await;
    let client = Client::new(&server.url).unwrap();
    let id = "comparison-1".parse().unwrap();
    let statuses = [
        client.job::<ComparisonKind>(&id).await.err(),
        client.cancel::<ComparisonKind>(&id).await.err(),
        client.remove::<ComparisonKind>(&id).await.err(),
        client.comparison_figure(&id, Figure::Pareto).await.err(),
        client.comparison_trials(&id).await.err(),
        client.comparison_report(&id).await.err(),
    ]
    .map(|error| error.and_then(|error| error.status()));
    assert_eq!(statuses, [Some(Status::FailedPrecondition); 6]);
    let expected = [
        "GET /v1/comparisons/comparison-1 application/json",
        "POST /v1/comparisons/comparison-1/cancel application/json",
        "DELETE /v1/comparisons/comparison-1 application/json",
        "GET /v1/comparisons/comparison-1/figures/pareto image/svg+xml",
        "GET /v1/comparisons/comparison-1/trials.csv text/csv",
        "GET /v1/comparisons/comparison-1/report.md text/markdown",
    ];
    assert_eq!(*seen.lock().unwrap(), expected);
}

/// Guards against the page of some proxy, or columns in another order, taken for trials.
#[tokio::test]
async fn what_is_not_what_was_asked_for_is_refused() {
    const HEADER: &str = "environment,contender,trial,arrived,time_s,deviation_m,recognised_samples,covered_samples,samples";
    let server = Server::start(|request| async move {
        let path = request.uri().path();
        let text = match path {
            "/v1/comparisons/comparison-1/trials.csv" => format!("{HEADER},later\n"),
            "/v1/comparisons/comparison-2/trials.csv" => "contender,environment\n".to_owned(),
            _ if path.starts_with("/v1/comparisons/comparison-1/") => "# <svg ä/>".to_owned(),
            _ => "<html>please log in</html>".to_owned(),
        };
        answer(StatusCode::OK, "text/plain", &text)
    })
    .await;
    let client = Client::new(&server.url).unwrap();
    let (right, wrong) = ("comparison-1".parse().unwrap(), "comparison-2".parse().unwrap());
    assert!(client.comparison_trials(&right).await.unwrap().starts_with(HEADER));
    assert_eq!(client.comparison_report(&right).await.unwrap(), "# <svg ä/>");
    assert!(client.comparison_figure(&right, Figure::Time).await.is_ok());
    let trials = client.comparison_trials(&wrong).await.unwrap_err();
    assert!(trials.to_string().contains("the answer is no list of trials"), "{trials}");
    let figure = client.comparison_figure(&wrong, Figure::Time).await.unwrap_err();
    assert!(matches!(figure, Error::Protocol { .. }), "{figure}");
}
