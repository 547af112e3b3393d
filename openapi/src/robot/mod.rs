//! A robot: what is said about it once, and how it is now.

mod choice;
mod description;
mod drive;
mod patch;
mod prior;
mod spec;

pub use crate::page::{DEFAULT_PAGE_SIZE, MAX_PAGE_SIZE, MAX_PAGE_TOKEN};
pub use choice::{Attribution, CELL, Kind, MAX_AGENTS, MAX_INTEGER, Method, Predictor};
#[cfg(feature = "core")]
pub(crate) use description::Said;
pub use description::{DERIVED, Description, IDENTIFIED, NOISE};
pub use drive::{
    ANGULAR_ACCELERATION, ANGULAR_SPEED, Drive, HEADING_NOISE, LAG, LINEAR_ACCELERATION,
    LINEAR_SPEED, Noise, POSITION_NOISE, SIDEWAYS, TRACK_WIDTH, TURN_BY_SPEED, TURN_CHANGE,
    WHEEL_RADIUS, WHEEL_SPEED,
};
pub use patch::Patch;
pub use prior::{ChannelPrior, DEFAULT_PRIOR, MU, Prior, PriorChoice, SUM_OF_SQUARES, WEIGHT};
pub use spec::{
    ALPHA, HEADING_VARIANCE, LOOP_DELAY, MAX_SLOTS, MIN_WATCHDOG, POSITION_VARIANCE, SENSOR_DELAY,
    STOP_RADIUS, Spec, Steering, TURN, VarianceLimits, WATCHDOG,
};

use crate::id::RobotId;
use crate::number;
use crate::page::Unreadable;
use crate::schema::ToSchema;
use crate::task;
use crate::watch::Watch;
use serde::{Deserialize, Serialize};

/// Largest body of a description in bytes; a full one has 2 kB.
pub const MAX_BODY: usize = 64 * 1024;

/// Whether the robot is heard from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = RobotState)]
pub enum State {
    /// It has never sent a step to this server.
    Never,
    /// It sends steps.
    Connected,
    /// It has sent steps and has fallen silent; its last pose stays.
    Lost,
    /// What the server computes for it does not end: it is not answered and stops by itself.
    Failed,
}

impl State {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Never => "never",
            Self::Connected => "connected",
            Self::Lost => "lost",
            Self::Failed => "failed",
        }
    }
}

/// A robot as it is now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Robot)]
pub struct Robot {
    /// Its id.
    pub robot: RobotId,
    /// What was said about it, all filled in.
    pub spec: Spec,
    /// What was said about it and no more: the rest of `spec` is default, or follows from this.
    #[serde(default)]
    #[schema(value_type = Spec)]
    pub described: Description,
    /// Whether it is heard from.
    pub state: State,
    /// Time since its last step; null before the first.
    pub last_seen_s_ago: Option<f64>,
    /// Whether it is told to rest until it is resumed.
    pub stopped: bool,
    /// Whether the robot itself holds: a bumper, a lidar field, an e-stop button. It goes on by itself.
    #[serde(default)]
    pub held: bool,
    /// Largest speed that the robot itself allows for now; null for that of its drive.
    #[serde(default)]
    pub max_speed_m_per_s: Option<f64>,
    /// The last accepted pose; null before the first.
    pub pose: Option<Pose>,
    /// Age of that pose; it grows while no other is accepted. Null before the first.
    #[serde(default)]
    pub pose_age_s: Option<f64>,
    /// What the watch over commanded and seen motion finds; null where all is well.
    #[serde(default)]
    pub watch: Option<Watch>,
    /// How far its task has got; null without a task.
    pub task: Option<task::Progress>,
    /// The epoch of its agent; null before the first step.
    pub epoch: Option<u64>,
    /// Median time from a pose being taken to its reply arriving; null before the first delivery.
    pub loop_delay_median_s: Option<f64>,
    /// Version of the spec, for `If-Match`.
    pub etag: String,
}

/// A pose in the world and the robot's own time at which it was taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Pose)]
pub struct Pose {
    /// World x.
    #[serde(serialize_with = "number::finite")]
    pub x_m: f64,
    /// World y.
    #[serde(serialize_with = "number::finite")]
    pub y_m: f64,
    /// Counter-clockwise from world x, in (-pi, pi].
    #[serde(serialize_with = "number::finite")]
    pub heading_rad: f64,
    /// Robot time at which it was taken.
    #[serde(serialize_with = "number::finite")]
    pub taken_s: f64,
}

/// Some of the robots, in the order of their ids.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RobotPage)]
pub struct Page {
    /// The robots.
    pub robots: Vec<Robot>,
    /// Those that cannot be read, in the same part of the list; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unreadable: Vec<Unreadable>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}
