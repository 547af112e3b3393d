//! Who may ask at all, before any route is reached.
//!
//! A web page that someone on this network opens can send requests to this server: it must not be able to do
//! anything. In this order a request
//! 1. names this server as its host ([`host`]): else a foreign name may lead here (DNS rebinding),
//! 2. comes from no page of another origin ([`origin`]) but those that the operator named,
//! 3. carries the secret where there is one ([`token`]),
//! 4. cannot have been sent by a form, where a page sent it and it changes something.
//!
//! Programs that are no browsers (agents, `umwelt`, curl) send neither `Origin` nor `Sec-Fetch-*`: to them only 1 and
//! 3 apply, so that a stop never lacks a header.

mod cors;
pub(crate) mod host;
pub(crate) mod origin;
mod token;

pub use host::HostName;
pub use origin::Origin;
pub use token::read_token;

use crate::resource::failure::Failure;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, Method, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use std::sync::Arc;
use umwelt_api::Token;
use umwelt_api::endpoint::{self, Method::Get, Scope};

/// Whom the guard lets through.
#[derive(Debug)]
pub(crate) struct Rules {
    /// The address that the server listens on.
    pub(crate) listen: IpAddr,
    /// Names by which it is called beside its address and `localhost`.
    pub(crate) hosts: Vec<HostName>,
    /// Whose pages may use it, beside its own.
    pub(crate) origins: Vec<Origin>,
    /// The secret that every request must carry, where there is one.
    pub(crate) token: Option<Token>,
}

/// Lets a request through or refuses it; marks every answer.
pub(crate) async fn check(
    State(rules): State<Arc<Rules>>,
    request: Request,
    next: Next,
) -> Response {
    let page = origin::allowed(&rules.origins, request.headers()).cloned();
    let is_preflight = page.is_some() && cors::is_preflight(&request);
    let mut response = match admit(&rules, &request, is_preflight) {
        Err(failure) => {
            tracing::debug!(reason = failure.message(), "request refused");
            failure.into_response()
        }
        Ok(()) => next.run(request).await,
    };
    if is_preflight {
        response = cors::answer_preflight(response);
    }
    if !rules.origins.is_empty() {
        cors::mark(page, &mut response);
    }
    mark(&mut response);
    response
}

fn admit(rules: &Rules, request: &Request, is_preflight: bool) -> Result<(), Failure> {
    let (headers, method) = (request.headers(), request.method());
    let own = host::check(rules.listen, &rules.hosts, request.uri(), headers)?;
    origin::check(&rules.origins, &own, method, headers)?;
    // A browser asks whether it may send a token before it sends it.
    if let Some(token) = rules.token.as_ref().filter(|_| !is_preflight && !is_open(request)) {
        token::check(token, headers)?;
    }
    origin::check_not_a_form(method, headers)
}

/// Whether a request needs no token: one that asks whether the server lives, since what restarts a dead server has none.
fn is_open(request: &Request) -> bool {
    let (method, path) = (request.method(), request.uri().path());
    let is_read = matches!(*method, Method::GET | Method::HEAD);
    let mut open = endpoint::all().filter(|operation| operation.scope == Scope::Open);
    open.any(|operation| is_read && operation.method == Get && operation.matches(path))
}

/// What every answer says: it is what its type says and nothing else, and it is not to be kept unless the route says
/// so. Proxies are to hand on a stream as it comes.
pub(crate) fn mark(response: &mut Response) {
    const NOSNIFF: HeaderValue = HeaderValue::from_static("nosniff");
    const NO_STORE: HeaderValue = HeaderValue::from_static("no-store");
    const UNBUFFERED: HeaderValue = HeaderValue::from_static("no");
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, NOSNIFF);
    headers.entry(header::CACHE_CONTROL).or_insert(NO_STORE);
    let kind = headers.get(header::CONTENT_TYPE);
    if kind.is_some_and(|kind| kind.as_bytes().starts_with(b"text/event-stream")) {
        headers.insert("x-accel-buffering", UNBUFFERED);
    }
}
