//! One document: its name, and what is answered to whoever asks for it.

use crate::http::answer;
use crate::store::JobId;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use std::sync::Arc;
use umwelt_api::endpoint::BYTES;

/// Which document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Name {
    /// Of which job.
    pub(crate) job: JobId,
    /// Which of the job's.
    pub(crate) what: &'static str,
    /// How far the job was: what has ended never changes.
    pub(crate) state: u64,
}

/// A document that has been made; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    pub(super) bytes: Bytes,
    pub(super) etag: Arc<str>,
    pub(super) media_type: &'static str,
}

impl Document {
    /// The answer to a request with these headers: not the document itself where they say that it is known.
    pub(crate) fn answer(&self, headers: &HeaderMap) -> Response {
        let quoted = answer::quoted(&self.etag);
        let mut response = if is_known(headers, &quoted) {
            StatusCode::NOT_MODIFIED.into_response()
        } else {
            ([(header::CONTENT_TYPE, self.media_type(headers))], self.bytes.clone()).into_response()
        };
        if let Ok(etag) = HeaderValue::from_str(&quoted) {
            response.headers_mut().insert(header::ETAG, etag);
        }
        response
    }

    /// What it is called: by its own media type, or as bytes by who takes nothing but these.
    fn media_type(&self, headers: &HeaderMap) -> &'static str {
        let accepted = headers.get(header::ACCEPT).map(HeaderValue::as_bytes);
        if accepted == Some(BYTES.as_bytes()) { BYTES } else { self.media_type }
    }
}

/// Whether `If-None-Match` names this version (RFC 9110, 13.1.2: any of a list, weak or not).
fn is_known(headers: &HeaderMap, quoted: &str) -> bool {
    let lists = headers.get_all(header::IF_NONE_MATCH).iter();
    let mut named = lists.filter_map(|list| list.to_str().ok()).flat_map(|list| list.split(','));
    named.any(|name| {
        let name = name.trim();
        name == "*" || name.strip_prefix("W/").unwrap_or(name) == quoted
    })
}
