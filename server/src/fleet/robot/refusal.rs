//! Why a step is not answered, and what its sender is told.

use crate::resource::failure::Failure;
use umwelt_api::problem::{Detail, Status, reason};

/// Why a request is not answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Refusal {
    /// Another epoch has taken over.
    Superseded {
        /// The epoch of the request.
        epoch: u64,
    },
    /// The robot's clock ran backwards within the epoch.
    ClockWentBack {
        /// When the request was sent, in robot time.
        sent: f64,
        /// When the newest one was.
        newest: f64,
    },
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Superseded { epoch } => {
                let remedy =
                    "another agent drives this robot now: stop one of them; a restart takes over";
                Self::new(Status::Aborted, "another agent has taken the robot over")
                    .with(Detail::new(reason::EPOCH_SUPERSEDED, "epoch", epoch, remedy))
            }
            Refusal::ClockWentBack { sent, newest } => {
                let message = format!("the robot's clock went back from {newest} s to {sent} s");
                let remedy = "begin a new epoch when the clock restarts";
                Self::new(Status::FailedPrecondition, message).with(Detail::new(
                    reason::CLOCK_WENT_BACK,
                    "sent_s",
                    sent,
                    remedy,
                ))
            }
        }
    }
}
