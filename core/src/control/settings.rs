//! The settings of a robot's controller: drive, noise, method, prior, horizon, limits of variance.

use crate::conjugate::NormalInverseChiSquared;
pub use crate::exchange::PoseNoise;
use crate::horizon::{SLOT, WATCHDOG};
use crate::kinematics::Drive;
use crate::task::TOLERANCE;
use serde::{Deserialize, Serialize};

/// How the environment is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The error distribution measured once on the normal link, never updated.
    FixedNormal,
    /// The error distribution measured once on the bad link, never updated.
    FixedBad,
    /// Samples only: their mean and variance; fixed-normal below two samples.
    Statistic,
    /// Prior and samples: the thesis's method.
    Bayesian,
    /// The same with a mixture of priors, whose spread yields to samples, and beside it the scale of the drive, which is
    /// identified by itself and by which commands are corrected.
    Adaptive,
}

impl Method {
    /// Every method, in the order in which they are shown.
    pub const ALL: [Self; 5] =
        [Self::FixedNormal, Self::FixedBad, Self::Statistic, Self::Bayesian, Self::Adaptive];

    /// The name used on the wire and on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::FixedNormal => "fixed-normal",
            Self::FixedBad => "fixed-bad",
            Self::Statistic => "statistic",
            Self::Bayesian => "bayesian",
            Self::Adaptive => "adaptive",
        }
    }
}

/// What an observed motion is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attribution {
    /// The commands as sent, in force from pose time + nominal loop delay: a late packet shows as a control error.
    Sent,
    /// The commands as the robot reports to have played them: link trouble and floor trouble come apart.
    Played,
}

/// How the pose at the time of a command is predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PredictorKind {
    /// Mean and covariance propagated in closed form.
    Moments,
    /// The thesis's Monte Carlo: agents counted in a table of cells.
    MonteCarlo {
        /// Number of agents (E of the thesis), 1..=10 000.
        agents: usize,
        /// Edge of a cell in m; a cell of the heading is as many rad per 0.1 m.
        cell: f64,
        /// Seed of the agents' errors.
        seed: u64,
    },
}

/// Belief about each channel's error ratio before any sample.
///
/// Each sigma^2 is the variance of the ratio over 100 ms at constant speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// Forward error per metre commanded.
    pub forward: NormalInverseChiSquared,
    /// Lateral error per metre commanded.
    pub lateral: NormalInverseChiSquared,
    /// Heading error per radian commanded.
    pub turn: NormalInverseChiSquared,
    /// Heading error in rad per metre commanded; used where `Settings::drift` is on.
    pub drift: NormalInverseChiSquared,
}

/// Largest predicted variance of a pose at which a robot may move as it likes (thesis table 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VarianceLimits {
    /// Variance of the position in m^2, in its worst direction.
    pub position: f64,
    /// Variance of the heading in rad^2.
    pub heading: f64,
}

impl Default for VarianceLimits {
    fn default() -> Self {
        Self { position: 1e-4, heading: 0.10 }
    }
}

/// Settings of the steering law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteeringSettings {
    /// Speed in m/s of the law on a straight line (alpha of thesis eq. 18, a constant it does not give).
    pub alpha: f64,
    /// Distance in m to the waypoint at which the robot stops.
    pub stop_radius: f64,
    /// Distance in m from a waypoint within which the robot has arrived, where its task says none.
    pub tolerance: f64,
    /// Heading error in rad that is good enough to drive: above the smallest angular velocity times the spread
    /// of the delay (0.2 rad/s x 0.4 s), or the robot hunts.
    pub turn_tolerance: f64,
    /// Heading error in rad at which a driving robot stops to turn in place.
    pub turn_beyond: f64,
}

impl Default for SteeringSettings {
    fn default() -> Self {
        Self {
            alpha: 0.2,
            stop_radius: 0.002,
            tolerance: TOLERANCE,
            turn_tolerance: 0.10,
            turn_beyond: 0.6,
        }
    }
}

/// Which of the settings follow the link as it is identified: those that were not said. None for the thesis, which knows
/// its link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FollowsLink {
    /// The loop delay: the median of the recent ones.
    pub loop_delay: bool,
    /// The number of slots, as it follows from the loop delay.
    pub slots: bool,
    /// The watchdog, as it follows from the loop delay.
    pub watchdog: bool,
}

/// The settings of a robot's controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The robot's drive.
    pub drive: Drive,
    /// Whether its dead time and lag are identified, because neither was said; what `drive` has is then what is expected
    /// before any sample. Not for the thesis, whose robot follows at once.
    pub identifies_lag: bool,
    /// Whether the speed below which its wheels do not turn is identified with its drive, because no smallest speed was said.
    pub identifies_dead_band: bool,
    /// Known noise of its observed poses.
    pub noise: PoseNoise,
    /// Whether that is identified, because it was not said; `noise` is then what is expected before any pose.
    pub identifies_noise: bool,
    /// How the environment is identified.
    pub method: Method,
    /// Belief before any sample.
    pub prior: Prior,
    /// What errors are measured against.
    pub attribution: Attribution,
    /// Whether the drift channel (heading per metre) is used; off in the thesis.
    pub drift: bool,
    /// Slots per horizon, 1..=`MAX_SLOTS`; 1 is the thesis.
    pub slots: usize,
    /// Length of a slot in s.
    pub slot: f64,
    /// Nominal time in s from a pose being taken to its reply being applied; where the link is followed, until it is known.
    pub loop_delay: f64,
    /// What follows the link as it is identified.
    pub follows_link: FollowsLink,
    /// Time in s from a pose being taken to the stamp that it comes with: of a camera that stamps late, or not at all.
    pub sensor_delay: f64,
    /// Time in s for which the robot holds the last entry of a horizon; 0 for ever.
    pub watchdog: f64,
    /// How poses are predicted.
    pub predictor: PredictorKind,
    /// Limits of the predicted variance.
    pub variance: VarianceLimits,
    /// The steering law.
    pub steering: SteeringSettings,
}

impl Settings {
    /// Whether the drift channel is used: by itself where it is identified with the drive.
    pub fn uses_drift(&self) -> bool {
        self.drift || self.method == Method::Adaptive
    }

    /// Whether anything of the drive is identified: how late it follows, or its scale.
    pub fn identifies_drive(&self) -> bool {
        self.identifies_lag || self.method == Method::Adaptive
    }

    /// Whether the speed below which its wheels do not turn is.
    pub fn identifies_band(&self) -> bool {
        self.identifies_dead_band && self.identifies_drive()
    }
}

/// Nominal loop delay in s: sensor 130 ms and the 99 % quantile of the normal link's round trip.
pub const LOOP_DELAY: f64 = 0.23;

impl Default for Settings {
    fn default() -> Self {
        Self {
            drive: Drive::default(),
            identifies_lag: false,
            identifies_dead_band: false,
            noise: PoseNoise::default(),
            identifies_noise: false,
            method: Method::Bayesian,
            prior: Prior::default(),
            attribution: Attribution::Sent,
            drift: false,
            slots: 20,
            slot: SLOT,
            loop_delay: LOOP_DELAY,
            follows_link: FollowsLink::default(),
            sensor_delay: 0.0,
            watchdog: WATCHDOG,
            predictor: PredictorKind::Moments,
            variance: VarianceLimits::default(),
            steering: SteeringSettings::default(),
        }
    }
}
