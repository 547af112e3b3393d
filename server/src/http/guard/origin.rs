//! Whose page asks.
//!
//! A browser says in `Origin` and `Sec-Fetch-Site` from where a request comes, and no page can make it say otherwise.
//! Pages of the server's own host are its own; those of `--cors-origin` are as good; all others are foreign, whatever
//! they ask: also a stop is a change that no one here has asked for.

use super::host::{Authority, HostName};
use crate::resource::failure::Failure;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, header};
use std::fmt;
use std::str::FromStr;
use umwelt_api::problem::{Detail, Status, reason};

/// Where a browser says how a request came about; it sends some more of `sec-fetch-*`.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");
const FETCH: &str = "sec-fetch-";

/// The header by which a page shows that it was allowed to ask: a form cannot send it.
pub(super) const PROOF: HeaderName = HeaderName::from_static("x-umwelt-request");

/// The origin of a page: `https://robots.example`, `http://localhost:3000`, `app://dashboard`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    scheme: String,
    host: HostName,
    /// That of the scheme where none is said.
    port: Option<u16>,
}

impl Origin {
    /// Whether its pages are those of the server that is called `own`. TLS may end before this server: what counts is
    /// that host and port are the same to the browser.
    fn is_of(&self, own: &Authority) -> bool {
        let default = default_port(&self.scheme);
        default.is_some() && self.host == own.host && self.port == own.port.or(default)
    }
}

/// Where the browser sends what names no port.
fn default_port(scheme: &str) -> Option<u16> {
    match scheme {
        "http" => Some(80),
        "https" => Some(443),
        _ => None,
    }
}

impl FromStr for Origin {
    type Err = String;

    /// A scheme and a host, perhaps a port, and nothing behind it.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "use the origin of a page, scheme and host and perhaps a port, as in http://localhost:3000"
                .to_owned()
        };
        let (scheme, rest) = text.split_once("://").ok_or_else(wrong)?;
        let is_allowed = |byte: u8| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte);
        if !scheme.starts_with(|c: char| c.is_ascii_alphabetic()) || !scheme.bytes().all(is_allowed)
        {
            return Err(wrong());
        }
        let scheme = scheme.to_ascii_lowercase();
        let Authority { host, port } = rest.parse().map_err(|_| wrong())?;
        let port = port.or(default_port(&scheme));
        Ok(Self { scheme, host, port })
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}://{}", self.scheme, self.host)?;
        self.port.map_or(Ok(()), |port| write!(f, ":{port}"))
    }
}

/// The `Origin` of a request, if it is one of `--cors-origin`.
pub(super) fn allowed<'a>(named: &[Origin], headers: &'a HeaderMap) -> Option<&'a HeaderValue> {
    let given = only(headers)?;
    let origin: Origin = given.to_str().ok()?.parse().ok()?;
    named.contains(&origin).then_some(given)
}

/// The one `Origin`; none also where there are several.
fn only(headers: &HeaderMap) -> Option<&HeaderValue> {
    let mut origins = headers.get_all(header::ORIGIN).iter();
    let origin = origins.next();
    origin.filter(|_| origins.next().is_none())
}

/// Refuses what a page of another origin asks.
///
/// # Errors
/// PERMISSION_DENIED.
pub(super) fn check(
    named: &[Origin],
    own: &Authority,
    method: &Method,
    headers: &HeaderMap,
) -> Result<(), Failure> {
    if allowed(named, headers).is_some() {
        return Ok(());
    }
    if let Some(given) = headers.get(header::ORIGIN) {
        let text = given.to_str().unwrap_or_default();
        let origin = only(headers).and_then(|_| text.parse::<Origin>().ok());
        if !origin.is_some_and(|origin| origin.is_of(own)) {
            return Err(foreign("Origin", text));
        }
    }
    for site in headers.get_all(FETCH_SITE) {
        // `none` is a person at the address bar. Another page on this host or domain may show what it finds here.
        let may_pass = match site.as_bytes() {
            b"same-origin" | b"none" => true,
            b"same-site" => method.is_safe(),
            _ => false,
        };
        if !may_pass {
            return Err(foreign("Sec-Fetch-Site", site.to_str().unwrap_or_default()));
        }
    }
    Ok(())
}

fn foreign(field: &str, given: &str) -> Failure {
    let remedy = "open the server's own address; a page of your own is let in by --cors-origin and must ask in CORS mode";
    Failure::new(Status::PermissionDenied, "a web page of another origin may not ask here")
        .with(Detail::new(reason::FOREIGN_ORIGIN, field, given, remedy))
}

/// Refuses a change that a page asks for without showing that it may: a form of any page can POST, as text or without a
/// body, but it can neither declare JSON nor send a header of its own.
///
/// # Errors
/// PERMISSION_DENIED.
pub(super) fn check_not_a_form(method: &Method, headers: &HeaderMap) -> Result<(), Failure> {
    let is_of_page = headers.contains_key(header::ORIGIN)
        || headers.keys().any(|name| name.as_str().starts_with(FETCH));
    if method.is_safe() || !is_of_page || headers.contains_key(PROOF) || declares_json(headers) {
        return Ok(());
    }
    let remedy = "send Content-Type: application/json with a body, or X-Umwelt-Request: 1";
    Err(Failure::new(Status::PermissionDenied, "a form of any web page could have sent this")
        .with(Detail::new(reason::FORM_REQUEST, "X-Umwelt-Request", (), remedy)))
}

/// Whether the one content type is JSON.
fn declares_json(headers: &HeaderMap) -> bool {
    let mut kinds = headers.get_all(header::CONTENT_TYPE).iter();
    let (kind, more) = (kinds.next(), kinds.next());
    let kind = kind.filter(|_| more.is_none()).and_then(|kind| kind.to_str().ok());
    let essence = kind.and_then(|kind| kind.split(';').next()).unwrap_or_default();
    essence.trim().eq_ignore_ascii_case("application/json")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(given: &[(&'static str, &'static str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in given {
            headers.append(*name, HeaderValue::from_static(value));
        }
        headers
    }

    fn may(named: &[Origin], method: Method, given: &[(&'static str, &'static str)]) -> bool {
        let own = "localhost:8080".parse().unwrap();
        check(named, &own, &method, &headers(given)).is_ok()
    }

    fn dashboard() -> [Origin; 1] {
        ["http://localhost:3000".parse().unwrap()]
    }

    #[test]
    fn an_origin_is_this_host_or_one_that_was_named() {
        for method in [Method::GET, Method::POST, Method::DELETE] {
            for origin in
                ["http://localhost:8080", "http://LOCALHOST:8080", "http://localhost.:8080"]
            {
                assert!(may(&[], method.clone(), &[("origin", origin)]), "{origin}");
            }
            assert!(may(&dashboard(), method.clone(), &[("origin", "http://localhost:3000")]));
            for origin in [
                "http://evil.example",
                "http://evil.example:8080",
                "http://localhost",
                "http://localhost:3001",
                "https://localhost:3000",
                "http://localhost:80800",
                "http://localhost:8080.evil.example",
                "http://127.0.0.1:8080",
                "http://localhost:8080/",
                "app://localhost:8080",
                "file://",
                "null",
                "*",
                "",
            ] {
                assert!(!may(&dashboard(), method.clone(), &[("origin", origin)]), "{origin}");
            }
        }
    }

    #[test]
    fn behind_a_proxy_that_ends_tls_the_own_host_has_no_port() {
        let own: Authority = "robots.example".parse().unwrap();
        let is_own = |origin: &str| origin.parse::<Origin>().unwrap().is_of(&own);
        assert!(is_own("https://robots.example") && is_own("http://robots.example"));
        assert!(!is_own("https://robots.example:8443") && !is_own("https://other.example"));
    }

    #[test]
    fn a_request_has_one_origin() {
        let two = [("origin", "http://localhost:8080"), ("origin", "http://evil.example")];
        assert!(!may(&[], Method::GET, &two));
        let two = [("origin", "http://localhost:3000"), ("origin", "http://evil.example")];
        assert!(!may(&dashboard(), Method::GET, &two));
    }

    #[test]
    fn what_the_browser_says_of_the_site_counts_where_no_origin_was_named() {
        let site = |method, site| may(&dashboard(), method, &[("sec-fetch-site", site)]);
        for method in [Method::GET, Method::POST] {
            assert!(site(method.clone(), "same-origin") && site(method.clone(), "none"));
            assert!(!site(method.clone(), "cross-site") && !site(method.clone(), "of-tomorrow"));
        }
        assert!(site(Method::GET, "same-site") && !site(Method::POST, "same-site"));
        let own = ("origin", "http://localhost:8080");
        assert!(!may(&dashboard(), Method::GET, &[own, ("sec-fetch-site", "cross-site")]));
        let named = ("origin", "http://localhost:3000");
        assert!(may(&dashboard(), Method::PUT, &[named, ("sec-fetch-site", "cross-site")]));
    }

    #[test]
    fn a_page_that_changes_something_shows_that_it_may() {
        let may = |method: Method, given: &[(&'static str, &'static str)]| {
            check_not_a_form(&method, &headers(given)).is_ok()
        };
        let (own, fetch) = (("origin", "http://localhost:8080"), ("sec-fetch-mode", "navigate"));
        for page in [own, fetch] {
            assert!(!may(Method::POST, &[page]) && !may(Method::DELETE, &[page]));
            assert!(may(Method::GET, &[page]) && may(Method::HEAD, &[page]));
            for kind in [
                "text/plain",
                "application/x-www-form-urlencoded",
                "multipart/form-data",
                "",
                "application/jsonx",
            ] {
                assert!(!may(Method::POST, &[page, ("content-type", kind)]), "{kind}");
            }
            let two = [page, ("content-type", "text/plain"), ("content-type", "application/json")];
            assert!(!may(Method::POST, &two));
            for kind in ["application/json", "Application/JSON; charset=utf-8"] {
                assert!(may(Method::POST, &[page, ("content-type", kind)]), "{kind}");
            }
            assert!(may(Method::POST, &[page, ("x-umwelt-request", "1")]));
        }
        assert!(may(Method::POST, &[]) && may(Method::POST, &[("content-type", "text/plain")]));
    }

    #[test]
    fn what_is_no_origin_is_not_taken_for_one() {
        for text in ["http://localhost:3000", "https://Robots.Example", "app://dashboard"] {
            assert!(text.parse::<Origin>().is_ok(), "{text}");
        }
        assert_eq!("https://a".parse::<Origin>(), "HTTPS://A:443".parse());
        for text in [
            "*",
            "null",
            "localhost:3000",
            "http://",
            "http://a/",
            "http://a/b",
            "http://*.a",
            "http://u@a",
            "://a",
            "1://a",
            "http://a b",
        ] {
            assert!(text.parse::<Origin>().is_err(), "{text:?}");
        }
    }
}
