//! `umwelt-agent`: the loop on the robot.

mod log;
mod options;

use clap::Parser;
use log::Log;
use options::{Options, Plan, Which};
use std::io::Write;
use std::process::ExitCode;
use tokio::signal::unix::{SignalKind, signal};
use tracing::error;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use umwelt_agent::drive::Pipe;
use umwelt_agent::{Clock, run};
use umwelt_client::api::visible;

/// The call was wrong.
const WRONG_CALL: u8 = 2;

fn main() -> ExitCode {
    let options = Options::parse();
    let log = match Log::start(std::io::stderr()) {
        Ok(log) => log,
        Err(error) => return wrong(&format!("the log cannot be written: {error}")),
    };
    let filter = options.log.parse::<Targets>().map_err(|error| format!("--log: {error}"));
    let plan = filter.and_then(|filter| {
        let writer = log.clone();
        tracing_subscriber::fmt()
            .with_writer(move || Visible(writer.clone()))
            // Colours are control characters too.
            .with_ansi(false)
            .with_max_level(LevelFilter::TRACE)
            .finish()
            .with(filter)
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

/// A log in which nothing moves a cursor: parts of it are what a server said.
struct Visible<W>(W);

impl<W: Write> Write for Visible<W> {
    /// A line comes as a whole, so no character is cut.
    fn write(&mut self, line: &[u8]) -> std::io::Result<usize> {
        let text = String::from_utf8_lossy(line);
        self.0.write_all(visible::lines(&text).as_bytes())?;
        Ok(line.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_shows_what_a_server_said_as_what_it_is() {
        let mut log = Visible(Vec::new());
        log.write_all("WARN \u{1b}[2Jgone\r\u{202e}\u{9b}31m\n".as_bytes()).unwrap();
        assert_eq!(log.0, b"WARN \\u{1b}[2Jgone\\u{d}\\u{202e}\\u{9b}31m\n");
    }
}
