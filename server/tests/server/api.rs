//! How the tests call the server.

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, Request, header};
use http_body_util::BodyExt;
use serde_json::{Value, json};
use std::sync::Arc;
use tower::ServiceExt;
use umwelt_server::store::MemoryStore;
use umwelt_server::{Config, Server, Store};

/// A server that is called without a connection.
#[derive(Clone)]
pub(crate) struct Api(pub(crate) Router);

/// What came back.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    pub(crate) code: u16,
    pub(crate) headers: HeaderMap,
    pub(crate) bytes: Vec<u8>,
}

/// A configuration that takes a free port.
pub(crate) fn config() -> Config {
    Config { listen: ([127, 0, 0, 1], 0).into(), ..Config::default() }
}

impl Api {
    pub(crate) async fn new() -> Self {
        Self::with(config(), Arc::new(MemoryStore::default())).await
    }

    pub(crate) async fn with(config: Config, store: Arc<dyn Store>) -> Self {
        Self(Server::with_store(config, store).await.unwrap().router())
    }

    /// A server with robot `r` that has been told to drive 0.2 m.
    pub(crate) async fn with_robot() -> Self {
        let api = Self::new().await;
        api.add("r").await;
        api
    }

    pub(crate) async fn add(&self, robot: &str) {
        assert_eq!(self.put(&format!("/v1/robots/{robot}"), json!({})).await.code, 201);
        let task = json!({"waypoints": [{"x_m": 0.2, "y_m": 0.0}]});
        assert_eq!(self.put(&format!("/v1/robots/{robot}/task"), task).await.code, 201);
    }

    /// Sends what need not name the server as its host.
    pub(crate) async fn send(&self, mut request: Request<Body>) -> Answer {
        let host = HeaderValue::from_static("localhost");
        request.headers_mut().entry(header::HOST).or_insert(host);
        self.send_as_it_is(request).await
    }

    /// Sends this and nothing else.
    pub(crate) async fn send_as_it_is(&self, request: Request<Body>) -> Answer {
        let (parts, body) = self.0.clone().oneshot(request).await.unwrap().into_parts();
        let bytes = body.collect().await.unwrap().to_bytes().to_vec();
        Answer { code: parts.status.as_u16(), headers: parts.headers, bytes }
    }

    /// A request with extra headers and any body.
    pub(crate) async fn call(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: impl Into<Body>,
    ) -> Answer {
        let mut request = Request::builder().method(method).uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        self.send(request.body(body.into()).unwrap()).await
    }

    pub(crate) async fn get(&self, path: &str) -> Answer {
        self.call("GET", path, &[], Body::empty()).await
    }

    pub(crate) async fn delete(&self, path: &str) -> Answer {
        self.call("DELETE", path, &[], Body::empty()).await
    }

    pub(crate) async fn post(&self, path: &str) -> Answer {
        self.call("POST", path, &[], Body::empty()).await
    }

    pub(crate) async fn put(&self, path: &str, body: Value) -> Answer {
        self.call("PUT", path, &[JSON], body.to_string()).await
    }

    /// A step of robot `r`.
    pub(crate) async fn step(&self, body: impl ToString) -> Answer {
        self.call("POST", "/v1/robots/r/step", &[JSON], body.to_string()).await
    }

    /// Everything that is known of robot `r`, to see that nothing changed.
    pub(crate) async fn state(&self) -> [Value; 3] {
        [
            self.get("/v1/robots/r").await.json(),
            self.get("/v1/robots/r/task").await.json(),
            self.get("/v1/robots/r/environment").await.json(),
        ]
    }
}

impl Answer {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.bytes).unwrap_or_default()
    }

    /// The name of the problem and the first reason; fails where the body is not the one for errors.
    pub(crate) fn problem(&self) -> (String, String) {
        let text = String::from_utf8_lossy(&self.bytes);
        assert_eq!(self.headers.get("content-type").unwrap(), "application/json", "{text}");
        let body: umwelt_api::ErrorBody = serde_json::from_slice(&self.bytes).expect(&text);
        assert_eq!(body.error.code, self.code, "{text}");
        assert!(!body.error.message.is_empty());
        let reason = body.error.details.first().map(|detail| detail.reason.clone());
        (body.error.status.name().to_owned(), reason.unwrap_or_default())
    }

    /// The fields that are wrong.
    pub(crate) fn fields(&self) -> Vec<String> {
        let details = self.json()["error"]["details"].as_array().cloned().unwrap_or_default();
        details.iter().map(|detail| detail["field"].as_str().unwrap().to_owned()).collect()
    }
}

pub(crate) const JSON: (&str, &str) = ("content-type", "application/json");

/// A step with one pose, taken 0.1 s before it was sent.
pub(crate) fn step(epoch: u64, sequence: u64, sent: f64, x: f64) -> Value {
    let pose = json!({"x_m": x, "y_m": 0.0, "heading_rad": 0.0, "taken_s": sent - 0.1});
    json!({"epoch": epoch, "sequence": sequence, "sent_s": sent, "observations": [pose]})
}
