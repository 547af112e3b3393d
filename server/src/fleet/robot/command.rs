//! What may happen to a robot, and what it may be told.

use super::change::RobotChange;
use super::refusal::Refusal;
use std::sync::Arc;
use tokio::sync::oneshot;
use umwelt_api::step::Reply;
use umwelt_core::exchange::Request;

/// The answer to a step.
pub(crate) type StepResult = Result<Arc<Reply>, Refusal>;

/// What may happen to a robot.
#[derive(Debug)]
pub(crate) enum Event {
    /// Its agent sent a step.
    Step { request: Box<Request>, epoch: u64, reply: oneshot::Sender<StepResult> },
    /// Someone told it something; `done` once it shows.
    Command { command: Command, done: oneshot::Sender<()> },
    /// It has been silent for too long.
    Silence,
}

/// What a robot may be told.
#[derive(Debug)]
pub(crate) enum Command {
    /// Other settings or another task, kept under this revision.
    Change { change: RobotChange, revision: u64 },
    /// Look at the brake now: at the next step it looks anyway.
    Look,
    /// Forget what was learned.
    ResetEnvironment,
    /// Rest: the server shuts down.
    Drain,
    /// End.
    Remove,
    /// Compute: as long as a bug in core would.
    #[cfg(test)]
    Compute(Computation),
}

/// What a test lets a robot compute.
#[cfg(test)]
pub(crate) struct Computation(pub(crate) Box<dyn FnOnce() + Send>);

#[cfg(test)]
impl std::fmt::Debug for Computation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Computation")
    }
}
