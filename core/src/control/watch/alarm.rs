//! What the watch may find: conditions with the numbers seen, and what to do about each, in words.

use super::fit::Fit;
use crate::control::condition::Condition;
use serde::{Deserialize, Serialize};

/// A motion commanded and what was seen of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Whether the robot was turning in place: motions are in rad then, else in m.
    pub turning: bool,
    /// What was commanded.
    pub commanded: f64,
    /// What was seen in the commanded direction.
    pub seen: f64,
    /// Time in s that it took.
    pub span: f64,
}

/// What about the samples cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Oddity {
    /// The forward ratio's mean lies at its clamp.
    ForwardMean(f64),
    /// The turn ratio's mean lies at its clamp.
    TurnMean(f64),
    /// The sideways ratio's mean lies at its clamp.
    LateralMean(f64),
    /// The forward ratio's standard deviation over 100 ms.
    ForwardSpread(f64),
    /// The turn ratio's standard deviation over 100 ms.
    TurnSpread(f64),
    /// Motion of the tracked point in m per radian turned in place.
    ShiftPerRadian(f64),
    /// Turning in place turns the robot by half, about one wheel: the wheel stands.
    OneWheel {
        /// Whether it is the left one.
        left: bool,
    },
}

/// What was found, with the numbers seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alarm {
    /// See [`Condition::Stuck`].
    Stuck(Compared),
    /// See [`Condition::Frozen`].
    Frozen {
        /// Equal poses in a row.
        poses: u32,
        /// Time in s commanded to move meanwhile.
        span: f64,
    },
    /// See [`Condition::NoPoses`].
    NoPoses {
        /// Age of the newest accepted pose in s when the robot was commanded to rest; none before the first pose.
        age: Option<f64>,
    },
    /// See [`Condition::FrameMismatch`].
    FrameMismatch {
        /// What was compared.
        compared: Compared,
        /// What explains it best.
        fit: Fit,
    },
    /// See [`Condition::OffPath`].
    OffPath {
        /// Distance in m from the path.
        deviation: f64,
        /// Largest distance allowed, in m.
        limit: f64,
    },
    /// See [`Condition::Jumping`].
    Jumping {
        /// Poses that jumped or were set aside.
        jumps: u32,
        /// Of so many.
        of: u32,
    },
    /// See [`Condition::NotAsDescribed`].
    NotAsDescribed(Oddity),
    /// See [`Condition::Raised`].
    Raised {
        /// Whether it is the turn in place that was raised: speeds are in rad/s then, else in m/s.
        turning: bool,
        /// Fastest speed at which the robot stood.
        stood: f64,
        /// The smallest speed from now on.
        least: f64,
    },
}

impl Alarm {
    /// Its name.
    pub fn condition(&self) -> Condition {
        match self {
            Self::Stuck(_) => Condition::Stuck,
            Self::Frozen { .. } => Condition::Frozen,
            Self::NoPoses { .. } => Condition::NoPoses,
            Self::FrameMismatch { .. } => Condition::FrameMismatch,
            Self::OffPath { .. } => Condition::OffPath,
            Self::Jumping { .. } => Condition::Jumping,
            Self::NotAsDescribed(_) => Condition::NotAsDescribed,
            Self::Raised { .. } => Condition::Raised,
        }
    }

    /// What was seen, in words and numbers.
    pub fn seen(&self) -> String {
        match *self {
            Self::Stuck(compared) => compared.words(),
            Self::Frozen { poses, span } => {
                format!("{poses} equal poses in a row while commanded to move for {span:.1} s")
            }
            Self::NoPoses { age: Some(age) } => {
                format!("the newest accepted pose is {age:.1} s old")
            }
            Self::NoPoses { age: None } => "no pose has been accepted yet".to_owned(),
            Self::FrameMismatch { compared, fit } => {
                format!("{}: {}", compared.words(), fit.words())
            }
            Self::OffPath { deviation, limit } => {
                format!("{deviation:.3} m from the path, {limit:.3} m are allowed")
            }
            Self::Jumping { jumps, of } => {
                format!("{jumps} of the last {of} poses jumped or were set aside")
            }
            Self::NotAsDescribed(oddity) => oddity.words(),
            Self::Raised { turning, stood, least } => {
                let unit = if turning { "rad/s" } else { "m/s" };
                format!(
                    "the robot did not move at {stood:.3} {unit}; the smallest speed is now {least:.3} {unit}"
                )
            }
        }
    }

    /// What to do about it, in words.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Stuck(_) => "free the robot, check motors and emergency stop, then resume",
            Self::Frozen { .. } => {
                "the tracker repeats its last pose: have it send nothing when it does not see the robot; then resume"
            }
            Self::NoPoses { .. } => {
                "check the camera and the way from it to the agent; the robot goes on by itself when poses come"
            }
            Self::FrameMismatch { fit, .. } => fit.remedy(),
            Self::OffPath { .. } => {
                "bring the robot back to its path or raise max_deviation_m of the task, then resume"
            }
            Self::Jumping { .. } => {
                "check the tracker: two solutions of a tag, two robots with one id, or noise far above noise.position_m"
            }
            Self::NotAsDescribed(oddity) => oddity.remedy(),
            Self::Raised { turning: true, .. } => {
                "describe it: the least speed at which it turns in place is drive.min_angular_rad_per_s"
            }
            Self::Raised { turning: false, .. } => {
                "describe it: the least speed at which it drives is drive.min_linear_m_per_s"
            }
        }
    }
}

impl Compared {
    fn words(self) -> String {
        let Self { turning, commanded, seen, span } = self;
        let unit = if turning { "rad" } else { "m" };
        format!("commanded {commanded:.3} {unit} in {span:.1} s, seen {seen:.3} {unit} that way")
    }
}

impl Oddity {
    fn words(self) -> String {
        match self {
            Self::ForwardMean(mean) => {
                format!("drives {:+.0} % of what is commanded", 100.0 * mean)
            }
            Self::TurnMean(mean) => format!("turns {:+.0} % of what is commanded", 100.0 * mean),
            Self::LateralMean(mean) => {
                format!("moves sideways by {:+.0} % of what it drives", 100.0 * mean)
            }
            Self::ForwardSpread(sd) => {
                format!(
                    "motion forward differs from the commands by {:.0} %, each 100 ms",
                    100.0 * sd
                )
            }
            Self::TurnSpread(sd) => {
                format!("turns differ from the commands by {:.0} %, each 100 ms", 100.0 * sd)
            }
            Self::ShiftPerRadian(shift) => {
                format!("turning in place moves it by {shift:.3} m per radian")
            }
            Self::OneWheel { left } => {
                let wheel = if left { "left" } else { "right" };
                format!("it turns by half of what is commanded, about its {wheel} wheel")
            }
        }
    }

    fn remedy(self) -> &'static str {
        match self {
            Self::ForwardMean(_) => "check drive.wheel_radius_m and the floor",
            Self::TurnMean(_) => {
                "check drive.track_width_m; a skid-steered robot turns less than its track says"
            }
            Self::LateralMean(_) => {
                "check that the tracker's heading points where the robot drives"
            }
            Self::ForwardSpread(_) | Self::TurnSpread(_) => {
                "describe the camera's noise (noise.position_m, noise.heading_rad) and the drive's lag_s and dead_time_s"
            }
            Self::ShiftPerRadian(_) => {
                "track the middle between the wheels, have the tracker correct for where its marker sits, or describe a skid-steered robot as one"
            }
            Self::OneWheel { left: true } => "check the left wheel's motor, driver and plug",
            Self::OneWheel { left: false } => "check the right wheel's motor, driver and plug",
        }
    }
}
