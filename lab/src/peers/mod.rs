//! Methods of others, to be compared with: each replaces parts of the
//! [`Compensation`](umwelt_core::controller::compensation::Compensation) of the same controller.
//!
//! They drive the same tasks under the same limits and know the same robot; what is theirs is how they deal with delay.
//! None of them identifies the floor or slows down for what it does not know.
//!
//! | name | source | what it does about delay |
//! |---|---|---|
//! | `no-compensation` | | nothing |
//! | `stop-when-stale` | field practice | stops for whatever is late |
//! | `ekf-packet` | Cuenca et al. 2019 | filters poses, predicts, sends many commands per packet |
//! | `sliding-mode` | Zhang et al. 2019 | foresees the delay by a Markov chain; a sliding-mode law |
//! | `gp-mpc` | Jang et al. 2019 | learns what the model misses by a Gaussian process; model predictive control |
//!
//! What the sources leave open is in a `Tuning` each. Its defaults are chosen by `cargo run --release -p umwelt-lab
//! --example tune_peers`, on seeds that nothing is reported of: the least deviation (that 90 % stay within, geometric mean
//! over both links of the scenario `thesis`) among those who all arrive and take at most 5 % more time than the fastest.

mod ekf_packet;
mod gp_mpc;
mod line;
mod no_compensation;
mod sliding_mode;
mod stop_when_stale;

pub use ekf_packet::{EkfPacket, EkfTuning};
pub use gp_mpc::{GaussianProcess, GpEstimator, GpMpcTuning, GpTuning, MpcTuning, ShootingMpc};
pub use no_compensation::NoCompensation;
pub use sliding_mode::{DelayChain, ForeseenDelay, SlidingMode, SlidingTuning};
pub use stop_when_stale::{StaleTuning, StopWhenStale};

use umwelt_core::controller::compensation::PoseEstimator;
use umwelt_core::geometry::Pose;
use umwelt_core::identification::Belief;
use umwelt_core::prediction::ErrorModel;
use umwelt_core::settings::{Method, Settings, VarianceLimits};

/// The settings of every peer's controller: no identification of the floor, and no slowing down for what is not known.
pub fn without_identification(settings: &Settings) -> Settings {
    let variance = VarianceLimits { position: f64::INFINITY, heading: f64::INFINITY };
    Settings { method: Method::FixedNormal, variance, ..*settings }
}

/// Predicts that the robot moves as it is commanded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AsCommanded;

impl PoseEstimator for AsCommanded {
    fn error_model(&self, _: &Belief, _: Pose) -> ErrorModel {
        ErrorModel::PERFECT
    }
}

#[cfg(test)]
mod tests;
