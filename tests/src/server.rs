//! A server as a process, with a client of it.

use crate::process::Process;
use std::net::SocketAddr;
use umwelt_client::Client;

/// What the server says before its address, on the first line.
const LISTENING: &str = "listening on http://";

/// A running `umwelt-server` on a free port of this machine.
#[derive(Debug)]
pub struct Server {
    /// The process.
    pub process: Process,
    /// Where it listens.
    pub address: SocketAddr,
    /// A client of it.
    pub client: Client,
}

impl Server {
    /// Starts a server and waits until it listens.
    ///
    /// # Panics
    /// Where it does not.
    pub fn start() -> Self {
        Self::start_with(&[])
    }

    /// The same with more flags. Where they name no data directory, it keeps everything in memory.
    ///
    /// # Panics
    /// Where it does not listen.
    pub fn start_with(flags: &[&str]) -> Self {
        Self::start_on("127.0.0.1:0", flags)
    }

    /// The same at an address of one's choice.
    ///
    /// # Panics
    /// Where it does not listen.
    pub fn start_on(listen: &str, flags: &[&str]) -> Self {
        let memory: &[&str] = if flags.contains(&"--data") { &[] } else { &["--in-memory"] };
        let flags = [&["--listen", listen], memory, flags].concat();
        Self::of(Process::start("umwelt-server", &flags))
    }

    /// The server that `process` is, once it listens.
    ///
    /// # Panics
    /// Where it does not.
    pub fn of(process: Process) -> Self {
        let first = process.line(0).unwrap_or_default();
        let address = first.strip_prefix(LISTENING).and_then(|address| address.parse().ok());
        let address =
            address.unwrap_or_else(|| panic!("no address in {first:?}\n{}", process.log()));
        let client = client(address);
        Self { process, address, client }
    }

    /// Its address as clients want it.
    pub fn url(&self) -> String {
        url(self.address)
    }
}

/// `http://` and the address.
pub fn url(address: SocketAddr) -> String {
    format!("http://{address}")
}

/// A client of whatever listens at `address`.
///
/// # Panics
/// Never: every socket address is one that the client takes.
pub fn client(address: SocketAddr) -> Client {
    Client::new(&url(address)).expect("a socket address is a server's address")
}
