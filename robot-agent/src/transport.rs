//! What carries a request to the server and its reply back.
//!
//! A [`Connect`] opens connections, a [`Step`] is one of them; dropping it closes it. Nothing is ever sent twice
//! here: when to send and when to open a fresh connection is decided by [`umwelt_core::exchange::Exchange`].

use std::collections::BTreeMap;
use std::fmt;
use std::pin::Pin;
use std::sync::Arc;
use tokio::task::{AbortHandle, JoinSet};
use umwelt_client::api::RobotId;
use umwelt_client::api::step::{Reply, Request};
use umwelt_client::{Client, Error};

/// The answer to one request, when it comes.
pub type Answering = Pin<Box<dyn Future<Output = Result<Reply, Error>> + Send>>;

/// One connection that carries requests.
pub type Step = Box<dyn Fn(Request) -> Answering + Send>;

/// Opens connections. Nothing needs to be on the wire before the first request.
pub type Connect = Box<dyn Fn() -> Step + Send>;

/// Connections to the server at `server` (`http://host:port`) for `robot`, HTTP/2 and nothing else on them.
///
/// # Errors
/// Where `server` is no address.
pub fn http(server: &str, robot: RobotId) -> Result<Connect, Error> {
    Ok(of_client(Client::new(server)?, robot))
}

/// The same to the server of `client`, with its token where it has one.
pub fn of_client(client: Client, robot: RobotId) -> Connect {
    Box::new(move || {
        let connection = Arc::new(client.step_connection());
        let robot = robot.clone();
        Box::new(move |request| {
            let (connection, robot) = (Arc::clone(&connection), robot.clone());
            Box::pin(async move { connection.step(&robot, &request).await })
        })
    })
}

/// What became of one request.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    /// Epoch of the request.
    pub epoch: u64,
    /// Sequence of the request.
    pub sequence: u64,
    /// The reply, or why there is none.
    pub outcome: Result<Reply, Error>,
}

/// A request that is to go out now.
#[derive(Clone, Debug)]
pub(crate) struct Post {
    /// The connection: how many epochs came before, and its number within this one. One not seen before is opened.
    pub connection: (u64, u64),
    /// The request.
    pub request: Request,
}

/// The connections that are open, and the requests on their way.
pub(crate) struct Connections {
    connect: Connect,
    open: BTreeMap<(u64, u64), Open>,
    waited_for: JoinSet<Answer>,
    opened: u64,
}

struct Open {
    step: Step,
    waited_for: Vec<AbortHandle>,
}

impl fmt::Debug for Connections {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Connections").field("open", &self.open.keys()).finish_non_exhaustive()
    }
}

impl Connections {
    pub(crate) fn new(connect: Connect) -> Self {
        Self { connect, open: BTreeMap::new(), waited_for: JoinSet::new(), opened: 0 }
    }

    /// Sends a request over its connection.
    pub(crate) fn post(&mut self, post: Post) {
        let open = self.open.entry(post.connection).or_insert_with(|| {
            self.opened += 1;
            Open { step: (self.connect)(), waited_for: Vec::new() }
        });
        let (epoch, sequence) = (post.request.epoch, post.request.sequence);
        let answering = (open.step)(post.request);
        open.waited_for.retain(|request| !request.is_finished());
        open.waited_for.push(
            self.waited_for
                .spawn(async move { Answer { epoch, sequence, outcome: answering.await } }),
        );
    }

    /// Closes all connections older than `oldest`, and with them what they carry.
    pub(crate) fn close_before(&mut self, oldest: (u64, u64)) {
        while let Some(entry) = self.open.first_entry()
            && *entry.key() < oldest
        {
            entry.remove().waited_for.iter().for_each(AbortHandle::abort);
        }
    }

    /// The next answer. Waits for ever where there is nothing to wait for.
    pub(crate) async fn answer(&mut self) -> Answer {
        loop {
            match self.waited_for.join_next().await {
                Some(Ok(answer)) => return answer,
                // Closed with its connection; or it panicked, and counts as one that never comes.
                Some(Err(_)) => {}
                None => std::future::pending().await,
            }
        }
    }

    /// How many connections have been opened.
    pub(crate) fn opened(&self) -> u64 {
        self.opened
    }
}
