//! What of a scale belongs to the robot and what to the floor.
//!
//! From poses and commands on one floor only both together are known: s + f, with s ~ N(0, sd_s^2) of the robot and
//! f ~ N(0, sd_f^2) of every floor anew. They part over several floors.

use super::estimate::Quantity;
use serde::{Deserialize, Serialize};

/// A normal distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normal {
    pub mean: f64,
    pub variance: f64,
}

/// The robot's part of a scale, as earlier floors have shown it, and how much floors differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parts {
    /// The robot's part before this floor.
    robot: Normal,
    /// Variance of a floor's part.
    floor: f64,
}

impl Parts {
    /// Before any floor: standard deviations of the robot's part and of a floor's.
    pub fn new(robot: f64, floor: f64) -> Self {
        Self { robot: Normal { mean: 0.0, variance: robot * robot }, floor: floor * floor }
    }

    /// Both together on a floor that is not known yet.
    pub fn together(&self) -> Normal {
        Normal { variance: self.robot.variance + self.floor, ..self.robot }
    }

    /// The robot's part where both together are known to be `sum`.
    pub fn robot(&self, sum: Normal) -> Normal {
        let Normal { mean, variance } = self.robot;
        share(mean, variance, self.floor, sum)
    }

    /// The floor's part where both together are known to be `sum`.
    pub fn floor(&self, sum: Normal) -> Normal {
        let Normal { mean, variance } = self.robot;
        share(0.0, self.floor, variance, Normal { mean: sum.mean - mean, ..sum })
    }

    /// On another floor, after one on which both together were `sum`.
    pub fn next(&self, sum: Normal) -> Self {
        Self { robot: self.robot(sum), ..*self }
    }

    /// Of a quantity that becomes `factor` times itself and `offset` more.
    pub fn rescaled(&self, factor: f64, offset: f64) -> Self {
        let square = factor * factor;
        let Normal { mean, variance } = self.robot;
        let robot = Normal { mean: mean * factor + offset, variance: variance * square };
        Self { robot, floor: self.floor * square }
    }
}

/// The part with this mean and variance of a sum with another part of variance `other`, where the sum is known to be `sum`:
/// of what the sum differs by from what was expected it has its share, and of what is not known of the sum.
fn share(mean: f64, variance: f64, other: f64, sum: Normal) -> Normal {
    let gain = variance / (variance + other);
    Normal {
        mean: mean + gain * (sum.mean - mean),
        variance: variance * (1.0 - gain) + gain * gain * sum.variance,
    }
}

impl From<Normal> for Quantity {
    fn from(it: Normal) -> Self {
        Self::normal(it.mean, it.variance)
    }
}
