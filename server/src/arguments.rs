//! The command line of `umwelt-server`; each flag has an environment variable, and the flag wins.

mod compare;
mod evolve;

use clap::{Args, Parser, Subcommand, ValueEnum};
use compare::Compare;
use evolve::Evolve;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;
use umwelt_api::{comparison, evolution};
use umwelt_server::offline::Order;
use umwelt_server::{Config, Priority};

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
    Serve(Serve),
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
    #[arg(long, env = "UMWELT_LOG", value_name = "FILTER", default_value = "info", value_parser = filter)]
    pub(crate) log: String,
    /// Most robots.
    #[arg(long, env = "UMWELT_MAX_ROBOTS", value_name = "N", default_value_t = Config::default().max_robots)]
    max_robots: usize,
    /// Most connections at a time; a robot uses up to three while its link stalls.
    #[arg(long, env = "UMWELT_MAX_CONNECTIONS", value_name = "N", default_value_t = Config::default().max_connections)]
    max_connections: usize,
    /// Most event streams at a time.
    #[arg(long, env = "UMWELT_MAX_EVENT_STREAMS", value_name = "N", default_value_t = Config::default().max_event_streams)]
    max_event_streams: usize,
    /// Seconds without a step after which a robot counts as lost.
    #[arg(long, env = "UMWELT_LOST_AFTER_S", value_name = "S", default_value = "2", value_parser = seconds)]
    lost_after_s: Duration,
    /// Seconds for a connection to bring its first request, and for each request to bring its header.
    #[arg(long, env = "UMWELT_HEADER_TIMEOUT_S", value_name = "S", default_value = "10", value_parser = seconds)]
    header_timeout_s: Duration,
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
            Some(Command::Serve(serve)) => Task::Serve(Box::new(serve)),
            None => Task::Serve(Box::new(self.serve)),
        }
    }
}

impl Serve {
    /// The settings of the server.
    pub(crate) fn config(&self) -> Config {
        Config {
            listen: self.listen,
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
            max_event_streams: self.max_event_streams,
            lost_after: self.lost_after_s,
            header_timeout: self.header_timeout_s,
            body_timeout: self.body_timeout_s,
            drain: self.drain_s,
            ..Config::default()
        }
    }
}

fn filter(text: &str) -> Result<String, String> {
    match tracing_subscriber::EnvFilter::try_new(text) {
        Ok(_) => Ok(text.to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// From a millisecond to an hour.
fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1e-3..=3600.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("use a number of seconds from 0.001 to 3600".to_owned()),
    }
}

/// More threads than any machine has cores are a mistake.
fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if (1..=1024).contains(&threads) => Ok(threads),
        _ => Err("use an integer from 1 to 1024".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn config(arguments: &[&str]) -> Option<Config> {
        let all = std::iter::once(&"umwelt-server").chain(arguments);
        match Arguments::try_parse_from(all).ok()?.task() {
            Task::Serve(serve) => Some(serve.config()),
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

    /// The bug to fear: a default on the command line that is not the library's.
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
            ["backup", "--data"],
        ] {
            assert_eq!(config(&wrong), None, "{wrong:?}");
        }
    }
}
