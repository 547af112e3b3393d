//! `umwelt-server`: the controller server for two-wheel robots.

mod arguments;

use arguments::Arguments;
use clap::Parser;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::EnvFilter;
use umwelt_server::Server;

fn main() -> ExitCode {
    let arguments = Arguments::parse().serve();
    tracing_subscriber::fmt()
        .with_env_filter(EnvFilter::new(&arguments.log))
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .init();
    let done = tokio::runtime::Runtime::new()
        .and_then(|runtime| runtime.block_on(serve(arguments.config())));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!(%error, "failed");
            ExitCode::FAILURE
        }
    }
}

async fn serve(config: umwelt_server::Config) -> std::io::Result<()> {
    let (mut terminate, mut interrupt) =
        (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    let at = |error: std::io::Error| {
        std::io::Error::new(error.kind(), format!("cannot listen on {}: {error}", config.listen))
    };
    let server = Server::bind(config).await.map_err(at)?;
    // Whoever reads this line, a script or nobody, must not stop the server by going away.
    let mut output = std::io::stdout();
    let _ = writeln!(output, "listening on http://{}", server.local_addr());
    let _ = output.flush();
    let shutdown = async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = interrupt.recv() => {}
        }
    };
    server.run(shutdown).await
}
