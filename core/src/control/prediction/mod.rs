//! From the posterior and the commands in flight to the pose at a later time, with its covariance.
//!
//! [`Moments`] carries mean and covariance in closed form; [`Agents`] is the thesis's Monte Carlo, an option
//! and the oracle that tests the moments. Both take the motion piece by piece.

mod moments;
mod monte_carlo;
mod pieces;

pub use moments::Moments;
pub use monte_carlo::Agents;
pub use pieces::Pieces;

use crate::conjugate::NormalInverseChiSquared;
use crate::geometry::{Pose, Twist, length};
use crate::settings::PoseNoise;

/// Time in s over which a ratio's variance is stated (error acquisition cycle, thesis table 1).
pub const ERROR_WINDOW: f64 = 0.1;

/// Ratio variance that stands for one that does not exist (r <= 2): any motion at all is too unsure.
pub const UNSURE: f64 = 1e6;

/// What is assumed of one channel's error ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelModel {
    /// Expected ratio.
    pub mean: f64,
    /// Variance of the ratio over 100 ms at constant speed, for a known mean.
    pub variance: f64,
    /// Variance of the mean itself, shared by the whole prediction.
    pub mean_variance: f64,
    /// The posterior that the moments come from; none for a model with known mean and variance.
    pub posterior: Option<NormalInverseChiSquared>,
}

impl ChannelModel {
    /// No error at all.
    pub const PERFECT: Self = Self::known(0.0, 0.0);

    /// A known mean and variance.
    pub const fn known(mean: f64, variance: f64) -> Self {
        Self { mean, variance, mean_variance: 0.0, posterior: None }
    }

    /// The moments of a posterior: E[sigma^2] = s/(r - 2) and E[sigma^2]/k; [`UNSURE`] where r <= 2.
    pub fn believed(posterior: NormalInverseChiSquared) -> Self {
        let variance = posterior.expected_variance().unwrap_or(UNSURE).min(UNSURE);
        Self {
            mean: posterior.mu(),
            variance,
            mean_variance: variance / posterior.k(),
            posterior: Some(posterior),
        }
    }
}

/// What is assumed of a robot's motion: one model per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorModel {
    /// Forward error per metre.
    pub forward: ChannelModel,
    /// Lateral error per metre.
    pub lateral: ChannelModel,
    /// Heading error per radian.
    pub turn: ChannelModel,
    /// Heading error in rad per metre.
    pub drift: ChannelModel,
}

impl ErrorModel {
    /// A robot that moves as commanded.
    pub const PERFECT: Self = Self {
        forward: ChannelModel::PERFECT,
        lateral: ChannelModel::PERFECT,
        turn: ChannelModel::PERFECT,
        drift: ChannelModel::PERFECT,
    };
}

/// A commanded motion over some time, at one speed or several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Signed arc length in m.
    pub length: f64,
    /// Turn in rad.
    pub turn: f64,
    /// Duration in s.
    pub duration: f64,
    /// int v^2 dt in m^2/s: what errors white in time grow with.
    pub length_power: f64,
    /// int omega^2 dt in rad^2/s.
    pub turn_power: f64,
}

impl Motion {
    /// None yet: what others are added to.
    pub const NONE: Self =
        Self { length: 0.0, turn: 0.0, duration: 0.0, length_power: 0.0, turn_power: 0.0 };

    /// The motion of holding `twist` for `duration` s.
    pub fn new(twist: Twist, duration: f64) -> Self {
        let (length, turn) = (twist.linear * duration, twist.angular * duration);
        let (length_power, turn_power) = (twist.linear * length, twist.angular * turn);
        Self { length, turn, duration, length_power, turn_power }
    }

    /// The motion along an arc of `length` m that turns by `turn` rad in `duration` s.
    pub fn arc(length: f64, turn: f64, duration: f64) -> Self {
        Self::new(Twist::new(length / duration, turn / duration), duration)
    }

    /// This motion followed by `next`.
    pub fn then(self, next: Self) -> Self {
        Self {
            length: self.length + next.length,
            turn: self.turn + next.turn,
            duration: self.duration + next.duration,
            length_power: self.length_power + next.length_power,
            turn_power: self.turn_power + next.turn_power,
        }
    }

    /// Whether anything moves.
    pub fn is_motion(self) -> bool {
        self.length != 0.0 || self.turn != 0.0
    }
}

/// Variances of a predicted pose that the variance rule looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Variance of the position in m^2 in its worst direction: the larger eigenvalue.
    pub position: f64,
    /// Variance of the heading in rad^2.
    pub heading: f64,
}

impl Spread {
    /// From the entries of a covariance: of x, of y, between them, of the heading.
    fn new(xx: f64, yy: f64, xy: f64, heading: f64) -> Self {
        let position = f64::midpoint(xx, yy) + length((xx - yy) / 2.0, xy);
        Self { position, heading }
    }
}

/// A prediction under way, by either predictor.
#[derive(Clone, Debug)]
pub enum Prediction {
    /// Closed form.
    Moments(Moments),
    /// Monte Carlo.
    MonteCarlo(Agents),
}

impl Prediction {
    /// Starts at an observed pose, by moments.
    pub fn moments(pose: Pose, noise: PoseNoise) -> Self {
        Self::Moments(Moments::new(pose, noise))
    }

    /// Goes on by one commanded motion.
    pub fn advance(&mut self, model: &ErrorModel, motion: Motion) {
        match self {
            Self::Moments(moments) => moments.advance(model, motion),
            Self::MonteCarlo(agents) => agents.advance(motion),
        }
    }

    /// The expected pose.
    pub fn mean(&self) -> Pose {
        match self {
            Self::Moments(moments) => moments.mean(),
            Self::MonteCarlo(agents) => agents.mean(),
        }
    }

    /// How unsure the pose is.
    pub fn spread(&self) -> Spread {
        match self {
            Self::Moments(moments) => moments.spread(),
            Self::MonteCarlo(agents) => agents.spread(),
        }
    }

    /// Becomes what `before` is after one commanded motion.
    pub fn become_after(&mut self, before: &Self, model: &ErrorModel, motion: Motion) {
        match (self, before) {
            (Self::Moments(after), Self::Moments(before)) => {
                before.write_after(model, motion, after);
            }
            (after, before) => {
                *after = before.clone();
                after.advance(model, motion);
            }
        }
    }
}
