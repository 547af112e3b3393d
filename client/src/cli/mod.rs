//! The command line `umwelt`: one module per noun.
//!
//! Results go to standard output, everything else to standard error. Exit status: 0; 1 where it failed; 2 where the
//! call was wrong. Nothing of it knows HTTP: it asks [`Client`].

mod check_report;
mod compare;
mod comparison;
mod environment;
mod events;
mod evolution;
mod evolve;
mod failure;
#[cfg(feature = "identify")]
mod identify;
mod input;
mod job;
mod output;
mod prior;
mod progress;
mod quantity;
mod robot;
mod square_report;
mod stop;
mod table;
mod task;
mod training;
mod unreadable;

use clap::{Parser, Subcommand};
use failure::Failure;
use output::Output;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use umwelt_client::Client;

const EXAMPLES: &str = "\
Examples:
  umwelt robot add rover-7 --wheel-radius 0.021 --track-width 0.1
  umwelt task set rover-7 --waypoint 0.2,0 --waypoint 0,-0.1 --calibrate --watch
  umwelt environment show rover-7
  umwelt evolve --environments normal,slippery --prior wet-hall --watch
  umwelt robot set rover-7 --prior wet-hall
  umwelt compare --methods statistic,bayesian --prior wet-hall --watch
  umwelt stop --all
  umwelt --json robot list --state lost | jq -r '.robots[].robot'

Exit status: 0, 1 if it failed, 2 if the call was wrong.";

/// Drive robots over bad links: describe them, give them tasks, see what was learned of floor and link.
#[derive(Debug, Parser)]
#[command(name = "umwelt", version, after_help = EXAMPLES, arg_required_else_help = true)]
struct Cli {
    /// Address of the server
    #[arg(
        long,
        global = true,
        env = "UMWELT_SERVER",
        default_value = "http://127.0.0.1:8080",
        value_name = "URL"
    )]
    server: String,
    /// File with the token of the server, where it has one
    #[arg(long, global = true, env = "UMWELT_TOKEN_FILE", value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Write JSON: one document, or one line per event where something is watched
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Describe, list, show and remove robots
    #[command(subcommand)]
    Robot(robot::Command),
    /// Send a robot somewhere, and see how far it has got
    #[command(subcommand)]
    Task(task::Command),
    /// Show what was learned of a robot's floor and link; name simulated environments
    #[command(subcommand, after_help = environment::WHICH)]
    Environment(environment::Command),
    /// Name what robots believe of the floor before any sample
    #[command(subcommand)]
    Prior(prior::Command),
    /// Search for a prior in simulated environments, in the background of the server
    Evolve(Box<evolve::Evolve>),
    /// List, show, watch, draw, cancel and remove evolutions
    #[command(subcommand)]
    Evolution(evolution::Command),
    /// Compare methods in simulated environments, in the background of the server
    Compare(compare::Compare),
    /// List, show, watch, draw, cancel and remove comparisons
    #[command(subcommand)]
    Comparison(comparison::Command),
    /// Stop a robot, or all, until resumed
    Stop(stop::Which),
    /// Let a stopped robot, or all, go on
    Resume(stop::Which),
    /// Follow what happens to a robot, or to all
    Events(events::Follow),
    /// Identify dead time and lag of a drive from recorded poses and commands, without a server
    #[cfg(feature = "identify")]
    Identify(identify::Identify),
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let Cli { server, token_file, json, command } = Cli::parse();
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return Failure::Failed(format!("cannot start: {error}")).report(),
    };
    let mut output = Output::standard(json);
    // Asks no server: what is said of one is not looked at.
    #[cfg(feature = "identify")]
    if let Command::Identify(identify) = &command {
        return match identify.run(&mut output) {
            Ok(()) => ExitCode::SUCCESS,
            Err(failure) => failure.report(),
        };
    }
    let client = client(&server, token_file.as_deref());
    let done = client.and_then(|client| runtime.block_on(run(&client, command, &mut output)));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn client(server: &str, token_file: Option<&Path>) -> Result<Client, Failure> {
    let token = token_file.map(umwelt_client::read_token).transpose()?;
    Ok(Client::authorized(server, token)?)
}

async fn run(client: &Client, command: Command, output: &mut Output) -> Result<(), Failure> {
    match command {
        Command::Robot(command) => command.run(client, output).await,
        Command::Task(command) => command.run(client, output).await,
        Command::Environment(command) => command.run(client, output).await,
        Command::Prior(command) => command.run(client, output).await,
        Command::Evolve(evolve) => evolve.run(client, output).await,
        Command::Evolution(command) => command.run(client, output).await,
        Command::Compare(compare) => compare.run(client, output).await,
        Command::Comparison(command) => command.run(client, output).await,
        Command::Stop(which) => which.run(client, output, true).await,
        Command::Resume(which) => which.run(client, output, false).await,
        Command::Events(follow) => follow.run(client, output).await,
        #[cfg(feature = "identify")]
        Command::Identify(identify) => identify.run(output),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn server_and_json_may_stand_anywhere() {
        for line in [
            "umwelt --json --server http://h robot list",
            "umwelt robot list --server http://h --json",
        ] {
            let cli = Cli::try_parse_from(line.split(' ')).unwrap();
            assert_eq!((cli.json, cli.server.as_str()), (true, "http://h"), "{line}");
        }
    }

    #[test]
    fn wrong_calls_are_told_from_failures() {
        for line in [
            "umwelt robot show _rover",
            "umwelt robot list --state gone",
            "umwelt robot add a --method guess",
            "umwelt robot add a --slots many",
            "umwelt task set a",
            "umwelt task set a --waypoint 1",
            "umwelt task set a --waypoint 0,0 --no-calibration --calibration-straight 1",
            "umwelt stop",
            "umwelt stop a --all",
            "umwelt events --type nothing",
            "umwelt robot add a --prior _wet",
            "umwelt identify",
            "umwelt identify poses.csv --ahead 0",
            "umwelt evolve --preset fast",
            "umwelt evolve --optimizer guess",
            "umwelt evolve --population many",
            "umwelt evolve --idempotency-key ä",
            "umwelt evolution show",
            "umwelt evolution show .evolution",
            "umwelt evolution list --state gone",
            "umwelt compare --scenario moon",
            "umwelt compare --trials many",
            "umwelt compare --prior _wet",
            "umwelt comparison show .comparison",
            "umwelt comparison list --state gone",
            "umwelt comparison report comparison-1 --force",
            "umwelt prior put wet",
            "umwelt environment put wet",
            "umwelt environment describe",
        ] {
            let error = Cli::try_parse_from(line.split(' ')).expect_err(line);
            assert_eq!(error.exit_code(), 2, "{line}");
        }
    }

    /// What `umwelt` does with these arguments and no server.
    async fn failure(line: &str) -> Failure {
        let cli = Cli::try_parse_from(line.split(' ')).expect(line);
        match client(&cli.server, cli.token_file.as_deref()) {
            Ok(client) => run(&client, cli.command, &mut Output::nowhere()).await.expect_err(line),
            Err(failure) => failure,
        }
    }

    #[tokio::test]
    async fn bad_local_input_is_a_wrong_call() {
        for line in [
            "umwelt --server nonsense robot list",
            "umwelt --server https://h robot list",
            "umwelt --server http://a:b@h robot list",
            "umwelt --token-file /nonexistent/token stop --all",
            "umwelt robot add a --file /nonexistent/spec.json",
            "umwelt robot add a --file /",
            "umwelt task set a --file /nonexistent/task.json",
            "umwelt robot add a --lag -1",
            "umwelt robot add a --slots 0",
            "umwelt task set a --waypoint 1e9,0",
            "umwelt task set a --waypoint 0,0 --tolerance -1",
            "umwelt evolve --population 1",
            "umwelt evolve --environments normal,normal",
            "umwelt evolve --slots 68 --trials 0",
            "umwelt prior put a --file /nonexistent/prior.json",
            "umwelt environment put a --file /",
            "umwelt evolution plot evolution-1 --out /dev/null/plots",
            "umwelt compare --trials 1",
            "umwelt compare --methods bayesian,bayesian",
            "umwelt comparison plot comparison-1 --out /dev/null/plots",
            "umwelt comparison trials comparison-1 --out /",
        ] {
            let failure = failure(line).await;
            assert!(matches!(failure, Failure::Wrong(_)), "{line}: {failure:?}");
        }
    }

    #[tokio::test]
    async fn a_server_that_is_not_there_is_a_failure() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        let Failure::Failed(text) =
            failure(&format!("umwelt --server http://{address} robot list")).await
        else {
            panic!("it is no wrong call");
        };
        assert!(
            text.contains("no server reached") && text.contains(&address.to_string()),
            "{text}"
        );
    }
}
