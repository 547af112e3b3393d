//! The documented default prior and the two fixed models.

use super::estimate::Channel;
use crate::conjugate::NormalInverseChiSquared;
use crate::controller::settings::Prior;
use crate::prediction::ChannelModel;

/// Mean and variance of each channel's ratio over 100 ms, in the order of `Channel::ALL`, on the `normal` link.
///
/// Measured, not guessed: `cargo run --release -p umwelt-core --example measure_fixed_models`.
pub const FIXED_NORMAL: [(f64, f64); 4] = [(0.0, 0.01), (0.0, 0.01), (0.0, 0.01), (0.0, 0.01)];

/// The same on the `bad` link.
pub const FIXED_BAD: [(f64, f64); 4] = [(0.0, 0.09), (0.0, 0.02), (0.0, 0.09), (0.0, 0.02)];

/// One channel of a fixed model.
pub fn fixed(model: &[(f64, f64); 4], channel: Channel) -> ChannelModel {
    let (mean, variance) = model[channel as usize];
    ChannelModel::known(mean, variance)
}

impl Default for Prior {
    /// A weak prior for a floor and a link of which nothing is known: a ratio of standard deviation 0.15 over
    /// 100 ms (what recorded robots show), four degrees of freedom so that its variance exists, and a mean that
    /// one sample can move half way. Lateral slip and drift are expected to be three times smaller.
    fn default() -> Self {
        let weak = |sd: f64| {
            let (k, r) = (1.0, 4.0);
            NormalInverseChiSquared::new(0.0, k, r, sd * sd * (r - 2.0))
                .expect("constants in their domain")
        };
        Self { forward: weak(0.15), lateral: weak(0.05), turn: weak(0.15), drift: weak(0.05) }
    }
}
