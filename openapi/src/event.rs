//! What happens, as server-sent events.
//!
//! Each event is one `data:` line of JSON ([`Event`]); its `id:` is [`Event::id`], its `event:` is
//! [`Kind::name`]. A stream resumes behind the id in `Last-Event-ID`; where the server has forgotten some of the
//! events since, it says so with [`Kind::Missed`].

use crate::environment::Environment;
use crate::id::RobotId;
use crate::number;
use crate::robot::{Pose, State};
use crate::schema::ToSchema;
use crate::step::Horizon;
use crate::task::Progress;
use crate::watch::{self, Watch};
use serde::{Deserialize, Serialize};

/// Something that happened.
///
/// ```
/// use umwelt_api::event::{Event, Kind};
/// let event = Event { id: 7, robot: Some("rover-7".parse()?), kind: Kind::WaypointReached { leg: 1 } };
/// let json = serde_json::to_string(&event)?;
/// assert_eq!(json, r#"{"id":7,"robot":"rover-7","type":"waypoint_reached","leg":1}"#);
///
/// let later = r#"{"id": 8, "robot": "rover-7", "type": "of-tomorrow", "much": 1}"#;
/// assert_eq!(serde_json::from_str::<Event>(later)?.kind, Kind::Other);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Event)]
pub struct Event {
    /// Number of the event on this server, strictly increasing.
    pub id: u64,
    /// The robot to which it happened; null where it concerns the stream.
    pub robot: Option<RobotId>,
    /// What happened.
    #[serde(flatten)]
    pub kind: Kind,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = EventKind)]
pub enum Kind {
    /// The robot was described, for the first time or anew.
    Registered,
    /// The robot was removed.
    Removed,
    /// A pose was accepted.
    Pose(Pose),
    /// A pose was set aside because the robot cannot have moved there.
    PoseSetAside(Pose),
    /// Poses that had been set aside agree with each other and are believed again.
    PoseBelievedAgain,
    /// A horizon was sent.
    Horizon(Horizon),
    /// The identified environment changed.
    Environment(Box<Environment>),
    /// The task was set, replaced or cancelled, or got further.
    Task(Progress),
    /// The robot was heard from again or fell silent.
    Link {
        /// How it is now.
        state: State,
    },
    /// An agent took the robot over: it restarted, or there is a second one.
    Epoch {
        /// The epoch that holds from now on.
        epoch: u64,
    },
    /// The calibration is over and the task begins.
    CalibrationEnded,
    /// The robot has been seen at rest at a waypoint.
    WaypointReached {
        /// Index of the waypoint.
        leg: usize,
    },
    /// The robot has been seen at rest at the last waypoint.
    Arrived {
        /// Time of the task without its calibration.
        #[serde(serialize_with = "number::finite")]
        elapsed_s: f64,
        /// Largest distance from the path.
        #[serde(serialize_with = "number::finite")]
        max_deviation_m: f64,
    },
    /// The robot was told to rest until it is resumed.
    Stopped,
    /// The robot was told to go on.
    Resumed,
    /// The watch over commanded and seen motion found something.
    Watch(Watch),
    /// What the watch had found is over by itself.
    WatchOver {
        /// What it was.
        state: watch::State,
    },
    /// The robot itself holds: it rests until it says otherwise.
    Held,
    /// The robot itself no longer holds: it goes on.
    Released,
    /// The server has forgotten events between `Last-Event-ID` and the next one.
    Missed,
    /// Something of a later version.
    #[serde(other, skip_serializing)]
    Other,
}

impl Kind {
    /// The value of `type`, and of `event:` in the stream.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Registered => "registered",
            Self::Removed => "removed",
            Self::Pose(_) => "pose",
            Self::PoseSetAside(_) => "pose_set_aside",
            Self::PoseBelievedAgain => "pose_believed_again",
            Self::Horizon(_) => "horizon",
            Self::Environment(_) => "environment",
            Self::Task(_) => "task",
            Self::Link { .. } => "link",
            Self::Epoch { .. } => "epoch",
            Self::CalibrationEnded => "calibration_ended",
            Self::WaypointReached { .. } => "waypoint_reached",
            Self::Arrived { .. } => "arrived",
            Self::Stopped => "stopped",
            Self::Resumed => "resumed",
            Self::Watch(_) => "watch",
            Self::WatchOver { .. } => "watch_over",
            Self::Held => "held",
            Self::Released => "released",
            Self::Missed => "missed",
            Self::Other => "other",
        }
    }
}
