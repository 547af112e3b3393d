//! What a run shows while it goes on, and how it ended.

use crate::drive::DriveError;
use crate::told::Difference;
use umwelt_client::api::RobotId;
use umwelt_client::api::task::Stage;
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::link::LinkError;

/// The robot at one moment, for a live table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Status {
    /// Robot time in s.
    pub time: f64,
    /// Where the robot truly is; only a simulated one knows.
    pub pose: Option<Pose>,
    /// The last observed pose.
    pub observed: Option<Observation>,
    /// The wheel speeds that are applied.
    pub applied: WheelSpeeds,
    /// Loop delay in s of the last reply: its pose being taken to its arrival.
    pub loop_delay: Option<f64>,
    /// Whether replies come.
    pub connected: bool,
    /// What the server says the robot is doing about its task.
    pub stage: Option<Stage>,
    /// Whether the server tells the robot to rest until it is resumed.
    pub stopped: bool,
    /// Whether the robot itself holds.
    pub held: bool,
}

/// One moment of a run: at each change of wheel speeds, and at least once per slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceRow {
    /// Robot time in s.
    pub time: f64,
    /// Where the robot truly is; only a simulated one knows.
    pub pose: Option<Pose>,
    /// The wheel speeds that are applied from now on.
    pub applied: WheelSpeeds,
}

/// Takes the rows of a trace as they come; it must not block.
pub type TraceSink = Box<dyn FnMut(&TraceRow) + Send>;

/// Why a run ended as it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It was told to.
    Shutdown,
    /// Its time was over.
    Duration,
    /// No more poses come.
    NoMorePoses,
}

/// How a run ended: always with the robot at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Why it ended.
    pub ended: Ended,
    /// Robot time in s at which the robot was at rest.
    pub time: f64,
    /// Requests sent.
    pub requests: u64,
    /// Replies that brought a horizon.
    pub replies: u64,
    /// Connections opened.
    pub connections: u64,
}

/// Why a run failed. The robot is at rest all the same, unless its drive is what failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AgentError {
    /// Another agent drives this robot now.
    #[error(
        "another agent has taken over robot {robot}: this one has stopped. End the other one, then start again"
    )]
    Superseded {
        /// The robot.
        robot: RobotId,
    },
    /// The server has never known this robot.
    #[error(
        "the server does not know robot {robot}. Register it with `umwelt robot add {robot}`, then start again"
    )]
    Unregistered {
        /// The robot.
        robot: RobotId,
    },
    /// Agent and server were told different drives.
    #[error(
        "robot {robot} is described otherwise than this agent was told: {}. Leave the flags out, or describe the robot \
         so: umwelt robot set {robot}{}",
        listed(.differences),
        flags(.differences)
    )]
    OtherDrive {
        /// The robot.
        robot: RobotId,
        /// What differs.
        differences: Vec<Difference>,
    },
    /// The drive no longer does what it is told.
    #[error("{0}")]
    Drive(#[from] DriveError),
    /// The link to simulate means nothing.
    #[error("link: {0}")]
    Link(#[from] LinkError),
}

fn listed(differences: &[Difference]) -> String {
    let said: Vec<_> = differences.iter().map(ToString::to_string).collect();
    said.join(", ")
}

fn flags(differences: &[Difference]) -> String {
    differences.iter().map(|it| format!(" --{} {}", it.flag, it.here)).collect()
}
