//! Which hosts are this server.
//!
//! A foreign name can be made to lead to this machine (DNS rebinding): its pages would then be of this server's own
//! origin. So a request must name a host that is known to be this server. Ports are not compared: a tunnel or a mapped
//! port has another one, and no page can choose what its browser says.

use crate::resource::failure::Failure;
use axum::http::{HeaderMap, Uri, header};
use std::fmt;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::str::FromStr;
use umwelt_api::problem::{Detail, Problems, Status, reason};

/// Longest name of a host that DNS knows, in bytes.
const MAX_NAME: usize = 253;

/// The name that every machine has for itself.
const LOCALHOST: &str = "localhost";

/// A host, by name (small letters, no dot at the end) or by address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostName(Host);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Host {
    Name(String),
    Address(IpAddr),
}

/// A host and perhaps a port, as `Host` and `:authority` name them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Authority {
    pub(super) host: HostName,
    pub(super) port: Option<u16>,
}

/// The host that the request names, where it is this server.
///
/// # Errors
/// INVALID_ARGUMENT where it names none, several or nonsense; PERMISSION_DENIED where it names another.
pub(super) fn check(
    listen: IpAddr,
    allowed: &[HostName],
    uri: &Uri,
    headers: &HeaderMap,
) -> Result<Authority, Failure> {
    let mut hosts = headers.get_all(header::HOST).iter();
    let (named, more) = (hosts.next(), hosts.next());
    if more.is_some() {
        return Err(malformed("several"));
    }
    let named = named.map(|host| host.to_str().unwrap_or_default());
    // HTTP/2 names it in `:authority`, and so does HTTP/1.1 toward a proxy; a `Host` beside it must be one of ours too.
    let target = uri.authority().map(|authority| authority.as_str());
    let mut own = None;
    for text in [target, named].into_iter().flatten() {
        let authority: Authority = text.parse().map_err(|NoHost| malformed(text))?;
        if !is_ours(listen, allowed, &authority.host) {
            return Err(foreign(text, &authority.host));
        }
        own.get_or_insert(authority);
    }
    own.ok_or_else(|| malformed("none"))
}

/// An address of this machine is known by its listener; where that is every address, any will do: only a name can be
/// made to lead elsewhere than it did.
fn is_ours(listen: IpAddr, allowed: &[HostName], host: &HostName) -> bool {
    let listen = listen.to_canonical();
    allowed.contains(host)
        || match &host.0 {
            Host::Name(name) => name == LOCALHOST,
            Host::Address(ip) => ip.is_loopback() || *ip == listen || listen.is_unspecified(),
        }
}

fn malformed(given: &str) -> Failure {
    let remedy = "name one host and perhaps a port, as in Host: localhost:8080";
    Problems::from(Detail::new(reason::MALFORMED, "Host", given, remedy)).into()
}

fn foreign(given: &str, host: &HostName) -> Failure {
    let remedy = format!(
        "call the server by its address or as localhost; if {host} is a name of yours for it, start it with \
         --allow-host {host}"
    );
    Failure::new(Status::PermissionDenied, "this server is not known by that host")
        .with(Detail::new(reason::FOREIGN_HOST, "Host", given, remedy))
}

/// A text that names no host.
#[derive(Debug, PartialEq)]
pub(super) struct NoHost;

impl FromStr for Authority {
    type Err = NoHost;

    fn from_str(text: &str) -> Result<Self, NoHost> {
        // The colons of an IPv6 address stand in brackets.
        let behind = text.rfind(']').map_or(0, |bracket| bracket + 1);
        let (host, port) = match text[behind..].split_once(':') {
            Some((rest, port)) => (&text[..behind + rest.len()], port),
            None => (text, ""),
        };
        let is_port = port.bytes().all(|byte| byte.is_ascii_digit());
        let port = match port {
            "" => None,
            _ if is_port => Some(port.parse().map_err(|_| NoHost)?),
            _ => return Err(NoHost),
        };
        Ok(Self { host: HostName(host.parse()?), port })
    }
}

impl FromStr for Host {
    type Err = NoHost;

    fn from_str(text: &str) -> Result<Self, NoHost> {
        if let Some(inside) = text.strip_prefix('[') {
            let inside = inside.strip_suffix(']').ok_or(NoHost)?;
            let ip: Ipv6Addr = inside.parse().map_err(|_| NoHost)?;
            return Ok(Self::Address(IpAddr::from(ip).to_canonical()));
        }
        let text = text.strip_suffix('.').unwrap_or(text);
        if let Ok(ip) = text.parse::<Ipv4Addr>() {
            return Ok(Self::Address(ip.into()));
        }
        let is_allowed = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_');
        let is_label = |label: &str| !label.is_empty() && label.bytes().all(is_allowed);
        if text.len() <= MAX_NAME && text.split('.').all(is_label) {
            return Ok(Self::Name(text.to_ascii_lowercase()));
        }
        Err(NoHost)
    }
}

impl FromStr for HostName {
    type Err = String;

    /// A name or an address, IPv6 with or without brackets, and no port.
    fn from_str(text: &str) -> Result<Self, String> {
        let ip = text.parse::<IpAddr>().map(|ip| Host::Address(ip.to_canonical()));
        ip.or_else(|_| text.parse()).map(Self).map_err(|NoHost| {
            "use the name or the address of a host, without scheme and port, as in robots.example"
                .to_owned()
        })
    }
}

impl fmt::Display for HostName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Host::Name(name) => f.write_str(name),
            Host::Address(ip) => ip.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::response::IntoResponse;

    fn is_allowed(listen: &str, host: &str) -> bool {
        let headers = HeaderMap::from_iter([(header::HOST, host.parse().unwrap())]);
        check(listen.parse().unwrap(), &names(), &Uri::from_static("/v1/robots"), &headers).is_ok()
    }

    fn names() -> Vec<HostName> {
        vec!["Robots.Example".parse().unwrap(), "fd00::7".parse().unwrap()]
    }

    #[test]
    fn a_server_is_known_by_its_addresses_and_the_names_that_were_given() {
        for listen in ["127.0.0.1", "::1", "0.0.0.0", "10.0.0.5"] {
            for host in [
                "localhost",
                "LocalHost.:8080",
                "localhost:9000",
                "127.0.0.1:8080",
                "127.0.0.1",
                "[::1]:8080",
                "[::ffff:127.0.0.1]",
                "robots.example",
                "ROBOTS.example.:443",
                "[FD00:0::7]:8080",
                "localhost:",
            ] {
                assert!(is_allowed(listen, host), "{host} at {listen}");
            }
        }
        assert!(is_allowed("10.0.0.5", "10.0.0.5:8080"));
        assert!(is_allowed("0.0.0.0", "192.168.1.7"));
        assert!(is_allowed("::", "[fe80::1]:8080"));
    }

    #[test]
    fn nothing_else_is_it() {
        for listen in ["127.0.0.1", "0.0.0.0", "::", "10.0.0.5"] {
            for host in [
                "evil.example",
                "evil.example:8080",
                "localhost.evil.example",
                "127.0.0.1.evil.example",
                "evil-localhost",
                "robots.example.evil",
                "x.robots.example",
                "2130706433",
                "0x7f.1",
                "127.1",
                "localhost@evil.example",
                "evil.example@localhost",
                "http://localhost",
                "localhost/",
                "localhost..",
                "localhost:80:80",
                "localhost:http",
                "localhost:99999",
                "::1",
                "[::1",
                "[::1]x",
                "[::1%25lo]",
                "[localhost]",
                "127.0.0.1, evil.example",
                "",
                " ",
                ".",
                "*",
                "null",
            ] {
                assert!(!is_allowed(listen, host), "{host} at {listen}");
            }
        }
        for host in ["10.0.0.6", "192.168.1.7:8080", "0.0.0.0"] {
            assert!(!is_allowed("127.0.0.1", host), "{host}");
            assert!(!is_allowed("10.0.0.5", host), "{host}");
        }
    }

    #[test]
    fn every_host_that_is_named_must_be_ours_and_one_must_be() {
        let code = |uri: &'static str, hosts: &[&'static str]| {
            let mut headers = HeaderMap::new();
            for host in hosts {
                headers.append(header::HOST, host.parse().unwrap());
            }
            let checked = check(Ipv4Addr::LOCALHOST.into(), &[], &Uri::from_static(uri), &headers);
            checked.map(|own| own.port).map_err(|failure| failure.into_response().status().as_u16())
        };
        assert_eq!(code("http://localhost:1/v1/stop", &[]), Ok(Some(1)));
        assert_eq!(code("http://localhost:1/v1/stop", &["127.0.0.1:2"]), Ok(Some(1)));
        assert_eq!(code("http://evil.example/v1/stop", &["localhost"]), Err(403));
        assert_eq!(code("http://localhost/v1/stop", &["evil.example"]), Err(403));
        assert_eq!(code("/v1/stop", &["localhost", "evil.example"]), Err(400));
        assert_eq!(code("/v1/stop", &["localhost", "localhost"]), Err(400));
        assert_eq!(code("/v1/stop", &[]), Err(400));
    }

    #[test]
    fn what_is_allowed_is_a_host_without_a_port() {
        assert_eq!("[fd00::7]".parse::<HostName>(), "fd00:0::7".parse());
        for wrong in ["", "*", "*.example", "a:80", "http://a", "a/b", "a b", "[a]", "ä.example"] {
            assert!(wrong.parse::<HostName>().is_err(), "{wrong:?}");
        }
    }
}
