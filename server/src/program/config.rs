//! What can be set about a server.

use crate::http::guard::host::HostName;
use crate::http::guard::origin::Origin;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;
use umwelt_api::Token;
use umwelt_lab::pool::Priority;

/// Bytes in a megabyte of the command line.
pub(crate) const MB: usize = 1 << 20;

/// Every setting of a server. Where nothing is said, [`Config::default`].
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Where to listen; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Names by which the server is called beside its address and `localhost`.
    pub allow_hosts: Vec<HostName>,
    /// Whose pages may use the server from a browser, beside its own.
    pub cors_origins: Vec<Origin>,
    /// The secret that every request must carry, but the one for liveness.
    pub token: Option<Token>,
    /// Whether the server may listen for other machines without a token.
    pub allow_insecure: bool,
    /// Directory of everything that outlives the process, for one server at a time; none keeps it in memory, and it is
    /// gone with the server. `umwelt-server` itself takes `./umwelt-data` where nothing is said.
    pub data: Option<PathBuf>,
    /// Time between two writes of what a robot has learned: a crash costs at most this and one write, or a twentieth of
    /// what was learned. Shorter wears out flash sooner.
    pub save_every: Duration,
    /// Evolutions that have ended and are kept; the oldest go first. Each may hold some MB.
    pub keep_evolutions: usize,
    /// Evolutions that may wait for their turn.
    pub max_queued_evolutions: usize,
    /// Comparisons that have ended and are kept; the oldest go first. Each may hold some 20 MB, nearly all of it on the
    /// disk.
    pub keep_comparisons: usize,
    /// Comparisons that may wait for their turn.
    pub max_queued_comparisons: usize,
    /// Threads for evolutions and comparisons, of lowest priority; all cores where none are said. What comes of them does
    /// not depend on that.
    pub evolution_threads: Option<usize>,
    /// How these threads stand beside all others: at the lowest priority they do not disturb the control of robots, and
    /// do not go on either where other programs keep all cores busy.
    pub evolution_priority: Priority,
    /// Most robots. Each costs about 0.2 MB and one horizon per 30 ms.
    pub max_robots: usize,
    /// Most connections at a time. A robot uses up to three of them while its link stalls.
    pub max_connections: usize,
    /// Most connections of one address, or IPv6 network, at a time: enough for a thousand robots behind one, and less
    /// than all.
    pub max_connections_per_peer: usize,
    /// Connections beyond these limits on which a stop, health and readiness are served, and nothing else; a quarter of
    /// them for one address.
    pub reserved_connections: usize,
    /// Most requests in flight on one HTTP/2 connection; an agent has four.
    pub max_streams_per_connection: u32,
    /// HTTP/2 frames without content that a connection may send per second, ten times as many at once.
    pub max_control_frames_per_s: u32,
    /// Most bytes of bodies in flight.
    pub max_bodies: usize,
    /// Most bytes of bodies in flight of one address.
    pub max_bodies_per_peer: usize,
    /// Bytes of figures, tables and reports to keep once they are made; those go first that no one has asked for the
    /// longest.
    pub keep_documents: usize,
    /// Most event streams at a time. They last for hours and each sees every event.
    pub max_event_streams: usize,
    /// Most event streams of one address at a time.
    pub max_event_streams_per_peer: usize,
    /// Silence after which a robot counts as lost: far above the jitter of a link, far below a person's patience.
    pub lost_after: Duration,
    /// Time for a connection to bring its first request, and for each request to bring its header.
    pub header_timeout: Duration,
    /// How long a connection of HTTP/1.1 is kept between two requests. Browsers and proxies keep theirs for a minute.
    pub idle_timeout: Duration,
    /// Time for a body to arrive in full.
    pub body_timeout: Duration,
    /// Time for an answer where the request names none in `grpc-timeout`.
    pub deadline: Duration,
    /// Longest time that a request may ask for in `grpc-timeout`; a longer one counts as this.
    pub max_deadline: Duration,
    /// On shutdown: time for the connected robots to fetch a stopping horizon. One that comes too late
    /// stops by its own watchdog.
    pub drain: Duration,
    /// On shutdown, after that: time for the connections to end in order.
    pub close: Duration,
}

impl Config {
    /// Whether a server may run so.
    ///
    /// # Errors
    /// Where others than this machine could drive the robots without a secret; says what to do.
    pub fn check(&self) -> Result<(), String> {
        if self.is_local() || self.token.is_some() || self.allow_insecure {
            return Ok(());
        }
        Err(format!(
            "listening on {} lets everybody who reaches it drive every robot: name a secret with --token-file FILE, \
             or listen on 127.0.0.1; --allow-insecure takes the risk, on a network of your own alone",
            self.listen
        ))
    }

    /// Whether only this machine can reach the address to listen on.
    pub(crate) fn is_local(&self) -> bool {
        self.listen.ip().to_canonical().is_loopback()
    }
}

impl Default for Config {
    fn default() -> Self {
        Self {
            listen: (Ipv4Addr::LOCALHOST, 8080).into(),
            allow_hosts: Vec::new(),
            cors_origins: Vec::new(),
            token: None,
            allow_insecure: false,
            data: None,
            save_every: Duration::from_secs(5),
            keep_evolutions: 200,
            max_queued_evolutions: 16,
            keep_comparisons: 50,
            max_queued_comparisons: 16,
            evolution_threads: None,
            evolution_priority: Priority::default(),
            max_robots: 1000,
            max_connections: 4096,
            max_connections_per_peer: 3584,
            reserved_connections: 128,
            max_streams_per_connection: 64,
            max_control_frames_per_s: 100,
            max_bodies: 64 * MB,
            max_bodies_per_peer: 32 * MB,
            keep_documents: 64 * MB,
            max_event_streams: 256,
            max_event_streams_per_peer: 192,
            lost_after: Duration::from_secs(2),
            header_timeout: Duration::from_secs(10),
            idle_timeout: Duration::from_secs(75),
            body_timeout: Duration::from_secs(10),
            deadline: Duration::from_secs(15),
            max_deadline: Duration::from_secs(60),
            drain: Duration::from_secs(1),
            close: Duration::from_secs(2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_needs_no_secret() {
        let at = |listen: &str| Config { listen: listen.parse().unwrap(), ..Config::default() };
        for listen in ["127.0.0.1:1", "127.9.9.9:1", "[::1]:1", "[::ffff:127.0.0.1]:1"] {
            assert_eq!(at(listen).check(), Ok(()), "{listen}");
        }
        for listen in ["0.0.0.0:1", "[::]:1", "10.0.0.1:1", "[fe80::1]:1", "[::ffff:10.0.0.1]:1"] {
            let said = at(listen).check().unwrap_err();
            assert!(said.contains(listen) && said.contains("--token-file"), "{said}");
            let token = Some("0123456789abcdef".parse().unwrap());
            assert_eq!(Config { token, ..at(listen) }.check(), Ok(()));
            assert_eq!(Config { allow_insecure: true, ..at(listen) }.check(), Ok(()));
        }
    }
}
