//! A task: where to go, and how far it has got.

use super::condition::Condition;
use crate::geometry::Point;

/// Most waypoints of one task.
pub const MAX_WAYPOINTS: usize = 1000;

/// Track widths from its path that a robot may always stray, where its task does not say otherwise.
const DEVIATION_TRACKS: f64 = 10.0;

/// Default distance in m from a waypoint within which the robot has arrived.
pub const TOLERANCE: f64 = 0.010;

/// Motion before a task from which the environment is learned: rotate, stop, repeated, then a straight part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// How often the robot rotates and stops, alternately left and right (the thesis: 10). At most 1000.
    pub rotations: u32,
    /// Angular velocity of the rotations in rad/s.
    pub angular: f64,
    /// Time of each rotation in s.
    pub rotate: f64,
    /// Time of each stop in s.
    pub pause: f64,
    /// Length in m of the straight part, driven forward and back; 0 where there is no room.
    pub straight: f64,
}

impl Default for Calibration {
    /// Ten rotations of 0.9 s at 0.8 rad/s, each long enough for a few windows at constant speed, and 0.3 m straight.
    fn default() -> Self {
        Self { rotations: 10, angular: 0.8, rotate: 0.9, pause: 0.3, straight: 0.3 }
    }
}

/// A wiggle by which is found what is wrong with robot or tracker: see [`crate::check`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// Speed of turns and drives as a part of the largest one of the drive; what is faster than the check needs is slowed
    /// down.
    pub speed: f64,
    /// Time in s of the rest before the first motion, from which the noise of the poses is known.
    pub rest: f64,
    /// Time in s of a turn in place; the one in the middle takes twice as long.
    pub turn: f64,
    /// Time in s of each drive forward or back.
    pub drive: f64,
    /// Time in s of the rest between two motions.
    pub pause: f64,
}

impl Default for Check {
    /// Some 20 s in all.
    fn default() -> Self {
        Self { speed: 0.7, rest: 2.0, turn: 2.0, drive: 1.2, pause: 0.6 }
    }
}

/// Most runs each way of a square: their mean is known to less than half of what a single one is.
pub const MAX_RUNS: u32 = 5;

/// A square driven both ways, whose return errors show how wheels and track differ from the description: see
/// [`crate::square`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Length of a side in m; none for one that follows from the robot.
    pub side: Option<f64>,
    /// Runs each way, 1..=[`MAX_RUNS`].
    pub runs: u32,
    /// Speed of sides and turns as a part of the largest one of the drive.
    pub speed: f64,
}

impl Default for Square {
    /// One run each way, as fast as a [`Check`] goes at most.
    fn default() -> Self {
        Self { side: None, runs: 1, speed: 0.7 }
    }
}

/// Waypoints to visit in order, each a stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Points to stop at, at least one; none where the task is a check or a square. The path is the straight segments between them; the first leg leads from
    /// where the robot stands when the task begins to the first point (at once where it stands on it).
    pub waypoints: Vec<Point>,
    /// Distance in m from a waypoint within which the robot has arrived.
    pub tolerance: f64,
    /// Whether the robot may drive in reverse toward a waypoint behind it; otherwise it turns to face it.
    pub reverse: bool,
    /// Motion before the task; none where the environment is known well enough.
    pub calibration: Option<Calibration>,
    /// Largest distance in m from the path before the robot rests; none for [`Task::default_deviation`].
    pub max_deviation: Option<f64>,
    /// The wiggle that the task is, in place of a way to waypoints.
    pub check: Option<Check>,
    /// The square that the task is, in place of a way to waypoints.
    pub square: Option<Square>,
}

impl Task {
    /// The task that is a check.
    pub fn checking(check: Check) -> Self {
        Self { waypoints: Vec::new(), calibration: None, check: Some(check), ..Self::thesis() }
    }

    /// The task that is a square.
    pub fn squaring(square: Square) -> Self {
        Self { waypoints: Vec::new(), calibration: None, square: Some(square), ..Self::thesis() }
    }

    /// Largest distance in m from a leg of `length` m where the task says none: a robot of track `track` m that is
    /// farther from its leg than the leg is long does not follow it; short legs leave room to turn and recover.
    pub fn default_deviation(length: f64, track: f64) -> f64 {
        length.max(DEVIATION_TRACKS * track)
    }

    /// The task of the thesis's simulation, (0,0) -> (0.2,0) -> (-0.5,0) m, with its calibration.
    pub fn thesis() -> Self {
        Self {
            waypoints: vec![Point::new(0.0, 0.0), Point::new(0.2, 0.0), Point::new(-0.5, 0.0)],
            tolerance: TOLERANCE,
            reverse: false,
            calibration: Some(Calibration::default()),
            max_deviation: None,
            check: None,
            square: None,
        }
    }
}

/// What a robot is doing about its task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// At the last waypoint: the task is done.
    Arrived,
}

/// What limits a robot's speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The largest speeds of the drive.
    Drive,
    /// The steering law's speed, alpha.
    Alpha,
    /// The waypoint or direction at which it is to stop.
    Waypoint,
    /// The largest acceleration.
    Acceleration,
    /// The predicted variance of the pose.
    Variance,
    /// The watch: the robot is to rest, or a smallest speed was raised.
    Watch,
    /// The robot itself, which says hold or a smaller largest speed.
    Hold,
}

/// How far a task has got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What the robot is doing.
    pub stage: Stage,
    /// Index of the waypoint it is heading for, or of the run of its square; their number once arrived.
    pub leg: usize,
    /// Number of waypoints, or of runs of a square.
    pub legs: usize,
    /// Distance in m of the last accepted pose from the current leg.
    pub deviation: f64,
    /// Largest such distance since the calibration ended, in m.
    pub max_deviation: f64,
    /// Time in s since the calibration ended, until the arrival; 0 before.
    pub elapsed: f64,
    /// What limits the speed at the start of the newest horizon; none where the robot is not to move.
    pub limited_by: Option<Limit>,
    /// What the watch finds.
    pub watch: Option<Condition>,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            stage: Stage::Idle,
            leg: 0,
            legs: 0,
            deviation: 0.0,
            max_deviation: 0.0,
            elapsed: 0.0,
            limited_by: None,
            watch: None,
        }
    }
}
