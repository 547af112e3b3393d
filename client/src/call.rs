//! One call: what is sent, and how the answer is read. No retry here.

use crate::error::{self, Error};
use bytes::{Bytes, BytesMut};
use reqwest::header::{
    ACCEPT, CONTENT_TYPE, HeaderMap, HeaderName, HeaderValue, IF_MATCH, IF_NONE_MATCH, LOCATION,
    RETRY_AFTER,
};
use reqwest::{Method, Response, Url};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;
use umwelt_api::IdempotencyKey;
use umwelt_api::problem::Problem;

/// Largest answer in bytes that is read: three times every trial of the largest comparison, 200 000 rows of some 100
/// bytes.
const MAX_ANSWER: usize = 64 << 20;

/// Largest refusal in bytes that is read: many problems at once, each with its value and remedy.
const MAX_REFUSAL: usize = 1 << 20;

/// The deadline as the server hears it: a number of at most eight digits and its unit.
pub(crate) const GRPC_TIMEOUT: HeaderName = HeaderName::from_static("grpc-timeout");

/// [`IdempotencyKey::HEADER`] in the lower case of HTTP/2.
const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");

/// What must hold of the resource that is written.
#[derive(Clone, Debug)]
pub(crate) enum Condition {
    /// Nothing.
    None,
    /// It has this etag.
    Version(Arc<str>),
    /// There is none yet.
    Absent,
}

/// A call to be sent, cheap to send again.
#[derive(Clone, Debug)]
pub(crate) struct Call {
    pub(crate) what: Arc<str>,
    pub(crate) method: Method,
    pub(crate) url: Url,
    pub(crate) body: Option<Bytes>,
    pub(crate) condition: Condition,
    /// Of a POST that creates: sent twice with it, it creates once.
    pub(crate) idempotency_key: Option<IdempotencyKey>,
    /// The media type of the answer.
    pub(crate) accept: &'static str,
    /// Time for all attempts together.
    pub(crate) allowed: Duration,
    pub(crate) deadline: Instant,
    /// How often it may still be sent again.
    pub(crate) retries_left: u32,
}

impl Call {
    /// A call with `allowed` time, of which none has passed.
    pub(crate) fn new(method: Method, url: Url, allowed: Duration, retries_left: u32) -> Self {
        Self {
            what: format!("{method} {url}").into(),
            method,
            url,
            body: None,
            condition: Condition::None,
            idempotency_key: None,
            accept: "application/json",
            allowed,
            deadline: Instant::now() + allowed,
            retries_left,
        }
    }

    /// The same call with a JSON body.
    pub(crate) fn with_json(mut self, body: &impl Serialize) -> Result<Self, Error> {
        let json = serde_json::to_vec(body).map_err(|error| Error::BadCall {
            what: self.what.as_ref().into(),
            why: format!("the body cannot be said in JSON: {error}"),
        })?;
        self.body = Some(json.into());
        Ok(self)
    }

    /// The time that is left, in whole milliseconds.
    pub(crate) fn left(&self) -> Duration {
        let left = self.deadline.saturating_duration_since(Instant::now());
        Duration::from_millis(left.as_millis() as u64)
    }

    fn headers(&self) -> Result<HeaderMap, Error> {
        let mut headers = HeaderMap::new();
        headers.insert(ACCEPT, HeaderValue::from_static(self.accept));
        headers.insert(GRPC_TIMEOUT, grpc_timeout(self.left()));
        if self.body.is_some() {
            headers.insert(CONTENT_TYPE, HeaderValue::from_static("application/json"));
        }
        if let Condition::Absent = self.condition {
            headers.insert(IF_NONE_MATCH, HeaderValue::from_static("*"));
        }
        if let Condition::Version(etag) = &self.condition {
            let value = HeaderValue::from_str(etag).map_err(|_| Error::BadCall {
                what: self.what.as_ref().into(),
                why: format!("{etag:?} cannot be an etag: use that of the resource as it was read"),
            })?;
            headers.insert(IF_MATCH, value);
        }
        if let Some(key) = &self.idempotency_key {
            let value = HeaderValue::from_str(key.as_str()).map_err(|error| Error::BadCall {
                what: self.what.as_ref().into(),
                why: format!("{key} cannot be an idempotency key: {error}"),
            })?;
            headers.insert(IDEMPOTENCY_KEY, value);
        }
        Ok(headers)
    }
}

/// Sends `call` once and reads the whole answer of a success.
///
/// # Errors
/// Whatever is no success: a problem, a failure of the transport, a passed deadline.
pub(crate) async fn send(http: reqwest::Client, call: Call) -> Result<Bytes, Error> {
    let mut request = http.request(call.method.clone(), call.url.clone()).headers(call.headers()?);
    if let Some(body) = &call.body {
        request = request.body(body.clone());
    }
    let exchange = async {
        let response = request.send().await.map_err(|error| error::transport(&call.what, error))?;
        body_of_success(&call.what, response, MAX_ANSWER).await
    };
    match tokio::time::timeout_at(call.deadline, exchange).await {
        Ok(answer) => answer,
        Err(_) => Err(error::late(&call.what, call.allowed)),
    }
}

/// Reads an answer.
///
/// # Errors
/// Where it is not what the contract says.
pub(crate) fn read<T: DeserializeOwned>(what: &str, answer: &[u8]) -> Result<T, Error> {
    serde_json::from_slice(answer).map_err(|error| Error::Protocol {
        what: what.into(),
        why: format!("the answer cannot be read: {error}"),
    })
}

/// The body of a success, of at most `limit` bytes; everything else as the error that it is.
pub(crate) async fn body_of_success(
    what: &str,
    response: Response,
    limit: usize,
) -> Result<Bytes, Error> {
    let response = refuse(what, response, limit.min(MAX_REFUSAL)).await?;
    body(what, response, limit).await
}

/// The response, if it is a success.
pub(crate) async fn success(what: &str, response: Response) -> Result<Response, Error> {
    refuse(what, response, MAX_REFUSAL).await
}

/// The response, if it is a success; the error that it is, of at most `limit` bytes, if it is none.
async fn refuse(what: &str, response: Response, limit: usize) -> Result<Response, Error> {
    let status = response.status();
    if status.is_success() {
        return Ok(response);
    }
    if status.is_redirection() {
        let to = response.headers().get(LOCATION).and_then(|to| to.to_str().ok()).unwrap_or("?");
        let why = format!("the server sends us on to {to} (HTTP {status}): use that address");
        return Err(Error::Protocol { what: what.into(), why });
    }
    let retry_after = retry_after(response.headers());
    let body = body(what, response, limit).await?;
    let problem = Problem::parse(status.as_u16(), &body);
    Err(Error::Problem { what: what.into(), problem, retry_after })
}

/// The body as it comes, never more than `limit` bytes of it: what is longer is given up at once.
async fn body(what: &str, mut response: Response, limit: usize) -> Result<Bytes, Error> {
    let mut body = BytesMut::new();
    while let Some(chunk) = response.chunk().await.map_err(|error| error::transport(what, error))? {
        if body.len() + chunk.len() > limit {
            let why = format!("the answer is longer than {} KiB: it is none of ours", limit >> 10);
            return Err(Error::Protocol { what: what.into(), why });
        }
        body.extend_from_slice(&chunk);
    }
    Ok(body.freeze())
}

/// The deadline in milliseconds; a longer one than eight digits can say is none to speak of.
pub(crate) fn grpc_timeout(left: Duration) -> HeaderValue {
    let millis = left.as_millis().min(99_999_999);
    // Digits and a letter are always a header value.
    HeaderValue::from_str(&format!("{millis}m")).unwrap_or(HeaderValue::from_static("99999999m"))
}

/// `Retry-After` in seconds; a date would need a common clock and counts as nothing said.
fn retry_after(headers: &HeaderMap) -> Option<Duration> {
    let seconds = headers.get(RETRY_AFTER)?.to_str().ok()?.trim().parse().ok()?;
    Some(Duration::from_secs(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deadline_is_said_in_eight_digits() {
        assert_eq!(grpc_timeout(Duration::from_millis(1500)), "1500m");
        assert_eq!(grpc_timeout(Duration::ZERO), "0m");
        assert_eq!(grpc_timeout(Duration::MAX), "99999999m");
    }

    #[test]
    fn the_key_goes_under_its_name() {
        assert!(IdempotencyKey::HEADER.eq_ignore_ascii_case(IDEMPOTENCY_KEY.as_str()));
    }

    #[test]
    fn retry_after_is_seconds_or_nothing() {
        let said = |value: &'static str| {
            retry_after(&HeaderMap::from_iter([(RETRY_AFTER, HeaderValue::from_static(value))]))
        };
        assert_eq!(said("3"), Some(Duration::from_secs(3)));
        assert_eq!(said("Wed, 21 Oct 2015 07:28:00 GMT"), None);
        assert_eq!(said("-1"), None);
        assert_eq!(retry_after(&HeaderMap::new()), None);
    }
}
