//! The process: what its call asks for, from its start to its end.

use super::arguments::{Arguments, Backup, Check, Serve, Task};
use crate::program::config::Config;
use crate::program::serve::Server;
use crate::store;
use clap::Parser;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use umwelt_api::problem::Detail;
use umwelt_lab::offline;

/// Longest wait for a store that does not answer, once the server has ended.
const STORE_ENDS: Duration = Duration::from_secs(1);

/// How much longer than the server may take the process lasts, whatever does not end in it.
const LAST_RESORT: Duration = Duration::from_secs(2);

/// Exit status of a call that makes no sense, as clap has it.
const WRONG_CALL: u8 = 2;

/// Does what the command line of this process says.
pub fn main() -> ExitCode {
    match Arguments::parse().task() {
        Task::Serve(arguments) => run(&arguments),
        Task::Evolve(order) => said(offline::evolve(&order, &mut std::io::stdout().lock())),
        Task::Compare(order) => said(offline::compare(&order, &mut std::io::stdout().lock())),
        Task::Backup(backup) => back_up(&backup),
        Task::Check(check) => look_for_damage(&check),
    }
}

fn run(arguments: &Serve) -> ExitCode {
    tracing_subscriber::fmt()
        .with_max_level(LevelFilter::TRACE)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .finish()
        .with(arguments.log.clone())
        .init();
    let config = match arguments.config() {
        Ok(config) => config,
        Err(why) => {
            let _ =
                writeln!(std::io::stderr(), "error: {why}\n\nFor more information, try '--help'.");
            return ExitCode::from(WRONG_CALL);
        }
    };
    // Robots compute on threads of their own: nothing here waits for one of them.
    let runtime =
        tokio::runtime::Builder::new_multi_thread().thread_name("http").enable_all().build();
    let done = runtime.and_then(|runtime| {
        let done = runtime.block_on(serve(config));
        runtime.shutdown_timeout(STORE_ENDS);
        done
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!(%error, "server failed");
            ExitCode::FAILURE
        }
    }
}

fn back_up(Backup { file, data }: &Backup) -> ExitCode {
    match store::backup(data, file) {
        Ok(backup) => {
            say(&format!("{}: {backup}", file.display()));
            ExitCode::SUCCESS
        }
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn look_for_damage(Check { data, remove_damaged }: &Check) -> ExitCode {
    match store::check(data, *remove_damaged) {
        Ok(checked) => {
            say(&checked.to_string());
            let is_whole = checked.damaged.is_empty() || checked.removed;
            if is_whole { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// How the program ends after something that was done without a server.
fn said(done: Result<(), offline::Error>) -> ExitCode {
    let Err(error) = done else { return ExitCode::SUCCESS };
    // No one may read it; the exit status says it too.
    let mut output = std::io::stderr().lock();
    let _ = writeln!(output, "error: {error}");
    let offline::Error::Invalid(problems) = error else { return ExitCode::FAILURE };
    for Detail { reason, field, value, remedy } in problems.details() {
        let _ = writeln!(output, "  {field}: {value}: {remedy} ({reason})");
    }
    ExitCode::from(WRONG_CALL)
}

async fn serve(config: Config) -> std::io::Result<()> {
    let (mut terminate, mut interrupt) =
        (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    let longest = config.drain + config.close + LAST_RESORT;
    let server = Server::bind(config).await?;
    say(&format!("listening on http://{}", server.local_addr()));
    let shutdown = async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = interrupt.recv() => {}
        }
        end_after(longest);
    };
    server.run(shutdown).await
}

/// Ends the process after `longest`, where it has not ended by then: a disk that hangs, or a bug, may keep threads busy
/// that nothing can interrupt. What was acknowledged is on the disk; robots stop by themselves.
fn end_after(longest: Duration) {
    let watching = std::thread::Builder::new().name("last resort".to_owned()).spawn(move || {
        std::thread::sleep(longest);
        tracing::error!(seconds = longest.as_secs_f64(), "server does not end by itself: ended");
        std::process::exit(1);
    });
    if let Err(error) = watching {
        tracing::warn!(%error, "cannot watch over the end of the server");
    }
}

/// Says a result on standard output. Whoever reads it, a script or no one, must not stop the program by going away.
fn say(line: &str) {
    let mut output = std::io::stdout();
    let _ = writeln!(output, "{line}");
    let _ = output.flush();
}
