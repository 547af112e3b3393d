//! The condition that a request sets, as its headers have it: `If-Match` and `If-None-Match: *`.

use crate::resource::condition::Condition;
use crate::resource::failure::Failure;
use axum::extract::FromRequestParts;
use axum::http::{HeaderMap, HeaderName, header, request::Parts};
use umwelt_api::problem::{Detail, Status, reason};

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
