//! Under which condition a resource may be written: `If-Match` and `If-None-Match: *`.

use crate::http::failure::Failure;
use axum::extract::FromRequestParts;
use axum::http::{HeaderMap, HeaderName, StatusCode, header, request::Parts};
use umwelt_api::problem::{Detail, Status, reason};

/// What must hold of the resource before it is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Condition {
    /// It has one of these versions; `*` is any.
    versions: Option<Vec<String>>,
    /// There is none yet.
    absent: bool,
}

impl Condition {
    /// The condition that a request's headers set.
    fn read(headers: &HeaderMap) -> Result<Self, Failure> {
        let versions = values(headers, header::IF_MATCH)?;
        let absent = match values(headers, header::IF_NONE_MATCH)?.as_deref() {
            None => false,
            Some([any]) if any == "*" => true,
            Some(others) => {
                let remedy = "only * is understood: write only where there is nothing yet";
                let detail =
                    Detail::new(reason::MALFORMED, "If-None-Match", others.join(", "), remedy);
                return Err(Failure::new(Status::InvalidArgument, remedy).with(detail));
            }
        };
        Ok(Self { versions, absent })
    }

    /// Whether it holds of a resource whose version is `current`, none where there is no such resource.
    pub(crate) fn check(&self, current: Option<&str>) -> Result<(), Failure> {
        if self.absent && current.is_some() {
            let remedy = "leave If-None-Match out to write over it";
            return Err(Failure::new(Status::AlreadyExists, "it exists already")
                .with(Detail::new(reason::ALREADY_THERE, "If-None-Match", "*", remedy))
                .under(StatusCode::PRECONDITION_FAILED));
        }
        let Some(versions) = &self.versions else { return Ok(()) };
        let is_met = current.is_some_and(|current| {
            versions.iter().any(|version| version == "*" || version == current)
        });
        if is_met {
            return Ok(());
        }
        let message = match current {
            Some(current) => format!("its version is {current} now"),
            None => "it does not exist".to_owned(),
        };
        let remedy = "get it, decide anew, and send its etag in If-Match";
        let given = versions.join(", ");
        let detail = Detail::new(reason::ETAG_MISMATCH, "If-Match", given, remedy);
        let failure = Failure::new(Status::Aborted, message).with(detail);
        Err(failure.under(StatusCode::PRECONDITION_FAILED))
    }
}

/// The entries of a header that lists versions. Quotes may be left out, as in the `etag` of a body; a weak
/// version keeps its `W/` and so matches nothing, as RFC 9110 wants it.
fn values(headers: &HeaderMap, name: HeaderName) -> Result<Option<Vec<String>>, Failure> {
    let mut found = None;
    for value in headers.get_all(&name) {
        let Ok(text) = value.to_str() else {
            let detail = Detail::new(reason::MALFORMED, name.as_str(), (), "use ASCII");
            return Err(Failure::new(Status::InvalidArgument, "a header is no text").with(detail));
        };
        let entries: &mut Vec<String> = found.get_or_insert_default();
        entries.extend(text.split(',').map(|entry| unquoted(entry.trim()).to_owned()));
    }
    Ok(found)
}

fn unquoted(entry: &str) -> &str {
    entry.strip_prefix('"').and_then(|entry| entry.strip_suffix('"')).unwrap_or(entry)
}

impl<S: Sync> FromRequestParts<S> for Condition {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Failure> {
        Self::read(&parts.headers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(headers: &[(HeaderName, &str)], current: Option<&str>) -> bool {
        let headers = headers.iter().map(|(name, value)| (name.clone(), value.parse().unwrap()));
        Condition::read(&headers.collect()).unwrap().check(current).is_ok()
    }

    #[test]
    fn without_headers_everything_may_be_written() {
        assert!(holds(&[], None) && holds(&[], Some("a")));
    }

    #[test]
    fn if_match_wants_one_of_its_versions() {
        for given in ["\"a\"", "a", "\"b\", \"a\"", "*"] {
            assert!(holds(&[(header::IF_MATCH, given)], Some("a")), "{given}");
            assert!(!holds(&[(header::IF_MATCH, given)], None), "{given}");
        }
        // A weak version says that the content is only much the same: not enough to write over it.
        for given in ["\"b\"", "W/\"a\"", "", "\"a", "\"*\"x"] {
            assert!(!holds(&[(header::IF_MATCH, given)], Some("a")), "{given}");
        }
    }

    #[test]
    fn if_none_match_wants_nothing_there() {
        assert!(holds(&[(header::IF_NONE_MATCH, "*")], None));
        assert!(!holds(&[(header::IF_NONE_MATCH, "*")], Some("a")));
    }
}
