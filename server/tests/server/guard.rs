//! Who may ask at all: pages of other origins, foreign hosts, forms, the token. The routes come from the contract, so
//! that one of tomorrow is looked at too.

use crate::api::{Api, JSON, config};
use axum::body::Body;
use axum::http::{Method, Request};
use serde_json::Value;
use std::sync::Arc;
use umwelt_server::Config;
use umwelt_server::store::MemoryStore;

/// An operation of the contract, its names filled in.
struct Operation {
    method: String,
    path: String,
    takes_body: bool,
}

fn operations() -> Vec<Operation> {
    let document: Value = serde_json::from_str(umwelt_api::DOCUMENT).unwrap();
    let mut operations = Vec::new();
    for (template, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            operations.push(Operation {
                method: method.to_uppercase(),
                path: named(template),
                takes_body: operation.get("requestBody").is_some(),
            });
        }
    }
    assert!(operations.len() > 40, "{}", operations.len());
    operations
}

fn changes() -> Vec<Operation> {
    let changes: Vec<_> = operations().into_iter().filter(|it| it.method != "GET").collect();
    assert!(changes.len() > 15, "{}", changes.len());
    changes
}

/// A path whose robot there is; no one else need be there.
fn named(template: &str) -> String {
    let names = [
        ("{robot}", "r"),
        ("{prior}", "wet"),
        ("{environment}", "hall"),
        ("{evolution}", "evolution-1"),
        ("{comparison}", "comparison-1"),
        ("{figure}", "fitness"),
    ];
    names.iter().fold(template.to_owned(), |path, (name, value)| path.replace(name, value))
}

/// How a request names its host: in HTTP/1.1 by a header, in HTTP/2 by its target.
#[derive(Clone, Copy, Debug)]
enum Form {
    Http1,
    Http2,
}

const FORMS: [Form; 2] = [Form::Http1, Form::Http2];

type Headers = [(&'static str, &'static str)];

async fn send(
    api: &Api,
    form: Form,
    operation: &Operation,
    host: &str,
    headers: &Headers,
) -> (u16, String) {
    let Operation { method, path, takes_body } = operation;
    let mut request = match form {
        Form::Http1 => Request::builder().uri(path).header("host", host),
        Form::Http2 => Request::builder().uri(format!("http://{host}{path}")),
    };
    request = request.method(Method::from_bytes(method.as_bytes()).unwrap());
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    let body = if *takes_body { Body::from("{}") } else { Body::empty() };
    let answer = api.send_as_it_is(request.body(body).unwrap()).await;
    let reason = if answer.code >= 400 { answer.problem().1 } else { String::new() };
    (answer.code, reason)
}

/// All that the attacked routes could change.
async fn everything(api: &Api) -> Vec<Value> {
    let mut all = api.state().await.to_vec();
    for path in
        ["/v1/robots", "/v1/priors", "/v1/environments", "/v1/evolutions", "/v1/comparisons"]
    {
        all.push(api.get(path).await.json());
    }
    all
}

const FOREIGN: (&str, &str) = ("origin", "http://evil.example");
const OWN: (&str, &str) = ("origin", "http://localhost:8080");
const CROSS_SITE: (&str, &str) = ("sec-fetch-site", "cross-site");
const TEXT: (&str, &str) = ("content-type", "text/plain");
const FORM: (&str, &str) = ("content-type", "application/x-www-form-urlencoded");
const PROOF: (&str, &str) = ("x-umwelt-request", "1");

/// Guards against: someone opens a web page, and a robot that was stopped drives.
#[tokio::test]
async fn what_a_foreign_page_asks_for_is_refused_and_changes_nothing() {
    let api = Api::with_robot().await;
    assert_eq!(api.post("/v1/stop").await.code, 200);
    let before = everything(&api).await;
    let (own, evil) = ("localhost:8080", "evil.example:8080");
    let attacks: [(&str, &Headers, &str); 13] = [
        (own, &[FOREIGN], "FOREIGN_ORIGIN"),
        (own, &[FOREIGN, JSON, PROOF], "FOREIGN_ORIGIN"),
        (own, &[FOREIGN, TEXT], "FOREIGN_ORIGIN"),
        (own, &[FOREIGN, FORM], "FOREIGN_ORIGIN"),
        (own, &[("origin", "null"), JSON], "FOREIGN_ORIGIN"),
        (own, &[("origin", "http://localhost:3000"), JSON], "FOREIGN_ORIGIN"),
        (own, &[CROSS_SITE, JSON], "FOREIGN_ORIGIN"),
        (own, &[("sec-fetch-site", "same-site"), JSON], "FOREIGN_ORIGIN"),
        (own, &[OWN, CROSS_SITE, JSON], "FOREIGN_ORIGIN"),
        (own, &[OWN, TEXT], "FORM_REQUEST"),
        (own, &[("sec-fetch-mode", "navigate"), FORM], "FORM_REQUEST"),
        (evil, &[JSON], "FOREIGN_HOST"),
        (evil, &[("origin", "http://evil.example:8080"), JSON], "FOREIGN_HOST"),
    ];
    for operation in changes() {
        for (host, headers, reason) in attacks {
            for form in FORMS {
                let (code, said) = send(&api, form, &operation, host, headers).await;
                let what = format!("{} {} {host} {headers:?}", operation.method, operation.path);
                assert_eq!((code, said.as_str()), (403, reason), "{what} {form:?}");
            }
        }
    }
    assert_eq!(everything(&api).await, before);
}

/// Guards against: a robot cannot be stopped since the request lacks a header.
#[tokio::test]
async fn programs_and_own_pages_may_ask_for_everything() {
    let programs: [&Headers; 2] = [&[JSON], &[JSON, ("user-agent", "curl/8"), ("accept", "*/*")]];
    let pages: [&Headers; 4] = [
        &[OWN, JSON],
        &[OWN, JSON, PROOF, ("sec-fetch-site", "same-origin")],
        &[("sec-fetch-site", "none"), ("sec-fetch-mode", "navigate"), JSON],
        &[("origin", "https://localhost:8080"), JSON],
    ];
    for headers in programs.into_iter().chain(pages) {
        for form in FORMS {
            let api = Api::with_robot().await;
            for operation in operations().iter().filter(|it| !it.path.ends_with("/events")) {
                let (code, said) = send(&api, form, operation, "localhost:8080", headers).await;
                let what = format!("{} {} {headers:?}", operation.method, operation.path);
                assert!(code != 401 && code != 403, "{what} {form:?}: {code} {said}");
            }
        }
    }
    let api = Api::with_robot().await;
    let host = ("host", "localhost:8080");
    for (path, headers) in [("/v1/stop", &[][..]), ("/v1/robots/r/stop", &[host, OWN, PROOF])] {
        assert_eq!(api.call("POST", path, headers, Body::empty()).await.code, 200, "{path}");
    }
}

#[tokio::test]
async fn a_foreign_page_reads_nothing_either() {
    let api = Api::with_robot().await;
    for operation in operations().iter().filter(|it| it.method == "GET") {
        for form in FORMS {
            for (host, headers) in [
                ("localhost", &[FOREIGN][..]),
                ("localhost", &[CROSS_SITE]),
                ("localhost", &[("origin", "null")]),
                ("evil.example", &[]),
            ] {
                let (code, _) = send(&api, form, operation, host, headers).await;
                assert_eq!(code, 403, "{} {host} {headers:?}", operation.path);
            }
        }
    }
    let answer = api.call("GET", "/v1/robots", &[FOREIGN], Body::empty()).await;
    assert!(answer.headers.get("access-control-allow-origin").is_none());
    assert_eq!(answer.json()["error"]["status"], "PERMISSION_DENIED");
    let remedy = answer.json()["error"]["details"][0]["remedy"].to_string();
    assert!(remedy.contains("--cors-origin"), "{remedy}");
    for host in [None, Some(["localhost", "localhost"])] {
        let mut request = Request::builder().uri("/v1/robots");
        for host in host.iter().flatten() {
            request = request.header("host", *host);
        }
        let answer = api.send_as_it_is(request.body(Body::empty()).unwrap()).await;
        assert_eq!((answer.code, answer.fields()), (400, vec!["Host".to_owned()]));
    }
}

const DASHBOARD: (&str, &str) = ("origin", "http://localhost:3000");

async fn with_dashboard() -> Api {
    let cors_origins = vec!["http://localhost:3000".parse().unwrap()];
    let config =
        Config { cors_origins, allow_hosts: vec!["robots.example".parse().unwrap()], ..config() };
    let api = Api::with(config, Arc::new(MemoryStore::default())).await;
    api.add("r").await;
    api
}

#[tokio::test]
async fn a_page_of_ones_own_is_told_what_each_path_takes() {
    let api = with_dashboard().await;
    let asks = ("access-control-request-method", "PUT");
    let document: Value = serde_json::from_str(umwelt_api::DOCUMENT).unwrap();
    for (template, item) in document["paths"].as_object().unwrap() {
        let path = named(template);
        let answer =
            api.call("OPTIONS", &path, &[DASHBOARD, CROSS_SITE, asks], Body::empty()).await;
        assert_eq!(answer.code, 204, "{path}");
        assert_eq!(answer.headers["access-control-allow-origin"], DASHBOARD.1);
        let said = answer.headers["access-control-allow-methods"].to_str().unwrap();
        let said: Vec<&str> = said.split(',').map(str::trim).collect();
        for method in item.as_object().unwrap().keys() {
            assert!(said.contains(&method.to_uppercase().as_str()), "{path}: {method} in {said:?}");
        }
        let allowed = answer.headers["access-control-allow-headers"].to_str().unwrap();
        for header in [
            "content-type",
            "if-match",
            "idempotency-key",
            "last-event-id",
            "grpc-timeout",
            "authorization",
            "x-umwelt-request",
        ] {
            assert!(allowed.contains(header), "{header}");
        }
        let answer = api.call("OPTIONS", &path, &[FOREIGN, asks], Body::empty()).await;
        assert_eq!(answer.code, 403, "{path}");
        assert!(answer.headers.get("access-control-allow-origin").is_none());
    }
    let nowhere = api.call("OPTIONS", "/v1/nowhere", &[DASHBOARD, asks], Body::empty()).await;
    assert_eq!(nowhere.code, 404);
}

#[tokio::test]
async fn a_page_of_ones_own_reads_answers_and_errors() {
    let api = with_dashboard().await;
    for (method, path, code) in [
        ("GET", "/v1/robots/r", 200),
        ("GET", "/v1/robots/nobody", 404),
        ("PUT", "/v1/robots/r", 200),
        ("TRACE", "/v1/robots/r", 405),
        ("POST", "/v1/stop", 200),
    ] {
        let body = if method == "PUT" { "{}" } else { "" };
        let answer = api.call(method, path, &[DASHBOARD, CROSS_SITE, JSON], body).await;
        assert_eq!(answer.code, code, "{method} {path}");
        assert_eq!(answer.headers["access-control-allow-origin"], DASHBOARD.1, "{method} {path}");
        assert!(answer.headers["vary"].to_str().unwrap().contains("Origin"));
        assert!(answer.headers["access-control-expose-headers"].to_str().unwrap().contains("etag"));
    }
    let other = api.get("/v1/robots/r").await;
    assert_eq!(other.headers["vary"], "Origin", "a cache must not give it to a page");
    assert!(other.headers.get("access-control-allow-origin").is_none());
    let form = api.call("POST", "/v1/stop", &[DASHBOARD, CROSS_SITE, TEXT], "").await;
    assert_eq!(form.problem().1, "FORM_REQUEST");
    let named = api.call("GET", "/v1/robots", &[("host", "Robots.Example:80")], "").await;
    assert_eq!(named.code, 200);
}

#[tokio::test]
async fn every_answer_is_what_it_says_and_is_not_kept() {
    let api = Api::with_robot().await;
    for (path, headers) in [
        ("/v1/robots/r", &[][..]),
        ("/v1/robots/nobody", &[]),
        ("/v1/nowhere", &[]),
        ("/openapi.json", &[]),
        ("/v1/robots/r", &[FOREIGN]),
    ] {
        let answer = api.call("GET", path, headers, "").await;
        assert_eq!(answer.headers["x-content-type-options"], "nosniff", "{path}");
        assert_eq!(answer.headers["cache-control"], "no-store", "{path}");
        assert!(answer.headers.get("x-accel-buffering").is_none(), "{path}");
    }
}

const SECRET: &str = "0123456789abcdef-test";
const BEARER: (&str, &str) = ("authorization", "Bearer 0123456789abcdef-test");

#[tokio::test]
async fn with_a_token_nothing_is_open_but_liveness() {
    let cors_origins = vec!["http://localhost:3000".parse().unwrap()];
    let config = Config { token: Some(SECRET.parse().unwrap()), cors_origins, ..config() };
    let api = Api::with(config, Arc::new(MemoryStore::default())).await;
    for operation in operations().iter().filter(|it| !it.path.ends_with("/events")) {
        let what = format!("{} {}", operation.method, operation.path);
        let liveness = operation.path == "/healthz";
        for (headers, reason) in [
            (&[JSON][..], "TOKEN_MISSING"),
            (&[JSON, ("authorization", "Bearer 0123456789abcdef-tesT")], "TOKEN_WRONG"),
            (&[JSON, ("authorization", "Basic MDEyMzQ1Njc4OWFiY2RlZg==")], "TOKEN_MISSING"),
        ] {
            let said = send(&api, Form::Http1, operation, "localhost", headers).await;
            let expected = if liveness { (200, "") } else { (401, reason) };
            assert_eq!((said.0, said.1.as_str()), expected, "{what}");
        }
        let right = send(&api, Form::Http2, operation, "localhost", &[JSON, BEARER]).await;
        assert_ne!(right.0, 401, "{what}");
    }
    let answer = api.get("/v1/robots").await;
    assert_eq!(answer.headers["www-authenticate"], "Bearer");
    let said = answer.json().to_string();
    assert!(said.contains("--token-file") && !said.contains(SECRET), "{said}");
    let asks = ("access-control-request-method", "POST");
    let preflight = api.call("OPTIONS", "/v1/stop", &[DASHBOARD, asks], "").await;
    assert_eq!(preflight.code, 204, "a browser asks before it sends the token");
    let denied = api.call("POST", "/v1/stop", &[DASHBOARD, JSON], "").await;
    assert_eq!(denied.code, 401);
    assert_eq!(denied.headers["access-control-allow-origin"], DASHBOARD.1, "the page may read why");
    for path in ["/v1/events", "/nowhere", "/healthz/"] {
        assert_eq!(api.get(path).await.code, 401, "{path}");
    }
    assert_eq!(api.post("/healthz").await.code, 401);
}
