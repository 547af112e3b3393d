//! The choices of a robot's controller: method, attribution, predictor.

use crate::check::{Check, Range, Validate};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Most agents: their steps must fit into a control cycle.
pub const MAX_AGENTS: u64 = 10_000;
/// From a tenth of the pose noise of a good camera to the size of a robot.
pub const CELL: Range = Range::new(1e-5, 1.0, "m");
/// Integers up to 2^53 - 1 survive every JSON reader.
pub const MAX_INTEGER: u64 = (1 << 53) - 1;

/// How the environment is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = Method)]
pub enum Method {
    /// The error distribution measured once on the normal link, never updated.
    FixedNormal,
    /// The error distribution measured once on the bad link, never updated.
    FixedBad,
    /// Samples only; fixed-normal below two samples.
    Statistic,
    /// Prior and samples: the thesis's method.
    Bayesian,
    /// The same, poses are fused with what the commands predict, and the drive is identified by itself: commands are corrected
    /// by it.
    Adaptive,
}

/// What the wheels of a robot do on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = DriveKind)]
pub enum Kind {
    /// Two of them on one axle, which roll.
    #[default]
    Differential,
    /// Wheels or tracks that slide sideways in turns: `turn_by_speed_s_per_m` and `sideways_m_per_rad` say how.
    SkidSteer,
}

/// What an observed motion is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = Attribution)]
pub enum Attribution {
    /// The commands as sent: a late packet shows as a control error.
    Sent,
    /// The commands as the robot reports to have played them: link trouble and floor trouble come apart.
    Played,
}

/// How the pose at the time of a command is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[schema(as = Predictor)]
pub enum Predictor {
    /// Mean and covariance propagated in closed form.
    Moments,
    /// The thesis's Monte Carlo: agents counted in a table of cells.
    MonteCarlo {
        /// Number of agents.
        agents: usize,
        /// Edge of a cell; a cell of the heading is as many rad per 0.1 m.
        cell_m: f64,
        /// Seed of the agents' errors.
        seed: u64,
    },
}

impl Validate for Predictor {
    fn check(&self, check: &mut Check) {
        if let Self::MonteCarlo { agents, cell_m, seed } = self {
            check.integer("agents", *agents as u64, 1..=MAX_AGENTS);
            check.number("cell_m", *cell_m, CELL);
            check.integer("seed", *seed, 0..=MAX_INTEGER);
        }
    }
}
