//! How noisy a robot's poses are, as it is identified.

use super::estimate::{Estimate, Status};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is known of the noise of a robot's poses: standard deviations of what each is off by itself.
///
/// Where it is not described the poses of a moving robot show it: what its floor does to its way stays, noise is anew in each.
/// Poses at rest show only a floor of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentNoise)]
pub struct Noise {
    /// How far the estimate has got; `given` where the noise is described.
    pub status: Status,
    /// Of x and of y, in m; `mean` is the value that is as likely too large as too small.
    pub position_m: Estimate,
    /// Of the heading, in rad.
    pub heading_rad: Estimate,
    /// Poses of the moving robot that this is worth.
    pub poses: Option<f64>,
}
