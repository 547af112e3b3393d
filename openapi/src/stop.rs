//! Stopping and resuming. It acts on the next exchange; the task is kept.

use crate::id::RobotId;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// The answer to stopping or resuming one robot.
///
/// ```
/// use umwelt_api::stop::Stop;
/// let of_an_earlier_server: Stop = serde_json::from_str(r#"{"robot": "rover-7", "stopped": true}"#)?;
/// assert!(of_an_earlier_server.kept);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Stop)]
pub struct Stop {
    /// The robot.
    pub robot: RobotId,
    /// Whether it is told to rest now.
    pub stopped: bool,
    /// Whether that is kept: false where the disk did not take it in time. It holds all the same, but a restart before
    /// the server has made up for it would let the robot go on.
    #[serde(default = "as_always")]
    pub kept: bool,
}

/// The answer to stopping or resuming all robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = StopAll)]
pub struct StopAll {
    /// How many robots there are; all of them were told.
    pub robots: usize,
    /// Whether they are told to rest now.
    pub stopped: bool,
    /// Whether that is kept, as for one.
    #[serde(default = "as_always")]
    pub kept: bool,
}

/// Servers that do not say it answer only what they have tried to keep.
fn as_always() -> bool {
    true
}
