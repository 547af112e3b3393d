//! `umwelt-agent`: the loop on the robot.

mod log;
mod options;

use clap::Parser;
use log::Log;
use options::{Options, Plan, Which};
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use tokio::signal::unix::{SignalKind, signal};
use tracing::error;
use tracing_subscriber::EnvFilter;
use umwelt_agent::drive::Pipe;
use umwelt_agent::{Clock, run};

/// The call was wrong.
const WRONG_CALL: u8 = 2;

fn main() -> ExitCode {
    let options = Options::parse();
    let log = match Log::start(std::io::stderr()) {
        Ok(log) => log,
        Err(error) => return wrong(&format!("the log cannot be written: {error}")),
    };
    let filter = EnvFilter::try_new(&options.log).map_err(|error| format!("--log: {error}"));
    let plan = filter.and_then(|filter| {
        let writer = log.clone();
        tracing_subscriber::fmt()
            .with_writer(move || writer.clone())
            .with_ansi(std::io::stderr().is_terminal())
            .with_env_filter(filter)
            .init();
        options.plan()
    });
    match plan {
        Ok(plan) => {
            let code = drive(plan);
            log.finish();
            code
        }
        Err(error) => wrong(&error),
    }
}

fn wrong(error: &str) -> ExitCode {
    // Nothing is left to be done about a closed standard error.
    let _ = writeln!(std::io::stderr(), "error: {error}\n\nFor more information, try '--help'.");
    ExitCode::from(WRONG_CALL)
}

#[tokio::main(flavor = "current_thread")]
async fn drive(plan: Plan) -> ExitCode {
    let Plan { config, connect, which } = plan;
    let (mut terminate, mut interrupt) =
        match (signal(SignalKind::terminate()), signal(SignalKind::interrupt())) {
            (Ok(terminate), Ok(interrupt)) => (terminate, interrupt),
            (Err(error), _) | (_, Err(error)) => return failed(&error),
        };
    let shutdown = async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = interrupt.recv() => {}
        }
    };
    let ended = match which {
        Which::Sim(sim) => run(config, connect, *sim, Clock::start(), shutdown).await,
        Which::Pipe(output) => match Pipe::stdio(output) {
            Ok(pipe) => run(config, connect, pipe, Clock::host(), shutdown).await,
            Err(error) => return failed(&error),
        },
    };
    match ended {
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => failed(&error),
    }
}

fn failed(error: &dyn std::error::Error) -> ExitCode {
    error!("{error}");
    ExitCode::FAILURE
}
