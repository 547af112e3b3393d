//! Gaussian-process regression of one rate over time.

use nalgebra::{SMatrix, SVector};
use umwelt_core::geometry::elementary::exp;

/// Samples kept: 1.4 s in windows of 0.12 s, several times the delay.
pub const SAMPLES: usize = 12;

/// Hyperparameters of a squared exponential kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpTuning {
    /// Standard deviation of the rate.
    pub signal: f64,
    /// Time in s over which it changes.
    pub length: f64,
}

/// A rate over time, zero until something else was seen: the last twelve samples of it, and how much each counts.
///
/// Kernel k(t, t') = signal^2 exp(-(t - t')^2/(2 length^2)); mean at t: sum of alpha_i k(t, t_i), alpha = (K + N)^-1 y,
/// N the covariance of the noise.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianProcess {
    tuning: GpTuning,
    times: [f64; SAMPLES],
    values: SVector<f64, SAMPLES>,
    /// Standard deviation of the noise of each.
    noise: [f64; SAMPLES],
    /// alpha.
    weights: SVector<f64, SAMPLES>,
    count: usize,
    /// The place of the next sample, that of the oldest.
    next: usize,
}

impl GaussianProcess {
    /// A process of which nothing has been seen.
    pub fn new(tuning: GpTuning) -> Self {
        Self {
            tuning,
            times: [0.0; SAMPLES],
            values: SVector::zeros(),
            noise: [1.0; SAMPLES],
            weights: SVector::zeros(),
            count: 0,
            next: 0,
        }
    }

    /// Forgets every sample.
    pub fn forget(&mut self) {
        *self = Self::new(self.tuning);
    }

    /// The mean rate over a window around `time` s was `value`, seen with a noise of standard deviation `noise`, which is
    /// not zero: that of the poses at its two ends. The next window begins with the pose at which this one ends, so that
    /// their noises correlate by -1/2.
    pub fn learn(&mut self, time: f64, value: f64, noise: f64) {
        self.times[self.next] = time;
        self.values[self.next] = value;
        self.noise[self.next] = noise;
        self.next = (self.next + 1) % SAMPLES;
        self.count = (self.count + 1).min(SAMPLES);
        // Places without a sample are independent of all others and worth zero.
        let covariance = SMatrix::<f64, SAMPLES, SAMPLES>::from_fn(|row, column| {
            if row >= self.count || column >= self.count {
                return if row == column { 1.0 } else { 0.0 };
            }
            let shared = self.kernel(self.times[row] - self.times[column]);
            if row == column {
                shared + self.noise[row].powi(2)
            } else if self.age(row).abs_diff(self.age(column)) == 1 {
                shared - self.noise[row] * self.noise[column] / 2.0
            } else {
                shared
            }
        });
        // Positive definite, as noise is not zero; were it not, nothing would be known.
        self.weights = covariance
            .cholesky()
            .map_or_else(SVector::zeros, |factors| factors.solve(&self.values));
    }

    /// The expected rate at `time` s.
    pub fn mean(&self, time: f64) -> f64 {
        (0..self.count).map(|i| self.weights[i] * self.kernel(time - self.times[i])).sum()
    }

    /// How many samples came after the one at `place`.
    fn age(&self, place: usize) -> usize {
        (self.next + SAMPLES - 1 - place) % SAMPLES
    }

    fn kernel(&self, apart: f64) -> f64 {
        let GpTuning { signal, length } = self.tuning;
        signal * signal * exp(-0.5 * (apart / length).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TUNING: GpTuning = GpTuning { signal: 1.0, length: 0.3 };

    #[test]
    fn what_was_seen_without_noise_is_met_and_what_lies_between_is_near() {
        let mut process = GaussianProcess::new(TUNING);
        let rate = |time: f64| (2.0 * time).sin();
        // More samples than are kept: the last twelve count.
        for i in 0..30 {
            let time = f64::from(i) * 0.12;
            process.learn(time, rate(time), 1e-3);
        }
        for i in 18..30 {
            let time = f64::from(i) * 0.12;
            assert!((process.mean(time) - rate(time)).abs() < 2e-3);
        }
        let between = 24.5 * 0.12;
        assert!((process.mean(between) - rate(between)).abs() < 5e-3);
    }

    #[test]
    fn far_away_nothing_is_known() {
        let mut process = GaussianProcess::new(TUNING);
        assert_eq!(process.mean(0.0), 0.0);
        process.learn(0.0, 0.5, 0.1);
        process.learn(0.12, 0.6, 0.1);
        assert!(process.mean(0.2) > 0.3);
        assert!(process.mean(3.0).abs() < 1e-9);
        process.forget();
        assert_eq!(process.mean(0.1), 0.0);
    }

    /// One sample has a closed form: y s^2/(s^2 + n^2) k(t)/s^2.
    #[test]
    fn one_sample_is_shrunk_by_its_noise() {
        let mut process = GaussianProcess::new(TUNING);
        process.learn(1.0, 0.8, 0.5);
        let expected = 0.8 / (1.0 + 0.25) * (-0.5_f64 * (0.1_f64 / 0.3).powi(2)).exp();
        assert!((process.mean(1.1) - expected).abs() < 1e-12);
    }

    /// Two windows in a row, solved by hand: the pose between them is too high by as much as the first window gains and the
    /// second loses, so that only their sum is sure.
    #[test]
    fn what_one_window_gains_by_noise_the_next_one_loses() {
        let mut process = GaussianProcess::new(TUNING);
        process.learn(0.0, 0.5, 0.4);
        process.learn(0.12, -0.5, 0.4);
        let near = (-0.5_f64 * (0.12_f64 / 0.3).powi(2)).exp();
        let (own, shared) = (1.0 + 0.16, near - 0.08);
        // Opposite values: (K + N) alpha = y has alpha = y/(own - shared) (1, -1).
        let alpha = 0.5 / (own - shared);
        assert!((process.mean(0.0) - alpha * (1.0 - near)).abs() < 1e-12);
    }
}
