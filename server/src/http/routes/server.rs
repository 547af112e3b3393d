//! The server itself: alive, ready, and the contract.

use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::resource::failure::draining;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use umwelt_api::health::Health;

const VERSION: &str = env!("CARGO_PKG_VERSION");

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
    ([(header::CONTENT_TYPE, "application/json")], umwelt_api::DOCUMENT).into_response()
}
