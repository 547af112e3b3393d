//! The server itself: alive, ready, and the contract.

use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::resource::failure::draining;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::LazyLock;
use umwelt_api::health::Health;

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The contract never changes while the server runs.
static CONTRACT: LazyLock<String> =
    LazyLock::new(|| serde_json::to_string(&umwelt_api::document()).unwrap_or_default());

pub(crate) async fn health() -> Response {
    answer::json(StatusCode::OK, &Health::ok(VERSION))
}

pub(crate) async fn readiness(State(app): State<App>) -> Result {
    if app.fleet.is_draining() {
        return Err(draining());
    }
    if let Some(fault) = app.keeper.fault() {
        return Err(fault.into());
    }
    Ok(answer::json(StatusCode::OK, &Health::ok(VERSION)))
}

pub(crate) async fn contract() -> Response {
    ([(header::CONTENT_TYPE, "application/json")], CONTRACT.as_str()).into_response()
}
