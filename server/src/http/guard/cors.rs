//! What a page of `--cors-origin` may ask and see.
//!
//! Small enough to stand here: the methods of an answer are those of its path, which the router knows, and the origin
//! has been judged already.

use axum::extract::Request;
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};

/// The headers that a request may have and no form could send.
const REQUEST_HEADERS: HeaderValue = HeaderValue::from_static(
    "authorization, content-type, grpc-timeout, idempotency-key, if-match, if-none-match, last-event-id, x-umwelt-request",
);

/// The headers of an answer that a page may read beside the usual ones.
const RESPONSE_HEADERS: HeaderValue =
    HeaderValue::from_static("allow, etag, location, retry-after, www-authenticate");

/// Seconds for which a browser need not ask again: no route changes its methods while the server runs.
const MAX_AGE: HeaderValue = HeaderValue::from_static("600");

/// Whether a browser asks what it may ask.
pub(super) fn is_preflight(request: &Request) -> bool {
    request.method() == Method::OPTIONS
        && request.headers().contains_key(header::ACCESS_CONTROL_REQUEST_METHOD)
}

/// What may be asked at a path, from what the router says of OPTIONS there: which methods there are instead.
pub(super) fn answer_preflight(routed: Response) -> Response {
    let allow = routed.headers().get(header::ALLOW).cloned();
    let Some(methods) = allow.filter(|_| routed.status() == StatusCode::METHOD_NOT_ALLOWED) else {
        return routed;
    };
    let mut response = StatusCode::NO_CONTENT.into_response();
    let headers = response.headers_mut();
    headers.insert(header::ACCESS_CONTROL_ALLOW_METHODS, methods);
    headers.insert(header::ACCESS_CONTROL_ALLOW_HEADERS, REQUEST_HEADERS);
    headers.insert(header::ACCESS_CONTROL_MAX_AGE, MAX_AGE);
    response
}

/// Lets the `page` read the answer; and says that answers differ where pages may differ.
pub(super) fn mark(page: Option<HeaderValue>, response: &mut Response) {
    let headers = response.headers_mut();
    headers.append(header::VARY, HeaderValue::from_static("Origin"));
    if let Some(page) = page {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, page);
        headers.insert(header::ACCESS_CONTROL_EXPOSE_HEADERS, RESPONSE_HEADERS);
    }
}
