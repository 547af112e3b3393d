//! A pose that is known to a normal distribution.

use crate::geometry::elementary::sin_cos;
use crate::geometry::{Displacement, Pose};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Where a robot is by one hypothesis: mean and covariance of (x, y, heading) in m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// The expected pose.
    pub mean: Pose,
    /// Its covariance, in the world frame.
    pub covariance: Matrix3<f64>,
}

/// How a robot has moved between two poses, by its commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// The expected motion, in the body frame of its beginning.
    pub by: Displacement,
    /// Covariance of (forward, lateral, turn) in m and rad.
    pub covariance: Matrix3<f64>,
}

/// What an observed pose makes of a [`Gaussian`].
#[derive(Clone, Copy, Debug)]
pub struct Updated {
    /// The pose with what was observed.
    pub pose: Gaussian,
    /// Logarithm of the density of what was observed, before it was.
    pub ln_density: f64,
    /// How far that lay from what was expected: the squared Mahalanobis distance, expected to be the number of dimensions.
    pub surprise: f64,
}

impl Gaussian {
    /// The pose after a motion.
    pub fn after(&self, moved: &Moved) -> Self {
        let (sin, cos) = sin_cos(self.mean.heading.radians());
        let Displacement { forward, lateral, .. } = moved.by;
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        // A heading that is off turns the way.
        let (dx, dy) = (cos * forward - sin * lateral, sin * forward + cos * lateral);
        let along = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        Self {
            mean: self.mean.then(moved.by),
            covariance: along * self.covariance * along.transpose()
                + turned * moved.covariance * turned.transpose(),
        }
    }

    /// How far `observed` lies from the mean: x, y in m and the heading in rad.
    pub fn off(&self, observed: Pose) -> Vector3<f64> {
        let Pose { x, y, heading } = self.mean;
        Vector3::new(observed.x - x, observed.y - y, observed.heading.minus(heading))
    }

    /// Fused with an observed pose of this `noise` (covariance). None where both are known exactly.
    pub fn fused(&self, observed: Pose, noise: &Matrix3<f64>) -> Option<Updated> {
        let off = self.off(observed);
        let total = self.covariance + noise;
        let inverse = total.try_inverse()?;
        let gain = self.covariance * inverse;
        let surprise = (off.transpose() * inverse * off)[(0, 0)];
        let ln_density = -0.5 * (surprise + (TAU.powi(3) * total.determinant()).ln());
        let left = Matrix3::identity() - gain;
        let covariance =
            left * self.covariance * left.transpose() + gain * noise * gain.transpose();
        let pose = Self { mean: self.moved_by(gain * off), covariance };
        Some(Updated { pose, ln_density, surprise })
    }

    /// Fused with the position of an observed pose alone.
    pub fn fused_position(&self, observed: Pose, noise: &Matrix3<f64>) -> Option<Updated> {
        let off = self.off(observed);
        let off = off.fixed_rows::<2>(0);
        let noise = noise.fixed_view::<2, 2>(0, 0);
        let total = self.covariance.fixed_view::<2, 2>(0, 0) + noise;
        let inverse = total.try_inverse()?;
        let gain = self.covariance.fixed_view::<3, 2>(0, 0) * inverse;
        let surprise = (off.transpose() * inverse * off)[(0, 0)];
        let ln_density = -0.5 * (surprise + (TAU.powi(2) * total.determinant()).ln());
        let covariance = self.covariance - gain * total * gain.transpose();
        let covariance = (covariance + covariance.transpose()) * 0.5;
        let pose = Self { mean: self.moved_by(gain * off), covariance };
        Some(Updated { pose, ln_density, surprise })
    }

    /// The mean moved by x, y in m and a heading in rad.
    pub fn moved_by(&self, off: Vector3<f64>) -> Pose {
        let Pose { x, y, heading } = self.mean;
        Pose { x: x + off[0], y: y + off[1], heading: heading + off[2] }
    }
}

impl Moved {
    /// No motion.
    pub fn none() -> Self {
        Self { by: Displacement::default(), covariance: Matrix3::zeros() }
    }
}
