//! The two fixed error models of the thesis: measured once, never updated.

use super::estimate::Channel;
use crate::prediction::ChannelModel;

/// Mean and variance of each channel's ratio over 100 ms, in the order of `Channel::ALL`.
pub type FixedModel = [(f64, f64); 4];

/// The error distribution on the `normal` link.
///
/// Measured by `cargo run --release -p umwelt-core --example measure_fixed_models`; [`crate::fixed_models`]
/// says how, and its test keeps it true.
pub const FIXED_NORMAL: FixedModel =
    [(0.0040, 0.00061), (-0.0001, 0.00019), (0.0098, 0.00050), (-0.0004, 0.00080)];

/// The same on the `bad` link.
pub const FIXED_BAD: FixedModel =
    [(-0.0213, 0.0158), (-0.0001, 0.00019), (-0.0367, 0.0416), (-0.0021, 0.0602)];

/// One channel of a fixed model.
pub(super) fn channel(model: &FixedModel, channel: Channel) -> ChannelModel {
    let (mean, variance) = model[channel as usize];
    ChannelModel::known(mean, variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bad_link_shows_as_a_larger_error() {
        assert!(FIXED_BAD[0].1 > FIXED_NORMAL[0].1 && FIXED_BAD[2].1 > FIXED_NORMAL[2].1);
    }
}
