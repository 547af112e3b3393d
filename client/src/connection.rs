//! The connections to a server.

use crate::token;
use reqwest::redirect;
use std::time::Duration;
use umwelt_api::Token;

/// Below the deadline, so that a host that does not answer differs from a slow answer.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(4);

/// What all connections have in common: no delay for small packets, no proxy between a robot and its server, no
/// redirect (it would turn PUT into GET, and take the token elsewhere), no retry below ours.
pub(crate) fn http(builder: reqwest::ClientBuilder, token: Option<&Token>) -> reqwest::Client {
    let client = builder
        .default_headers(token::headers(token))
        .tcp_nodelay(true)
        .connect_timeout(CONNECT_TIMEOUT)
        .no_proxy()
        .redirect(redirect::Policy::none())
        .retry(reqwest::retry::never())
        .build();
    client.expect("only TLS and name resolvers can fail here, and neither is asked for")
}
