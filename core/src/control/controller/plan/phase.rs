//! The phases of a task.

use crate::geometry::Pose;
use crate::horizon::MAX_SLOTS;
use crate::task::{Stage, Task};
use crate::time::RobotTime;
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};

/// Slots at rest before a waypoint counts as reached.
pub const REST_SLOTS: u32 = 3;

/// Where in its task a robot is. Times are the robot's, so that a new plan may begin at any moment, not only where a
/// slot of the old one does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Phase {
    /// No task, or it was cancelled.
    #[default]
    Idle,
    /// At this part of a check's wiggle, since `since`: of a rest, since zero is commanded.
    Checking { part: u32, since: Option<RobotTime> },
    /// At this part of this run of a square, of which so much was `done` at `at`: s of a rest, m of a side, rad of a turn.
    Squaring { run: u32, part: u32, at: Option<RobotTime>, done: f64 },
    /// Turning in place at this level of a ramp of speeds, before a calibration, at that speed since `since`.
    Ramping { level: u32, since: Option<RobotTime> },
    /// Rotating and stopping for the `turn`th time, since `since`.
    Calibrating { turn: u32, since: Option<RobotTime> },
    /// The calibration's straight part, ahead of `origin` and back; at its end since `since`.
    Straight { outbound: bool, origin: Pose, since: Option<RobotTime> },
    /// At rest before the first leg, until the robot has been seen at rest: what it does then is known for certain.
    Settling,
    /// Turning toward waypoint `leg`, to the left (+1), to the right (-1) or not yet decided (0).
    Turning { leg: usize, side: i8 },
    /// Driving to waypoint `leg`.
    Driving { leg: usize },
    /// At waypoint `leg`, at rest since `since`.
    Stopping { leg: usize, since: Option<RobotTime> },
    /// At rest at the last waypoint, and seen there.
    Arrived,
}

impl Phase {
    /// The first phase of a task.
    pub fn first(task: &Task) -> Self {
        match task.calibration {
            _ if task.check.is_some() => Self::Checking { part: 0, since: None },
            _ if task.square.is_some() => Self::run_of_square(0),
            _ if task.waypoints.is_empty() => Self::Idle,
            Some(_) => Self::Calibrating { turn: 0, since: None },
            None => Self::Settling,
        }
    }

    /// The beginning of a run of a square.
    pub fn run_of_square(run: u32) -> Self {
        Self::Squaring { run, part: 0, at: None, done: 0.0 }
    }

    /// Whether the motion is open loop: how sure the pose is does not matter to it.
    pub fn is_open_loop(self) -> bool {
        matches!(self, Self::Checking { .. } | Self::Squaring { .. } | Self::Ramping { .. })
    }

    /// The waypoint that the robot is heading for, once its calibration is over.
    pub fn leg(self) -> Option<usize> {
        match self {
            Self::Turning { leg, .. } | Self::Driving { leg } | Self::Stopping { leg, .. } => {
                Some(leg)
            }
            _ => None,
        }
    }

    /// The same phase taken up again after a pause of unknown motion.
    pub fn resumed(self) -> Self {
        match self {
            Self::Driving { leg } | Self::Turning { leg, .. } => Self::Turning { leg, side: 0 },
            Self::Stopping { leg, .. } => Self::Stopping { leg, since: None },
            // Its parts mean nothing without those before them.
            Self::Checking { .. } => Self::Checking { part: 0, since: None },
            Self::Squaring { run, .. } => Self::run_of_square(run),
            Self::Ramping { level, .. } => Self::Ramping { level, since: None },
            Self::Calibrating { turn, .. } => Self::Calibrating { turn, since: None },
            Self::Straight { outbound, origin, .. } => {
                Self::Straight { outbound, origin, since: None }
            }
            Self::Idle | Self::Settling | Self::Arrived => self,
        }
    }

    /// As it is shown.
    pub fn stage(self) -> Stage {
        match self {
            Self::Idle => Stage::Idle,
            Self::Checking { .. }
            | Self::Squaring { .. }
            | Self::Ramping { .. }
            | Self::Calibrating { .. }
            | Self::Straight { .. } => Stage::Calibrating,
            Self::Turning { .. } => Stage::Turning,
            Self::Driving { .. } => Stage::Driving,
            Self::Settling | Self::Stopping { .. } => Stage::Stopping,
            Self::Arrived => Stage::Arrived,
        }
    }
}

/// The phase at the beginning of each slot of a plan, and at the end of the last: at least two.
pub type Phases = ArrayVec<Phase, { MAX_SLOTS + 1 }>;
