//! Responses: what succeeds, and what fails, with one body for everything that goes wrong.

use crate::resource::failure::{self, Failure};
use axum::body::Body;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use umwelt_api::problem::{ErrorBody, Status};

/// Seconds to wait before asking again, where waiting helps.
const RETRY_AFTER: HeaderValue = HeaderValue::from_static("1");

/// How to say who asks.
const BEARER: HeaderValue = HeaderValue::from_static("Bearer");

/// What a route returns.
pub(crate) type Result<T = Response, E = Failure> = std::result::Result<T, E>;

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
            tracing::error!(%error, "cannot write answer");
            failure::internal("the answer could not be written").into_response()
        }
    }
}

/// The same with its version.
pub(crate) fn versioned(code: StatusCode, etag: &str, content: &impl Serialize) -> Response {
    let mut response = json(code, content);
    if let Ok(value) = HeaderValue::from_str(&quoted(etag)) {
        response.headers_mut().insert(header::ETAG, value);
    }
    response
}

/// Nothing to say.
pub(crate) fn nothing() -> Response {
    StatusCode::NO_CONTENT.into_response()
}

/// The form of a version in an `ETag` header.
pub(crate) fn quoted(etag: &str) -> String {
    format!("\"{etag}\"")
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let (problem, code) = self.into_parts();
        let status = problem.status;
        let mut body = ErrorBody::from(problem);
        body.error.code = code;
        let code = StatusCode::from_u16(code).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = json(code, &body);
        if matches!(status, Status::ResourceExhausted | Status::Unavailable) {
            response.headers_mut().insert(header::RETRY_AFTER, RETRY_AFTER);
        }
        if status == Status::Unauthenticated {
            response.headers_mut().insert(header::WWW_AUTHENTICATE, BEARER);
        }
        response
    }
}
