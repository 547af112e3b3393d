//! Prediction by moments: mean and covariance in closed form, the means' uncertainty carried along.

use super::{ERROR_WINDOW, ErrorModel, Motion, Spread};
use crate::controller::settings::PoseNoise;
use crate::geometry::Pose;
use nalgebra::{Matrix3, Matrix3x4, Vector3};

/// Mean and covariance of a predicted pose.
///
/// The state is the pose augmented with the four channel means. Its covariance has a constant block (the means'
/// own variance), so it is carried as the covariance of the pose for known means and the sensitivity of the pose
/// to each mean: Cov = Q + J diag(mean_variance) J^T. That is exact for the heading:
/// Var(heading) = E\[sigma^2\] (sum phi^2 + (sum phi)^2/k_n). Positions follow the chord at half the turn,
/// shortened by e^(-V/2) for a heading of variance V; terms of second order in V are left out of the covariance,
/// which is good to a few percent below the heading threshold of 0.1 rad^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    x: f64,
    y: f64,
    heading: f64,
    /// Covariance of (x, y, heading) for known channel means.
    known: Matrix3<f64>,
    /// Derivative of (x, y, heading) by the channel means.
    sensitivity: Matrix3x4<f64>,
    /// Variances of the channel means.
    mean_variance: [f64; 4],
}

impl Moments {
    /// A pose as observed, with the noise of observing it.
    pub fn new(pose: Pose, noise: PoseNoise) -> Self {
        let (p, h) = (noise.position * noise.position, noise.heading * noise.heading);
        Self {
            x: pose.x,
            y: pose.y,
            heading: pose.heading.radians(),
            known: Matrix3::from_diagonal(&Vector3::new(p, p, h)),
            sensitivity: Matrix3x4::zeros(),
            mean_variance: [0.0; 4],
        }
    }

    /// Goes on by one commanded motion.
    ///
    /// Forward f = l (1 + mu_f), lateral g = l mu_l, turn d = phi (1 + mu_t) + l mu_d; each error is white in time:
    /// over h s its variance is sigma^2 x 0.1 s x l^2/h (or phi^2/h).
    pub fn advance(&mut self, model: &ErrorModel, motion: Motion) {
        let Motion { length, turn, duration } = motion;
        if length == 0.0 && turn == 0.0 {
            return;
        }
        let forward = length * (1.0 + model.forward.mean);
        let lateral = length * model.lateral.mean;
        let turned = turn * (1.0 + model.turn.mean) + length * model.drift.mean;
        let (per_length, per_turn) =
            (ERROR_WINDOW * length * length / duration, ERROR_WINDOW * turn * turn / duration);
        let forward_variance = model.forward.variance * per_length;
        let lateral_variance = model.lateral.variance * per_length;
        let turn_variance = model.turn.variance * per_turn + model.drift.variance * per_length;
        self.mean_variance = [
            model.forward.mean_variance,
            model.lateral.mean_variance,
            model.turn.mean_variance,
            model.drift.mean_variance,
        ];

        let halfway = self.heading_variance() + turn_variance / 4.0;
        let (sin, cos) = (self.heading + turned / 2.0).sin_cos();
        let shrink = if halfway < 1e-12 { 1.0 } else { (-halfway / 2.0).exp() };
        let (sin, cos) = (sin * shrink, cos * shrink);
        let (dx, dy) = (forward * cos - lateral * sin, forward * sin + lateral * cos);

        // F: how the pose after depends on the pose before; only through the heading.
        for column in 0..4 {
            let by_heading = self.sensitivity[(2, column)];
            self.sensitivity[(0, column)] -= dy * by_heading;
            self.sensitivity[(1, column)] += dx * by_heading;
        }
        let along = [cos, sin, 0.0];
        let across = [-sin, cos, 0.0];
        let around = [-dy / 2.0, dx / 2.0, 1.0];
        for row in 0..3 {
            self.sensitivity[(row, 0)] += length * along[row];
            self.sensitivity[(row, 1)] += length * across[row];
            self.sensitivity[(row, 2)] += turn * around[row];
            self.sensitivity[(row, 3)] += length * around[row];
        }
        let q = &mut self.known;
        let (qxh, qyh, qhh) = (q[(0, 2)], q[(1, 2)], q[(2, 2)]);
        q[(0, 0)] += -2.0 * dy * qxh + dy * dy * qhh;
        q[(0, 1)] += dx * qxh - dy * qyh - dx * dy * qhh;
        q[(1, 1)] += 2.0 * dx * qyh + dx * dx * qhh;
        q[(0, 2)] -= dy * qhh;
        q[(1, 2)] += dx * qhh;
        for row in 0..3 {
            for column in row..3 {
                q[(row, column)] += forward_variance * along[row] * along[column]
                    + lateral_variance * across[row] * across[column]
                    + turn_variance * around[row] * around[column];
            }
        }
        q[(1, 0)] = q[(0, 1)];
        q[(2, 0)] = q[(0, 2)];
        q[(2, 1)] = q[(1, 2)];

        self.x += dx;
        self.y += dy;
        self.heading += turned;
    }

    fn heading_variance(&self) -> f64 {
        self.entry(2, 2)
    }

    /// One entry of the covariance: Q + J diag(mean_variance) J^T.
    fn entry(&self, row: usize, column: usize) -> f64 {
        let mut sum = self.known[(row, column)];
        for (channel, variance) in self.mean_variance.iter().enumerate() {
            sum +=
                variance * self.sensitivity[(row, channel)] * self.sensitivity[(column, channel)];
        }
        sum
    }

    /// The expected pose.
    pub fn mean(&self) -> Pose {
        Pose::new(self.x, self.y, self.heading)
    }

    /// Covariance of (x, y, heading) in m and rad.
    pub fn covariance(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| self.entry(row, column))
    }

    /// The variances that the variance rule looks at.
    pub fn spread(&self) -> Spread {
        Spread::new(self.entry(0, 0), self.entry(1, 1), self.entry(0, 1), self.heading_variance())
    }
}
