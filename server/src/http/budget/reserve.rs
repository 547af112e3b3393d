//! What a connection beyond the limit is still served: the stop, and whether the server is well.

use crate::http::guard;
use crate::resource::failure;
use axum::Router;
use axum::extract::Request;
use axum::http::{HeaderValue, Method, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use umwelt_api::endpoint::{HEALTH, Operation, READINESS, STOP_ALL, STOP_ROBOT};

/// `router` for the places that are reserved: everything else is told that there are `limit` connections already.
pub(crate) fn reserved(router: Router, limit: usize) -> Router {
    router.layer(middleware::from_fn(move |request: Request, next: Next| async move {
        let mut response = if is_reserved(request.method(), request.uri().path()) {
            next.run(request).await
        } else {
            failure::limit_reached("connections", limit).into_response()
        };
        guard::mark(&mut response);
        leave(&mut response);
        response
    }))
}

/// One request each, so that the place is free for the next (HTTP/1.1; there is no such header in HTTP/2).
fn leave(response: &mut Response) {
    response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
}

/// Whether a request is one for which places are reserved: a stop, of one or of all robots, health or readiness.
fn is_reserved(method: &Method, path: &str) -> bool {
    let is = |operation: Operation| operation.matches(path);
    match *method {
        Method::POST => is(STOP_ALL.operation()) || is(STOP_ROBOT.operation()),
        Method::GET | Method::HEAD => is(HEALTH.operation()) || is(READINESS.operation()),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_reserved_for_stop_and_health_alone() {
        for path in ["/v1/stop", "/v1/robots/r1/stop"] {
            assert!(is_reserved(&Method::POST, path), "{path}");
            assert!(!is_reserved(&Method::GET, path), "{path}");
        }
        for path in ["/healthz", "/readyz"] {
            assert!(is_reserved(&Method::GET, path), "{path}");
            assert!(!is_reserved(&Method::POST, path), "{path}");
        }
        for path in ["/v1/resume", "/v1/robots/r1/step", "/v1/robots/a/b/stop", "/v1/robots/stop"] {
            assert!(!is_reserved(&Method::POST, path), "{path}");
        }
    }
}
