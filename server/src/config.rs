//! What can be set about a server.

use crate::jobs::Priority;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

/// Every setting of a server. Where nothing is said, [`Config::default`].
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Where to listen; port 0 takes a free one.
    pub listen: SocketAddr,
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
    /// Most event streams at a time. They last for hours and each sees every event.
    pub max_event_streams: usize,
    /// Silence after which a robot counts as lost: far above the jitter of a link, far below a person's patience.
    pub lost_after: Duration,
    /// Time for a connection to bring its first request, and for each request to bring its header.
    pub header_timeout: Duration,
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

impl Default for Config {
    fn default() -> Self {
        Self {
            listen: (Ipv4Addr::LOCALHOST, 8080).into(),
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
            max_event_streams: 256,
            lost_after: Duration::from_secs(2),
            header_timeout: Duration::from_secs(10),
            body_timeout: Duration::from_secs(10),
            deadline: Duration::from_secs(15),
            max_deadline: Duration::from_secs(60),
            drain: Duration::from_secs(1),
            close: Duration::from_secs(2),
        }
    }
}
