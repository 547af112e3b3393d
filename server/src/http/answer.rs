//! Successful responses.

use crate::http::etag;
use axum::body::Body;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

const JSON: HeaderValue = HeaderValue::from_static("application/json");

/// `content` as JSON. A number that cannot be said (NaN) makes an INTERNAL error, never a `null`.
pub(crate) fn json(code: StatusCode, content: &impl Serialize) -> Response {
    match serde_json::to_vec(content) {
        Ok(json) => {
            let mut response = Response::new(Body::from(json));
            *response.status_mut() = code;
            response.headers_mut().insert(header::CONTENT_TYPE, JSON);
            response
        }
        Err(error) => {
            tracing::error!(%error, "an answer could not be written");
            crate::http::failure::internal("the answer could not be written").into_response()
        }
    }
}

/// The same with its version.
pub(crate) fn versioned(code: StatusCode, etag: &str, content: &impl Serialize) -> Response {
    let mut response = json(code, content);
    if let Ok(value) = HeaderValue::from_str(&etag::quoted(etag)) {
        response.headers_mut().insert(header::ETAG, value);
    }
    response
}

/// Nothing to say.
pub(crate) fn nothing() -> Response {
    StatusCode::NO_CONTENT.into_response()
}
