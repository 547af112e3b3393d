//! Random numbers at an index: a function of seed, stream and index, never of what was drawn before.
//!
//! This is SplitMix64 read at an index instead of in sequence. Two methods that send different packets and drive
//! differently over the same seed meet the same jitter, the same late slots, the same silences and the same floor
//! (common random numbers).

use rand::TryRng;
use rand_distr::{Distribution, StandardNormal};
use std::convert::Infallible;

/// The increment of SplitMix64: 2^64 divided by the golden ratio, odd.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// The output function of SplitMix64: a bijection that avalanches.
pub fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// What a draw is for; each purpose has its own stream.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stream {
    /// Delay from the robot to the server.
    UplinkJitter = 1,
    /// Delay from the server to the robot.
    DownlinkJitter = 2,
    /// Whether a downlink slot is late.
    Late = 3,
    /// Whether a silence begins in a slot, and how long it lasts.
    Silence = 4,
    /// What the floor does in a cell.
    Slip = 5,
    /// What the camera adds to a pose.
    Noise = 6,
    /// How late a drive follows.
    Lateness = 7,
}

/// The random numbers at one index of one stream: of a slot, or of a cell.
pub(crate) struct Draws(u64);

impl Draws {
    pub(crate) fn new(seed: u64, stream: Stream, index: i64) -> Self {
        Self::at(Self::key(seed, stream), index)
    }

    /// What seed and stream come to, for who draws often.
    pub(crate) fn key(seed: u64, stream: Stream) -> u64 {
        mix(seed ^ mix(stream as u64))
    }

    /// [`Draws::new`] with the key made before.
    pub(crate) fn at(key: u64, index: i64) -> Self {
        Self(mix(key.wrapping_add((index as u64).wrapping_mul(GOLDEN))))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }

    /// Uniform in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Standard normal.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(self)
    }
}

impl TryRng for Draws {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.next() >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.next())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            chunk.copy_from_slice(&self.next().to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of `f(slot)` over `n` slots.
    fn moments(n: i64, f: impl Fn(i64) -> f64) -> (f64, f64) {
        let mean = (0..n).map(&f).sum::<f64>() / n as f64;
        (mean, (0..n).map(|i| (f(i) - mean).powi(2)).sum::<f64>() / n as f64)
    }

    #[test]
    fn draws_of_successive_slots_are_uniform_normal_and_uncorrelated() {
        let n = 200_000;
        let root = (n as f64).sqrt();
        let uniform = |i| Draws::new(5, Stream::Late, i).uniform();
        let (mean, variance) = moments(n, uniform);
        // sd of the mean is sqrt(1/12/n), of the variance of a uniform sqrt(1/180/n)
        assert!((mean - 0.5).abs() < 4.0 * 0.289 / root, "{mean}");
        assert!((variance - 1.0 / 12.0).abs() < 4.0 * 0.0746 / root, "{variance}");
        let normal = |i| Draws::new(5, Stream::UplinkJitter, i).normal();
        let (mean, variance) = moments(n, normal);
        assert!(mean.abs() < 4.0 / root && (variance - 1.0).abs() < 4.0 * 1.42 / root);
        // products of independent standard normals have mean 0, sd 1: next slot, other stream, other seed
        let (lag, _) = moments(n, |i| normal(i) * normal(i + 1));
        let down = |i| Draws::new(5, Stream::DownlinkJitter, i).normal();
        let (streams, _) = moments(n, |i| normal(i) * down(i));
        let other = |i| Draws::new(6, Stream::UplinkJitter, i).normal();
        let (seeds, _) = moments(n, |i| normal(i) * other(i));
        for correlation in [lag, streams, seeds] {
            assert!(correlation.abs() < 4.0 / root, "{correlation}");
        }
    }
}
