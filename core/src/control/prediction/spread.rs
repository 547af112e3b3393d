//! How unsure a predicted pose is.

use crate::geometry::length;

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
    pub(super) fn new(xx: f64, yy: f64, xy: f64, heading: f64) -> Self {
        let position = f64::midpoint(xx, yy) + length((xx - yy) / 2.0, xy);
        Self { position, heading }
    }
}
