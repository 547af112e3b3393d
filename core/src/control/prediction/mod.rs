//! From the posterior and the commands in flight to the pose at a later time, with its covariance.
//!
//! [`Moments`] carries mean and covariance in closed form; [`Agents`] is the thesis's Monte Carlo, an option
//! and the oracle that tests the moments. Both take the motion piece by piece.

mod model;
mod moments;
mod monte_carlo;
mod motion;
mod pieces;
mod spread;

pub use model::{ChannelModel, ERROR_WINDOW, ErrorModel, Scale, UNSURE};
pub use moments::Moments;
pub use monte_carlo::Agents;
pub use motion::Motion;
pub use pieces::Pieces;
pub use spread::Spread;

use crate::geometry::Pose;
use crate::kinematics::Kind;
use crate::settings::PoseNoise;

/// A prediction under way, by either predictor.
#[derive(Clone, Debug)]
pub enum Prediction {
    /// Closed form.
    Moments(Moments),
    /// Monte Carlo.
    MonteCarlo(Agents),
}

impl Prediction {
    /// Starts at an observed pose of a robot of this kind, by moments.
    pub fn moments(kind: Kind, pose: Pose, noise: PoseNoise) -> Self {
        Self::Moments(Moments::new(kind, pose, noise))
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
