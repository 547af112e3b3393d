//! What routes take out of a request, each checked once and refused in the one error body.

use crate::fleet::robot::Robot;
use crate::http::app::App;
use crate::http::budget::{Limits, Peer, Unread};
use crate::resource::failure::{self, Failure};
use crate::store::Kind;
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::{HeaderMap, StatusCode, header, request::Parts};
use bytes::Bytes;
use std::collections::HashMap;
use std::marker::PhantomData;
use std::str::FromStr;
use std::sync::Arc;
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_api::{Checked, EnvironmentId, InvalidId, PriorId, RobotId, body};

/// The `{robot}` of a path, valid but perhaps unknown.
pub(crate) struct Id(pub(crate) RobotId);

impl<S: Send + Sync> FromRequestParts<S> for Id {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Failure> {
        named(parts, state, "robot").await.map(Self)
    }
}

/// The `{prior}` of a path, valid but perhaps unknown.
pub(crate) struct Prior(pub(crate) PriorId);

impl<S: Send + Sync> FromRequestParts<S> for Prior {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Failure> {
        named(parts, state, "prior").await.map(Self)
    }
}

/// The `{environment}` of a path, valid but perhaps unknown.
pub(crate) struct Environment(pub(crate) EnvironmentId);

impl<S: Send + Sync> FromRequestParts<S> for Environment {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Failure> {
        named(parts, state, "environment").await.map(Self)
    }
}

/// The parameter of a path that holds an id.
pub(crate) async fn named<T: FromStr<Err = InvalidId>, S: Send + Sync>(
    parts: &mut Parts,
    state: &S,
    parameter: &str,
) -> Result<T, Failure> {
    let path = Path::<HashMap<String, String>>::from_request_parts(parts, state).await;
    let Some(text) = path.ok().and_then(|Path(mut path)| path.remove(parameter)) else {
        // Percent-encoded bytes that are no text.
        let remedy = "use 1 to 63 of A-Z, a-z, 0-9, -, _ and ., the first a letter or a digit";
        return Err(Problems::from(Detail::new(reason::INVALID_ID, parameter, (), remedy)).into());
    };
    Ok(text.parse()?)
}

/// The robot that a path names.
pub(crate) struct Known(pub(crate) Arc<Robot>);

impl FromRequestParts<App> for Known {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Failure> {
        let Id(id) = Id::from_request_parts(parts, app).await?;
        app.fleet.find(&id).map(Self).ok_or_else(|| {
            let unreadable = app.unreadable.failure(Kind::Robot, id.as_str());
            unreadable.unwrap_or_else(|| failure::no_such_robot(&id))
        })
    }
}

/// The body of a request, read and checked.
pub(crate) struct Body<B>(pub(crate) Checked<B>);

impl<B: body::Body + Send> FromRequest<App> for Body<B> {
    type Rejection = Failure;

    async fn from_request(request: Request, app: &App) -> Result<Self, Failure> {
        let Json { bytes, .. } = Json::<B>::from_request(request, app).await?;
        Ok(Self(B::read(&bytes)?))
    }
}

/// The JSON of a body, all of it here: what it means is asked with what the server knows.
pub(crate) struct Json<B> {
    pub(crate) bytes: Bytes,
    body: PhantomData<fn() -> B>,
}

impl<B: body::Body> FromRequest<App> for Json<B> {
    type Rejection = Failure;

    async fn from_request(request: Request, app: &App) -> Result<Self, Failure> {
        let (parts, body) = request.into_parts();
        expect_json(&parts.headers, B::MEDIA_TYPES)?;
        expect_plain(&parts.headers)?;
        let promised = axum::body::HttpBody::size_hint(&body).lower();
        if promised > B::MAX_BYTES as u64 {
            return Err(too_large(B::MAX_BYTES));
        }
        let peer = parts.extensions.get().copied().unwrap_or(Peer::IN_PROCESS);
        let read = app.bodies.read(peer, body, B::MAX_BYTES);
        let timeout = app.body_timeout;
        match tokio::time::timeout(timeout, read).await {
            Ok(Ok(bytes)) => Ok(Self { bytes, body: PhantomData }),
            Ok(Err(Unread::TooLarge)) => Err(too_large(B::MAX_BYTES)),
            Ok(Err(Unread::GivenUp(limits))) => Err(given_up(limits)),
            Ok(Err(Unread::Broken(error))) => {
                let message = format!("the body ended early: {error}");
                Err(Failure::new(Status::InvalidArgument, message))
            }
            Err(_) => {
                let message = format!("the body did not arrive within {} s", timeout.as_secs_f64());
                let remedy = "send the whole body at once";
                Err(Failure::new(Status::DeadlineExceeded, message)
                    .with(Detail::new(reason::BODY_TIMEOUT, "", (), remedy))
                    .under(StatusCode::REQUEST_TIMEOUT.as_u16()))
            }
        }
    }
}

fn given_up(Limits { overall, per_peer }: Limits) -> Failure {
    let message = format!(
        "bodies of {overall} bytes in all, {per_peer} of one address, are in flight, which is the limit, and this one had \
         been arriving the longest"
    );
    let remedy =
        "send the whole body at once, or start the server with a higher --max-bodies-mb-per-peer";
    Failure::new(Status::ResourceExhausted, message).with(Detail::new(
        reason::LIMIT_REACHED,
        "",
        per_peer,
        remedy,
    ))
}

fn too_large(limit: usize) -> Failure {
    let remedy = format!("send at most {limit} bytes");
    Failure::new(Status::InvalidArgument, "the body is too large")
        .with(Detail::new(reason::BODY_TOO_LARGE, "", (), remedy))
        .under(StatusCode::PAYLOAD_TOO_LARGE.as_u16())
}

/// A body is read as it comes: what is compressed is refused rather than taken for bad JSON.
fn expect_plain(headers: &HeaderMap) -> Result<(), Failure> {
    let given = headers.get_all(header::CONTENT_ENCODING).iter();
    let mut codings = given.flat_map(|value| value.to_str().unwrap_or("?").split(','));
    let Some(coding) = codings.find(|coding| !coding.trim().eq_ignore_ascii_case("identity"))
    else {
        return Ok(());
    };
    let remedy = "send the body as it is, without Content-Encoding";
    let detail =
        Detail::new(reason::UNSUPPORTED_ENCODING, "Content-Encoding", coding.trim(), remedy);
    Err(Failure::new(Status::InvalidArgument, "the body is compressed or encoded")
        .with(detail)
        .under(StatusCode::UNSUPPORTED_MEDIA_TYPE.as_u16()))
}

/// A body must say that it is JSON: then no web page of another origin can send it without asking.
fn expect_json(headers: &HeaderMap, known: &[&str]) -> Result<(), Failure> {
    let given = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    let essence = given.and_then(|text| text.split(';').next()).unwrap_or_default().trim();
    if known.iter().any(|known| essence.eq_ignore_ascii_case(known)) {
        return Ok(());
    }
    let remedy = "send Content-Type: application/json";
    let detail = Detail::new(reason::UNSUPPORTED_MEDIA_TYPE, "Content-Type", given, remedy);
    Err(Failure::new(Status::InvalidArgument, "the body is not declared as JSON")
        .with(detail)
        .under(StatusCode::UNSUPPORTED_MEDIA_TYPE.as_u16()))
}
