//! The command line of `umwelt-server`; each flag has an environment variable, and the flag wins.

use clap::{Args, Parser, Subcommand};
use std::net::SocketAddr;
use std::time::Duration;
use umwelt_server::Config;

/// Controller server for two-wheel robots over bad links.
///
/// Robots send poses and get wheel speeds; operators describe robots, set tasks, watch and stop them.
/// JSON over HTTP/1.1 and HTTP/2 (prior knowledge); GET /openapi.json is the contract.
///
/// The first line on standard output says where the server listens; logs go to standard error.
/// Robots and tasks are kept in memory: they are gone when the server ends.
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
}

/// How to serve.
#[derive(Debug, Args)]
pub(crate) struct Serve {
    /// Address to listen on; port 0 takes a free one.
    #[arg(long, env = "UMWELT_LISTEN", value_name = "ADDRESS", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
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

impl Arguments {
    /// How to serve, wherever it was said.
    pub(crate) fn serve(self) -> Serve {
        match self.command {
            Some(Command::Serve(serve)) => serve,
            None => self.serve,
        }
    }
}

impl Serve {
    /// The settings of the server.
    pub(crate) fn config(&self) -> Config {
        Config {
            listen: self.listen,
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn config(arguments: &[&str]) -> Option<Config> {
        let all = std::iter::once(&"umwelt-server").chain(arguments);
        Arguments::try_parse_from(all).ok().map(|arguments| arguments.serve().config())
    }

    #[test]
    fn the_command_line_is_sound() {
        Arguments::command().debug_assert();
    }

    /// The bug to fear: a default on the command line that is not the library's.
    #[test]
    fn nothing_said_is_the_default() {
        assert_eq!(config(&[]), Some(Config::default()));
        assert_eq!(config(&["serve"]), Some(Config::default()));
    }

    #[test]
    fn flags_are_understood_with_and_without_the_command() {
        let expected =
            Config { listen: ([127, 0, 0, 1], 0).into(), max_robots: 3, ..Config::default() };
        let flags = ["--listen", "127.0.0.1:0", "--max-robots", "3"];
        assert_eq!(config(&flags), Some(expected));
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
            ["--data", "x"],
        ] {
            assert_eq!(config(&wrong), None, "{wrong:?}");
        }
    }
}
