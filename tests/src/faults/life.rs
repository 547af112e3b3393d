//! The server and its lives: all of them on the same data and at the same address.

use crate::data::Data;
use crate::process::{Process, Signal};
use crate::server::Server;
use std::net::SocketAddr;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::time::{Instant, sleep};

/// Time for a server to end when told to: several times what it gives itself.
const END: Duration = Duration::from_secs(30);

/// Time between two looks whether it has ended.
const LOOK: Duration = Duration::from_millis(20);

/// The server.
#[derive(Debug)]
pub struct Life {
    /// Where it listens, in every life.
    pub address: SocketAddr,
    /// Its data.
    pub data: Data,
    process: Mutex<Option<Process>>,
}

/// Starts a server at `listen`.
///
/// # Panics
/// Where it does not listen.
fn start(listen: &str, data: &Data) -> Server {
    let flags = ["--listen", listen, "--data", data.text()];
    Server::of(Process::start_limited("umwelt-server", &flags))
}

impl Life {
    /// The first life.
    ///
    /// # Panics
    /// Where it does not begin.
    pub fn begin() -> Self {
        let data = Data::new();
        let server = start("127.0.0.1:0", &data);
        Self { address: server.address, data, process: Mutex::new(Some(server.process)) }
    }

    /// The next one.
    ///
    /// # Panics
    /// Where it does not begin.
    pub fn begin_next(&self) {
        let address = self.address.to_string();
        let server = tokio::task::block_in_place(|| start(&address, &self.data));
        *self.process() = Some(server.process);
    }

    /// Kills it.
    pub fn kill(&self) {
        // Its process is killed as it is dropped.
        *self.process() = None;
    }

    /// Makes it stand still, or go on.
    pub fn signal(&self, signal: Signal) {
        if let Some(process) = self.process().as_ref() {
            process.signal(signal);
        }
    }

    /// Tells it to end; false where it does not, and has to be killed.
    pub async fn end(&self) -> bool {
        self.signal(Signal::Terminate);
        let deadline = Instant::now() + END;
        while Instant::now() < deadline {
            if self.process().as_mut().is_none_or(|process| process.ended().is_some()) {
                self.kill();
                return true;
            }
            sleep(LOOK).await;
        }
        self.kill();
        false
    }

    /// What it said before it ended, where it has ended though no one told it to.
    pub fn ended(&self) -> Option<String> {
        let mut process = self.process();
        let status = process.as_mut()?.ended()?;
        let log = process.take()?.log();
        let last: Vec<&str> = log.lines().rev().take(2).collect();
        Some(format!("the server ended by itself, {status}: {last:?}"))
    }

    /// Lets no file of it be written any more, or again; false where this machine has no program that does so.
    pub fn fill_disk(&self, is_full: bool) -> bool {
        let Some(id) = self.process().as_ref().map(Process::id) else { return false };
        let most = if is_full { "--fsize=0:unlimited" } else { "--fsize=unlimited:unlimited" };
        let status = Command::new("prlimit").args(["--pid", &id.to_string(), most]).status();
        status.is_ok_and(|status| status.success())
    }

    fn process(&self) -> MutexGuard<'_, Option<Process>> {
        // A process is there or not: what is behind a poisoned lock is whole.
        self.process.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
