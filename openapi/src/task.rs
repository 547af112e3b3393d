//! A task: where to go, and how far it has got.

use crate::body;
use crate::check::{Check, Range, Validate};
use crate::checked::Checked;
use crate::id::RobotId;
use crate::number;
use crate::problem::Problems;
use crate::robot_check::{Report, Wiggle};
use crate::schema::ToSchema;
use crate::square::{self, Square};
use crate::watch;
use serde::{Deserialize, Serialize};

/// Largest body of a task in bytes; [`MAX_WAYPOINTS`] with every digit have 66 kB.
pub const MAX_BODY: usize = 256 * 1024;
/// Most waypoints of a task.
pub const MAX_WAYPOINTS: usize = 1000;
/// Distance from a waypoint in m within which the robot of the thesis has arrived.
pub const DEFAULT_TOLERANCE: f64 = 0.010;
/// Ten kilometres from the origin f64 still resolves picometres, and no floor is larger.
pub const COORDINATE: Range = Range::new(-1e4, 1e4, "m");
/// Below 0.1 mm no pose is known; ten metres away is not there.
pub const TOLERANCE: Range = Range::new(1e-4, 10.0, "m");
/// A millimetre is less than robots of this class stray; ten kilometres is nowhere.
pub const MAX_DEVIATION: Range = Range::new(1e-3, 1e4, "m");
/// More rotations than this teach nothing.
pub const MAX_ROTATIONS: u64 = 1000;
/// From barely turning to more than any drive here does in place.
pub const ROTATION_SPEED: Range = Range::new(0.01, 10.0, "rad/s");
/// A rotation takes at least one slot and at most a minute.
pub const ROTATION_TIME: Range = Range::new(0.03, 60.0, "s");
/// A rest of a minute is not calibration any more.
pub const PAUSE: Range = Range::new(0.0, 60.0, "s");
/// The straight part needs room.
pub const STRAIGHT: Range = Range::new(0.0, 10.0, "m");

/// A place in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Waypoint)]
pub struct Waypoint {
    /// World x.
    pub x_m: f64,
    /// World y.
    pub y_m: f64,
}

impl Validate for Waypoint {
    fn check(&self, check: &mut Check) {
        check.number("x_m", self.x_m, COORDINATE);
        check.number("y_m", self.y_m, COORDINATE);
    }
}

/// Motion before a task from which the environment is learned: rotate, rest, repeated, then a straight part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = Calibration)]
pub struct Calibration {
    /// How often the robot rotates and rests, alternately left and right.
    pub rotations: u32,
    /// Angular velocity of the rotations.
    pub angular_rad_per_s: f64,
    /// Time of each rotation.
    pub rotate_s: f64,
    /// Time of each rest.
    pub pause_s: f64,
    /// Length of the straight part, driven forward and back; 0 where there is no room.
    pub straight_m: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { rotations: 10, angular_rad_per_s: 0.8, rotate_s: 0.9, pause_s: 0.3, straight_m: 0.3 }
    }
}

impl Validate for Calibration {
    fn check(&self, check: &mut Check) {
        check.integer("rotations", self.rotations.into(), 0..=MAX_ROTATIONS);
        check.number("angular_rad_per_s", self.angular_rad_per_s, ROTATION_SPEED);
        check.number("rotate_s", self.rotate_s, ROTATION_TIME);
        check.number("pause_s", self.pause_s, PAUSE);
        check.number("straight_m", self.straight_m, STRAIGHT);
    }
}

/// Where to go: waypoints in order, each a stop.
///
/// ```
/// use umwelt_api::task::Spec;
/// let spec = Spec::read(br#"{"waypoints": [{"x_m": 0.2, "y_m": 0.0}], "calibration": {}}"#)?;
/// assert_eq!(spec.to_core(0.01).calibration, Some(Default::default()));
///
/// let far = Spec::read(br#"{"waypoints": [{"x_m": 0.2, "y_m": 1e308}]}"#).unwrap_err();
/// assert_eq!(far.details()[0].field, "waypoints[0].y_m");
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TaskSpec)]
pub struct Spec {
    /// Places to stop at, at least one; none where the task is a check or a square. The first leg leads from where the robot
    /// stands to the first of them.
    pub waypoints: Vec<Waypoint>,
    /// Distance from a waypoint within which the robot has arrived. Null or left out: that of the robot
    /// (`steering.tolerance_m`).
    #[serde(default)]
    pub tolerance_m: Option<f64>,
    /// Whether the robot may drive in reverse toward a waypoint behind it; otherwise it turns to face it.
    #[serde(default)]
    #[schema(default = false)]
    pub reverse: bool,
    /// Motion before the task; none where it is null or left out, the default motion for `{}`.
    #[serde(default)]
    pub calibration: Option<Calibration>,
    /// Largest distance from the path before the robot rests. Null or left out: the length of the leg, at least ten track
    /// widths.
    #[serde(default)]
    pub max_deviation_m: Option<f64>,
    /// A wiggle in place of waypoints and calibration, which ends in a report of what is wrong with robot or tracker; the
    /// default one for `{}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub check: Option<Wiggle>,
    /// A square driven both ways in place of waypoints and calibration, which ends in a report of how wheels and track differ
    /// from the description; the default one for `{}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub square: Option<Square>,
}

impl Validate for Spec {
    fn check(&self, check: &mut Check) {
        check.length("waypoints", self.waypoints.len(), 0..=MAX_WAYPOINTS);
        check.items("waypoints", &self.waypoints);
        if let Some(tolerance) = self.tolerance_m {
            check.number("tolerance_m", tolerance, TOLERANCE);
        }
        if let Some(deviation) = self.max_deviation_m {
            check.number("max_deviation_m", deviation, MAX_DEVIATION);
        }
        if let Some(calibration) = &self.calibration {
            check.field("calibration", |check| calibration.check(check));
        }
        let count = self.waypoints.len();
        if self.check.is_none() && self.square.is_none() {
            let remedy = "say at least one, or a check, or a square";
            return check.agrees("waypoints", count > 0, count, remedy);
        }
        let is_way = count > 0 || self.calibration.is_some();
        if let Some(wiggle) = &self.check {
            check.field("check", |check| wiggle.check(check));
            let remedy = "leave out waypoints and calibration, or the check";
            check.agrees("check", !is_way, "beside", remedy);
        }
        if let Some(square) = &self.square {
            check.field("square", |check| square.check(check));
            let remedy = "leave out waypoints, calibration and check, or the square";
            check.agrees("square", !is_way && self.check.is_none(), "beside", remedy);
        }
    }
}

impl Spec {
    /// Reads the body of a PUT.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, values out of range.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read_shared(json)
    }
}

/// What a robot is doing about its task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = TaskStage)]
pub enum Stage {
    /// No task.
    Idle,
    /// Moving to learn the environment before the task, to be checked, or to be calibrated by a square.
    Calibrating,
    /// Turning in place toward the next waypoint.
    Turning,
    /// Driving to the next waypoint.
    Driving,
    /// At rest at a waypoint until it has been seen there.
    Stopping,
    /// At the last waypoint, or at the end of a check or a square: the task is done.
    Arrived,
}

/// How far a task has got.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TaskProgress)]
pub struct Progress {
    /// What the robot is doing.
    pub stage: Stage,
    /// Index of the waypoint it is heading for, or of the run of its square; their number once arrived.
    pub leg: usize,
    /// Number of waypoints, or of runs of a square.
    pub legs: usize,
    /// Distance of the last accepted pose from the current leg.
    #[serde(serialize_with = "number::finite")]
    pub deviation_m: f64,
    /// Largest such distance since the calibration ended.
    #[serde(serialize_with = "number::finite")]
    pub max_deviation_m: f64,
    /// Time since the calibration ended, until the arrival; 0 before.
    #[serde(serialize_with = "number::finite")]
    pub elapsed_s: f64,
    /// What limits the speed now; null where the robot is not to move.
    #[serde(default)]
    pub limited_by: Option<watch::Limit>,
    /// What the watch over commanded and seen motion finds; null where all is well. The robot says more: `robot.watch`.
    #[serde(default)]
    pub watch: Option<watch::State>,
}

/// The task of a robot and how far it has got.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Task)]
pub struct Task {
    /// Whose task it is.
    pub robot: RobotId,
    /// Where to go, all filled in.
    pub spec: Spec,
    /// How far it has got.
    pub progress: Progress,
    /// The report of a check that has ended; a server that was restarted since has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub check: Option<Report>,
    /// The report of a square that has ended; a server that was restarted since has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub square: Option<square::Report>,
    /// Version of the spec, for `If-Match`.
    pub etag: String,
}
