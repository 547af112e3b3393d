//! The command line of `umwelt-server`; each flag has an environment variable, and the flag wins.

mod compare;
mod evolve;
mod values;

use crate::http::guard::{HostName, Origin, read_token};
use crate::program::config::{Config, MB};
use clap::{Args, Parser, Subcommand, ValueEnum};
use compare::Compare;
use evolve::Evolve;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;
use tracing_subscriber::filter::Targets;
use umwelt_api::{comparison, evolution};
use umwelt_lab::offline::Order;
use umwelt_lab::pool::Priority;
use values::{at_least_one, megabytes, seconds, threads};

/// Data directory where none is named.
const DATA: &str = "umwelt-data";

/// Controller server for two-wheel robots over bad links.
///
/// Robots send poses and get wheel speeds; operators describe robots, set tasks, watch and stop them.
/// JSON over HTTP/1.1 and HTTP/2 (prior knowledge); GET /openapi.json is the contract.
///
/// The first line on standard output says where the server listens; logs go to standard error.
/// Robots, tasks, what they learned, priors, evolutions and comparisons are kept in the data directory and found again there;
/// what is acknowledged is on the disk. One server at a time uses a directory. Where data are damaged the server does not
/// start and names them; where the disk is full it serves what it has, stops robots, and refuses other changes.
/// SIGTERM and SIGINT stop every robot, then the server.
///
/// Exit status: 0 after a shutdown, 1 if it failed, 2 if the call was wrong.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, verbatim_doc_comment)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    serve: Serve,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serve; the same as no command at all.
    Serve(Box<Serve>),
    /// Evolve a prior, without a server.
    ///
    /// The result goes to standard output, progress to standard error.
    /// Exit status: 0, 1 if it failed, 2 if the call was wrong.
    #[command(verbatim_doc_comment)]
    Evolve(Box<Evolve>),
    /// Compare methods of control, without a server.
    ///
    /// The result goes to standard output, progress to standard error.
    /// Exit status: 0, 1 if it failed, 2 if the call was wrong.
    #[command(verbatim_doc_comment)]
    Compare(Box<Compare>),
    /// Write everything in a data directory to a file, while a server may be using it.
    ///
    /// The file is a data file itself. To use it: name it umwelt.sqlite, put it alone into a directory, and start
    /// `umwelt-server --data` with that. What a server takes in while the backup runs is not in it.
    #[command(verbatim_doc_comment)]
    Backup(Backup),
    /// Look for damage in a data directory, row by row.
    ///
    /// Each damaged row is named on standard output; a server may be using the data meanwhile. With --remove-damaged
    /// these rows are given up (a robot with its task and what it learned, an evolution or a comparison as a whole);
    /// no server may be using the data then. A backup brings them back, this does not.
    /// Exit status: 0 where nothing is damaged or all of it is removed, 1 otherwise, 2 if the call was wrong.
    #[command(verbatim_doc_comment)]
    Check(Check),
}

/// What to look through.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Data directory to look through.
    #[arg(long, env = "UMWELT_DATA", value_name = "DIR", default_value = DATA)]
    pub(crate) data: PathBuf,
    /// Remove the damaged rows, and nothing else.
    #[arg(long)]
    pub(crate) remove_damaged: bool,
}

/// What to back up, and where to.
#[derive(Debug, Args)]
pub(crate) struct Backup {
    /// File to write; it must not exist.
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Data directory to back up.
    #[arg(long, env = "UMWELT_DATA", value_name = "DIR", default_value = DATA)]
    pub(crate) data: PathBuf,
}

/// What is to be done.
#[derive(Debug)]
pub(crate) enum Task {
    /// Serve.
    Serve(Box<Serve>),
    /// Evolve a prior.
    Evolve(Box<Order<evolution::Request>>),
    /// Compare methods.
    Compare(Box<Order<comparison::Request>>),
    /// Write a backup.
    Backup(Backup),
    /// Look for damage.
    Check(Check),
}

/// How to serve.
#[derive(Debug, Args)]
pub(crate) struct Serve {
    /// Address to listen on; port 0 takes a free one.
    #[arg(long, env = "UMWELT_LISTEN", value_name = "ADDRESS", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// File with the secret that every request must carry, in `Authorization: Bearer`; only /healthz is open without.
    ///
    /// One word of 16 to 256 letters, digits and -._~+/=, the same for robots and operators, who take it by the same flag.
    /// It is read once, and needed where other machines reach the address to listen on.
    #[arg(long, env = "UMWELT_TOKEN_FILE", value_name = "FILE", conflicts_with = "allow_insecure")]
    token_file: Option<PathBuf>,
    /// Listen for other machines without a token.
    ///
    /// Everybody who reaches the address can then drive every robot: for a network that no one else is on.
    #[arg(long, env = "UMWELT_ALLOW_INSECURE")]
    allow_insecure: bool,
    /// Name by which the server may be called, beside localhost and its addresses; may be given several times.
    ///
    /// Another name in `Host` is refused: a foreign one may lead here. Behind a proxy it is the name that the proxy hands on.
    #[arg(long, env = "UMWELT_ALLOW_HOST", value_name = "NAME", value_delimiter = ',')]
    allow_host: Vec<HostName>,
    /// Origin whose web pages may use the server, as http://localhost:3000; may be given several times.
    ///
    /// Pages of all other origins but the server's own are refused whatever they ask.
    #[arg(long, env = "UMWELT_CORS_ORIGIN", value_name = "ORIGIN", value_delimiter = ',')]
    cors_origin: Vec<Origin>,
    /// Directory for everything that outlives the server; it is made where there is none.
    #[arg(long, env = "UMWELT_DATA", value_name = "DIR", default_value = DATA)]
    data: PathBuf,
    /// Keep everything in memory: it is gone when the server ends. For tests and demonstrations.
    #[arg(long, env = "UMWELT_IN_MEMORY", conflicts_with = "data")]
    in_memory: bool,
    /// Seconds between two writes of what a robot has learned: a crash costs that much. Shorter wears out flash sooner.
    #[arg(long, env = "UMWELT_SAVE_EVERY_S", value_name = "S", default_value = "5", value_parser = seconds)]
    save_every_s: Duration,
    /// Most evolutions to keep that have ended; the oldest go first.
    #[arg(long, env = "UMWELT_KEEP_EVOLUTIONS", value_name = "N", default_value_t = Config::default().keep_evolutions)]
    keep_evolutions: usize,
    /// Most evolutions that wait for their turn; one runs at a time.
    #[arg(long, env = "UMWELT_MAX_QUEUED_EVOLUTIONS", value_name = "N", default_value_t = Config::default().max_queued_evolutions)]
    max_queued_evolutions: usize,
    /// Most comparisons to keep that have ended; the oldest go first.
    #[arg(long, env = "UMWELT_KEEP_COMPARISONS", value_name = "N", default_value_t = Config::default().keep_comparisons)]
    keep_comparisons: usize,
    /// Most comparisons that wait for their turn; one runs at a time.
    #[arg(long, env = "UMWELT_MAX_QUEUED_COMPARISONS", value_name = "N", default_value_t = Config::default().max_queued_comparisons)]
    max_queued_comparisons: usize,
    /// Threads for evolutions and comparisons; all cores where none are said. They run where nothing else wants to.
    #[arg(long, env = "UMWELT_EVOLUTION_THREADS", value_name = "N", value_parser = threads)]
    evolution_threads: Option<usize>,
    /// Priority of these threads; at the normal one they delay the control of robots.
    #[arg(long, env = "UMWELT_EVOLUTION_PRIORITY", value_enum, default_value = "lowest")]
    evolution_priority: EvolutionPriority,
    /// What to log: error, warn, info, debug, trace, or per module as in `info,umwelt_server=debug`.
    #[arg(long, env = "UMWELT_LOG", value_name = "FILTER", default_value = "info")]
    pub(crate) log: Targets,
    /// Most robots.
    #[arg(long, env = "UMWELT_MAX_ROBOTS", value_name = "N", default_value_t = Config::default().max_robots)]
    max_robots: usize,
    /// Most connections at a time; a robot uses up to three while its link stalls.
    #[arg(long, env = "UMWELT_MAX_CONNECTIONS", value_name = "N", default_value_t = Config::default().max_connections)]
    max_connections: usize,
    /// Most connections of one address, or IPv6 network, at a time: less than all, and three for each robot behind it.
    #[arg(long, env = "UMWELT_MAX_CONNECTIONS_PER_PEER", value_name = "N", default_value_t = Config::default().max_connections_per_peer)]
    max_connections_per_peer: usize,
    /// Connections beyond these limits on which a stop, health and readiness are still served, and nothing else.
    #[arg(long, env = "UMWELT_RESERVED_CONNECTIONS", value_name = "N", default_value_t = Config::default().reserved_connections)]
    reserved_connections: usize,
    /// Most requests in flight on one HTTP/2 connection; an agent has four.
    #[arg(long, env = "UMWELT_MAX_STREAMS_PER_CONNECTION", value_name = "N", default_value_t = Config::default().max_streams_per_connection, value_parser = at_least_one)]
    max_streams_per_connection: u32,
    /// HTTP/2 control frames that a connection may send per second, ten times as many at once; a flood closes it.
    #[arg(long, env = "UMWELT_MAX_CONTROL_FRAMES_PER_S", value_name = "N", default_value_t = Config::default().max_control_frames_per_s, value_parser = at_least_one)]
    max_control_frames_per_s: u32,
    /// Most MB of bodies in flight; beyond them those are given up that have been arriving the longest.
    #[arg(long, env = "UMWELT_MAX_BODIES_MB", value_name = "MB", default_value_t = Config::default().max_bodies / MB, value_parser = megabytes)]
    max_bodies_mb: usize,
    /// Most MB of bodies in flight of one address.
    #[arg(long, env = "UMWELT_MAX_BODIES_MB_PER_PEER", value_name = "MB", default_value_t = Config::default().max_bodies_per_peer / MB, value_parser = megabytes)]
    max_bodies_mb_per_peer: usize,
    /// Most MB of figures, tables and reports to keep once they are made.
    #[arg(long, env = "UMWELT_KEEP_DOCUMENTS_MB", value_name = "MB", default_value_t = Config::default().keep_documents / MB, value_parser = megabytes)]
    keep_documents_mb: usize,
    /// Most event streams at a time.
    #[arg(long, env = "UMWELT_MAX_EVENT_STREAMS", value_name = "N", default_value_t = Config::default().max_event_streams)]
    max_event_streams: usize,
    /// Most event streams of one address at a time.
    #[arg(long, env = "UMWELT_MAX_EVENT_STREAMS_PER_PEER", value_name = "N", default_value_t = Config::default().max_event_streams_per_peer)]
    max_event_streams_per_peer: usize,
    /// Seconds without a step after which a robot counts as lost.
    #[arg(long, env = "UMWELT_LOST_AFTER_S", value_name = "S", default_value = "2", value_parser = seconds)]
    lost_after_s: Duration,
    /// Seconds for a connection to bring its first request, and for each request to bring its header.
    #[arg(long, env = "UMWELT_HEADER_TIMEOUT_S", value_name = "S", default_value = "10", value_parser = seconds)]
    header_timeout_s: Duration,
    /// Seconds for which a connection of HTTP/1.1 is kept between two requests; `Keep-Alive` in answers says so.
    #[arg(long, env = "UMWELT_IDLE_TIMEOUT_S", value_name = "S", default_value = "75", value_parser = seconds)]
    idle_timeout_s: Duration,
    /// Seconds for the body of a request to arrive.
    #[arg(long, env = "UMWELT_BODY_TIMEOUT_S", value_name = "S", default_value = "10", value_parser = seconds)]
    body_timeout_s: Duration,
    /// Seconds given to connected robots on shutdown to fetch a stopping horizon.
    #[arg(long, env = "UMWELT_DRAIN_S", value_name = "S", default_value = "1", value_parser = seconds)]
    drain_s: Duration,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum EvolutionPriority {
    Lowest,
    Normal,
}

impl Arguments {
    /// What is to be done, wherever it was said.
    pub(crate) fn task(self) -> Task {
        match self.command {
            Some(Command::Evolve(evolve)) => Task::Evolve(Box::new(evolve.order())),
            Some(Command::Compare(compare)) => Task::Compare(Box::new(compare.order())),
            Some(Command::Backup(backup)) => Task::Backup(backup),
            Some(Command::Check(check)) => Task::Check(check),
            Some(Command::Serve(serve)) => Task::Serve(serve),
            None => Task::Serve(Box::new(self.serve)),
        }
    }
}

impl Serve {
    /// The settings of the server.
    ///
    /// # Errors
    /// What is wrong with the call, in words.
    pub(crate) fn config(&self) -> Result<Config, String> {
        let config = Config {
            listen: self.listen,
            allow_hosts: self.allow_host.clone(),
            cors_origins: self.cors_origin.clone(),
            token: self.token_file.as_deref().map(read_token).transpose()?,
            allow_insecure: self.allow_insecure,
            data: (!self.in_memory).then(|| self.data.clone()),
            save_every: self.save_every_s,
            keep_evolutions: self.keep_evolutions,
            max_queued_evolutions: self.max_queued_evolutions,
            keep_comparisons: self.keep_comparisons,
            max_queued_comparisons: self.max_queued_comparisons,
            evolution_threads: self.evolution_threads,
            evolution_priority: match self.evolution_priority {
                EvolutionPriority::Lowest => Priority::Lowest,
                EvolutionPriority::Normal => Priority::Normal,
            },
            max_robots: self.max_robots,
            max_connections: self.max_connections,
            max_connections_per_peer: self.max_connections_per_peer,
            reserved_connections: self.reserved_connections,
            max_streams_per_connection: self.max_streams_per_connection,
            max_control_frames_per_s: self.max_control_frames_per_s,
            max_bodies: self.max_bodies_mb * MB,
            max_bodies_per_peer: self.max_bodies_mb_per_peer * MB,
            keep_documents: self.keep_documents_mb * MB,
            max_event_streams: self.max_event_streams,
            max_event_streams_per_peer: self.max_event_streams_per_peer,
            lost_after: self.lost_after_s,
            header_timeout: self.header_timeout_s,
            idle_timeout: self.idle_timeout_s,
            body_timeout: self.body_timeout_s,
            drain: self.drain_s,
            ..Config::default()
        };
        config.check()?;
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn config(arguments: &[&str]) -> Option<Config> {
        let all = std::iter::once(&"umwelt-server").chain(arguments);
        match Arguments::try_parse_from(all).ok()?.task() {
            Task::Serve(serve) => serve.config().ok(),
            Task::Evolve(_) | Task::Compare(_) | Task::Backup(_) | Task::Check(_) => None,
        }
    }

    #[test]
    fn the_command_line_is_sound() {
        Arguments::command().debug_assert();
    }

    /// The library's defaults, but for a data directory.
    fn kept() -> Config {
        Config { data: Some(DATA.into()), ..Config::default() }
    }

    /// Guards against: a default on the command line that is not the library's.
    #[test]
    fn nothing_said_is_the_default() {
        assert_eq!(config(&[]), Some(kept()));
        assert_eq!(config(&["serve"]), Some(kept()));
    }

    #[test]
    fn what_outlives_the_server_is_kept_where_it_is_said_or_nowhere() {
        let data = config(&["--data", "there"]).and_then(|config| config.data);
        assert_eq!(data, Some(PathBuf::from("there")));
        assert_eq!(config(&["--in-memory"]), Some(Config::default()));
        assert_eq!(config(&["--in-memory", "--data", "there"]), None);
    }

    #[test]
    fn flags_are_understood_with_and_without_the_command() {
        let expected = Config { listen: ([127, 0, 0, 1], 0).into(), max_robots: 3, ..kept() };
        let flags = ["--listen", "127.0.0.1:0", "--max-robots", "3"];
        assert_eq!(config(&flags), Some(expected.clone()));
        assert_eq!(config(&[&["serve"], &flags[..]].concat()), Some(expected));
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for wrong in [
            ["--lost-after-s", "0"],
            ["--lost-after-s", "NaN"],
            ["--drain-s", "-1"],
            ["--listen", "here"],
            ["--log", "umwelt=loud"],
            ["--keep-evolutions", "-1"],
            ["--cors-origin", "*"],
            ["--cors-origin", "localhost:3000"],
            ["--allow-host", "robots:8080"],
            ["--listen", "0.0.0.0:8080"],
            ["--token-file", "/nonexistent/token"],
            ["--max-bodies-mb", "0"],
            ["--max-streams-per-connection", "0"],
            ["backup", "--data"],
        ] {
            assert_eq!(config(&wrong), None, "{wrong:?}");
        }
    }
}
