//! Prediction by moments: mean and covariance in closed form, the means' uncertainty carried along.

use super::model::{ERROR_WINDOW, ErrorModel};
use super::motion::Motion;
use super::spread::Spread;
use crate::geometry::Pose;
use crate::geometry::elementary::{exp, sin_cos, sinc_cos};
use crate::kinematics::Kind;
use crate::settings::PoseNoise;
use nalgebra::Matrix3;

/// Mean and covariance of a predicted pose.
///
/// The state is the pose augmented with the four channel means. Its covariance has a constant block (the means'
/// own variance), so it is carried as the covariance of the pose for known means and the sensitivity of the pose
/// to each mean: Cov = Q + J diag(mean_variance) J^T. That is exact for the heading:
/// Var(heading) = E\[sigma^2\] (sum phi^2 + (sum phi)^2/k_n). Positions follow the arc's chord at half the turn,
/// shortened by e^(-V/2) for a heading of variance V; terms of second order in V are left out of the covariance,
/// which is good to a few percent below the heading threshold of 0.1 rad^2.
///
/// All that is carried is of the robot's turning centre; what is shown is of its middle, which lies ahead of that or behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// How far in m the middle lies ahead of the turning centre.
    sideways: f64,
    x: f64,
    y: f64,
    heading: f64,
    /// Covariance of (x, y, heading) for known channel means.
    known: Symmetric,
    /// Derivative of (x, y) by the forward mean; by the lateral one it is the same, turned a quarter to the left.
    by_forward: (f64, f64),
    /// Derivative of (x, y, heading) by the mean of the turn and of the drift.
    by_turn: [f64; 3],
    by_drift: [f64; 3],
    /// Variances of the channel means.
    mean_variance: [f64; 4],
}

/// A symmetric matrix over (x, y, heading).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Symmetric {
    xx: f64,
    xy: f64,
    yy: f64,
    xh: f64,
    yh: f64,
    hh: f64,
}

impl Symmetric {
    /// Position and covariance of a point `by` m ahead of one at (x, y) with this covariance: the offset is expected
    /// shortened by e^(-V/2) for a heading of variance V, and turns with the heading.
    fn ahead(self, x: f64, y: f64, heading: f64, by: f64) -> (f64, f64, Self) {
        if by == 0.0 {
            return (x, y, self);
        }
        let Self { xx, xy, yy, xh, yh, hh } = self;
        let (sin, cos) = sin_cos(heading);
        let by = by * exp(-hh / 2.0);
        let (dx, dy) = (by * cos, by * sin);
        let moved = Self {
            xx: xx - 2.0 * dy * xh + dy * dy * hh,
            xy: xy + dx * xh - dy * yh - dx * dy * hh,
            yy: yy + 2.0 * dx * yh + dx * dx * hh,
            xh: xh - dy * hh,
            yh: yh + dx * hh,
            hh,
        };
        (x + dx, y + dy, moved)
    }
}

impl Moments {
    /// A pose as observed, with the noise of observing it, of a robot of this kind.
    pub fn new(kind: Kind, pose: Pose, noise: PoseNoise) -> Self {
        let (p, h) = (noise.position * noise.position, noise.heading * noise.heading);
        let (heading, sideways) = (pose.heading.radians(), kind.sideways());
        let known = Symmetric { xx: p, xy: 0.0, yy: p, xh: 0.0, yh: 0.0, hh: h };
        let (x, y, known) = known.ahead(pose.x, pose.y, heading, -sideways);
        Self {
            sideways,
            x,
            y,
            heading,
            known,
            by_forward: (0.0, 0.0),
            by_turn: [0.0; 3],
            by_drift: [0.0; 3],
            mean_variance: [0.0; 4],
        }
    }

    /// Goes on by one commanded motion.
    ///
    /// Forward f = l (1 + mu_f), lateral g = l mu_l, turn d = phi (1 + mu_t) + l mu_d; each error is white in time:
    /// over h s its variance is sigma^2 x 0.1 s x int v^2 dt (or int omega^2 dt), at constant speed l^2/h (or phi^2/h).
    pub fn advance(&mut self, model: &ErrorModel, motion: Motion) {
        let before = *self;
        before.write_after(model, motion, self);
    }

    /// [`Moments::advance`] to another place, field by field: whoever may have to go back copies nothing.
    #[inline]
    pub fn write_after(&self, model: &ErrorModel, motion: Motion, after: &mut Self) {
        if !motion.is_motion() {
            *after = *self;
            return;
        }
        let Motion { length, turn, length_power, turn_power, .. } = motion;
        let forward = length * (1.0 + model.forward.mean);
        let lateral = length * model.lateral.mean;
        let turned = turn * (1.0 + model.turn.mean) + length * model.drift.mean;
        let (per_length, per_turn) = (ERROR_WINDOW * length_power, ERROR_WINDOW * turn_power);
        let forward_variance = model.forward.variance * per_length;
        let lateral_variance = model.lateral.variance * per_length;
        let turn_variance = model.turn.variance * per_turn + model.drift.variance * per_length;
        let mean_variance = [
            model.forward.mean_variance,
            model.lateral.mean_variance,
            model.turn.mean_variance,
            model.drift.mean_variance,
        ];

        if length == 0.0 {
            *after = *self;
            after.heading += turned;
            after.known.hh += turn_variance;
            after.by_turn[2] += turn;
            after.mean_variance = mean_variance;
            return;
        }
        let [_, _, turn_mean, drift_mean] = mean_variance;
        let halfway = self.heading_variance(turn_mean, drift_mean) + turn_variance / 2.0;
        let (sin, cos) = sin_cos(self.heading + turned / 2.0);
        let (sinc, _) = sinc_cos(turned / 2.0);
        let shrink = sinc * exp(-halfway / 2.0);
        let (sin, cos) = (sin * shrink, cos * shrink);
        let (dx, dy) = (forward * cos - lateral * sin, forward * sin + lateral * cos);

        // How the pose after depends on the pose before, only through the heading, and on this motion's own errors:
        // along (cos, sin), across (-sin, cos), around (-dy/2, dx/2, 1).
        let by = |[x, y, heading]: [f64; 3], weight: f64| {
            let halfway = heading + weight / 2.0;
            [x - dy * halfway, y + dx * halfway, heading + weight]
        };
        let Symmetric { xx, xy, yy, xh, yh, hh } = self.known;
        // Of this motion's own turn variance a third turns its chord, as of anything that grows evenly.
        let (around_hh, around_h) = (hh + turn_variance / 3.0, hh + turn_variance / 2.0);
        after.known = Symmetric {
            xx: xx - 2.0 * dy * xh
                + dy * dy * around_hh
                + forward_variance * cos * cos
                + lateral_variance * sin * sin,
            xy: xy + dx * xh - dy * yh - dx * dy * around_hh
                + (forward_variance - lateral_variance) * cos * sin,
            yy: yy
                + 2.0 * dx * yh
                + dx * dx * around_hh
                + forward_variance * sin * sin
                + lateral_variance * cos * cos,
            xh: xh - dy * around_h,
            yh: yh + dx * around_h,
            hh: hh + turn_variance,
        };
        after.sideways = self.sideways;
        after.x = self.x + dx;
        after.y = self.y + dy;
        after.heading = self.heading + turned;
        after.by_forward = (self.by_forward.0 + length * cos, self.by_forward.1 + length * sin);
        after.by_turn = by(self.by_turn, turn);
        after.by_drift = by(self.by_drift, length);
        after.mean_variance = mean_variance;
    }

    /// Variance of the heading where the means of turn and drift have these variances.
    fn heading_variance(&self, turn: f64, drift: f64) -> f64 {
        self.known.hh
            + turn * self.by_turn[2] * self.by_turn[2]
            + drift * self.by_drift[2] * self.by_drift[2]
    }

    /// The covariance Q + J diag(mean_variance) J^T.
    fn total(&self) -> Symmetric {
        let [forward, lateral, turn, drift] = self.mean_variance;
        let Symmetric { xx, xy, yy, xh, yh, .. } = self.known;
        let ((fx, fy), [tx, ty, th], [dx, dy, dh]) = (self.by_forward, self.by_turn, self.by_drift);
        Symmetric {
            xx: xx + forward * fx * fx + lateral * fy * fy + turn * tx * tx + drift * dx * dx,
            xy: xy + (forward - lateral) * fx * fy + turn * tx * ty + drift * dx * dy,
            yy: yy + forward * fy * fy + lateral * fx * fx + turn * ty * ty + drift * dy * dy,
            xh: xh + turn * tx * th + drift * dx * dh,
            yh: yh + turn * ty * th + drift * dy * dh,
            hh: self.heading_variance(turn, drift),
        }
    }

    /// The expected pose.
    pub fn mean(&self) -> Pose {
        if self.sideways == 0.0 {
            return Pose::new(self.x, self.y, self.heading);
        }
        let (x, y, _) = self.of_middle();
        Pose::new(x, y, self.heading)
    }

    /// Position and covariance of the middle.
    fn of_middle(&self) -> (f64, f64, Symmetric) {
        self.total().ahead(self.x, self.y, self.heading, self.sideways)
    }

    /// Covariance of (x, y, heading) in m and rad.
    pub fn covariance(&self) -> Matrix3<f64> {
        let (_, _, Symmetric { xx, xy, yy, xh, yh, hh }) = self.of_middle();
        Matrix3::new(xx, xy, xh, xy, yy, yh, xh, yh, hh)
    }

    /// The variances that the variance rule looks at.
    pub fn spread(&self) -> Spread {
        let (_, _, Symmetric { xx, xy, yy, hh, .. }) = self.of_middle();
        Spread::new(xx, yy, xy, hh)
    }
}
