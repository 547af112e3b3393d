//! How noisy poses are, where that is not described.
//!
//! Poses of a robot that moves lie off the way that its commands make by two things: their own noise, anew in each, and what
//! the floor adds, which stays. In each axis that is a random walk seen through white noise, and a Kalman filter tells the two
//! apart for a given ratio of their variances; the variance of the noise itself is then conjugate (scaled inverse
//! chi-squared). A few ratios cover what floors and trackers do: each has its filter, and their evidence decides.
//!
//! A robot at rest shows only a floor of the noise: real trackers do 0.2 mm standing and 0.7 mm moving.

use crate::exchange::PoseNoise;
use crate::identification::estimate::NORMAL_HALF_WIDTH;
use serde::{Deserialize, Serialize};

/// Ratios of the variance that a walk gains per unit of commanded motion to that of the noise, a decade apart.
const RATIOS: usize = 9;

/// The least ratio: of a position, in 1/m^2, and of a heading, in 1/rad^2. Errors of 0.3 % of the motion in 100 ms with 10 mm
/// or 30 mrad.
const LEAST_RATIO: (f64, f64) = (0.1, 0.01);

/// Degrees of freedom of the prior: next to nothing is known, a second of poses outweighs it.
const DEGREES: f64 = 0.5;

/// Poses that are remembered: a noise that changes is followed.
const MEMORY: f64 = 2000.0;

/// What stays of them with each.
const STAYS: f64 = 1.0 - 1.0 / MEMORY;

/// Poses that are remembered over a restart: the tracker may be another one.
const KEPT: f64 = 200.0;

/// Poses of a robot at rest from which on they say something.
const ENOUGH: f64 = 10.0;

/// What a noise is at least: no tracker is exact.
pub const LEAST_NOISE: PoseNoise = PoseNoise { position: 5e-5, heading: 2e-4 };

/// A noise as it is identified: standard deviations in m or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identified {
    /// Root of the expected variance.
    pub sd: f64,
    /// Its 90 % interval, as likely below as above.
    pub interval: (f64, f64),
}

/// What one pose after another adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// How far the pose lies from where the pose before it and the commands lead: x, y in m and heading in rad.
    pub off: [f64; 3],
    /// Commanded motion in m^2 and rad^2 that a ratio's variance over 100 ms is multiplied with; zero at rest.
    pub power: [f64; 2],
}

/// What is believed of the noise of poses: of x, y and heading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "[Kept; 3]", into = "[Kept; 3]")]
pub struct NoiseBelief([Axis; 3]);

impl Default for NoiseBelief {
    fn default() -> Self {
        let PoseNoise { position, heading } = PoseNoise::CAMERA;
        Self([Axis::new(position), Axis::new(position), Axis::new(heading)])
    }
}

impl NoiseBelief {
    /// Takes in a pose.
    pub fn push(&mut self, step: &Step) {
        let [position, heading] = step.power;
        let by = [(position, LEAST_RATIO.0), (position, LEAST_RATIO.0), (heading, LEAST_RATIO.1)];
        for ((axis, off), (power, ratio)) in self.0.iter_mut().zip(step.off).zip(by) {
            if position == 0.0 && heading == 0.0 {
                axis.rest(off);
            } else {
                axis.push(off, ratio * power);
            }
        }
    }

    /// Poses begin anew.
    pub fn begin(&mut self) {
        self.0.iter_mut().for_each(Axis::begin);
    }

    /// The noise of x, y and heading.
    pub fn identified(&self) -> [Identified; 3] {
        [0, 1, 2].map(|index| self.0[index].identified())
    }

    /// Poses of a moving robot that it rests on.
    pub fn poses(&self) -> f64 {
        self.0[0].poses
    }

    /// The noise of a pose to reckon with: variances of x, y and heading.
    pub fn variances(&self) -> [f64; 3] {
        let [position, heading] = [LEAST_NOISE.position, LEAST_NOISE.heading];
        let least = [position, position, heading];
        [0, 1, 2].map(|index| self.0[index].variance().max(least[index] * least[index]))
    }

    /// The same, as it is described.
    pub fn noise(&self) -> PoseNoise {
        let [x, y, heading] = self.variances();
        PoseNoise { position: f64::midpoint(x, y).sqrt(), heading: heading.sqrt() }
    }
}

/// One axis of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    filters: [Filter; RATIOS],
    /// Poses taken in.
    poses: f64,
    /// Variance that is expected before any.
    prior: f64,
    /// Sum of squares of the differences of poses at rest, and their number.
    resting: (f64, f64),
}

/// The filter of one ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Filter {
    /// How far the walk lies from the last pose, in m or rad.
    mean: f64,
    /// Its variance in parts of that of the noise.
    variance: f64,
    /// Sum of squares of innovations, each in parts of its variance.
    square: f64,
    /// Sum of the logarithms of those variances.
    ln_variance: f64,
}

impl Filter {
    const NEW: Self = Self { mean: 0.0, variance: 1.0, square: 0.0, ln_variance: 0.0 };

    /// Goes on to a pose that lies `off` from where the last one and the commands lead, where the walk `gained` this variance.
    /// By how much it lies off from what is expected, squared, and the variance of that.
    fn step(&mut self, off: f64, gained: f64) -> (f64, f64) {
        let before = self.variance + gained;
        let total = before + 1.0;
        let innovation = off - self.mean;
        self.mean = -innovation / total;
        self.variance = before / total;
        (innovation * innovation, total)
    }

    /// Learns from such a pose; of what was learned before this part stays.
    fn learn(&mut self, off: f64, gained: f64, stays: f64) {
        let (square, total) = self.step(off, gained);
        self.square = self.square * stays + square / total;
        self.ln_variance = self.ln_variance * stays + total.ln();
    }
}

impl Axis {
    fn new(sd: f64) -> Self {
        Self { filters: [Filter::NEW; RATIOS], poses: 0.0, prior: sd * sd, resting: (0.0, 0.0) }
    }

    fn push(&mut self, off: f64, least: f64) {
        self.poses = self.poses * STAYS + 1.0;
        let mut gained = least;
        for filter in &mut self.filters {
            filter.learn(off, gained, STAYS);
            gained *= 10.0;
        }
    }

    fn rest(&mut self, off: f64) {
        let (square, count) = self.resting;
        self.resting = (square * STAYS + off * off / 2.0, count * STAYS + 1.0);
        for filter in &mut self.filters {
            filter.step(off, 0.0);
        }
    }

    fn begin(&mut self) {
        for filter in &mut self.filters {
            (filter.mean, filter.variance) = (0.0, 1.0);
        }
    }

    /// Variance of the noise by each ratio, and how likely that is.
    fn weighted(&self) -> [(f64, f64); RATIOS] {
        let degrees = DEGREES + self.poses;
        let squares = |filter: &Filter| DEGREES * self.prior + filter.square;
        let ln_evidence =
            self.filters.map(|it| -0.5 * (it.ln_variance + degrees * squares(&it).ln()));
        let best = ln_evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let likely = ln_evidence.map(|it| (it - best).exp());
        let sum: f64 = likely.iter().sum();
        std::array::from_fn(|index| (squares(&self.filters[index]) / degrees, likely[index] / sum))
    }

    /// The variance to reckon with: that of a moving robot, or of one at rest where that is more.
    fn variance(&self) -> f64 {
        let moving: f64 = self.weighted().iter().map(|(variance, weight)| variance * weight).sum();
        moving.max(self.resting())
    }

    fn resting(&self) -> f64 {
        let (square, count) = self.resting;
        if count >= ENOUGH { square / count } else { 0.0 }
    }

    /// By a normal distribution of the logarithm of the variance: that of scaled inverse chi-squared with n degrees of freedom
    /// has variance 2/n, and what the ratios differ by.
    fn identified(&self) -> Identified {
        let weighted = self.weighted();
        let degrees = DEGREES + self.poses;
        let mean: f64 = weighted.iter().map(|(variance, weight)| weight * variance.ln()).sum();
        let apart: f64 = weighted
            .iter()
            .map(|(variance, weight)| weight * (variance.ln() - mean) * (variance.ln() - mean))
            .sum();
        let half = NORMAL_HALF_WIDTH * (apart + 2.0 / degrees + 2.0 / (degrees * degrees)).sqrt();
        let sd = |ln_variance: f64| (0.5 * ln_variance).exp();
        Identified { sd: self.variance().sqrt(), interval: (sd(mean - half), sd(mean + half)) }
    }
}

/// The stored form of an axis.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Kept {
    variance: f64,
    poses: f64,
    resting: f64,
    at_rest: f64,
}

impl From<NoiseBelief> for [Kept; 3] {
    fn from(NoiseBelief(axes): NoiseBelief) -> Self {
        axes.map(|axis| {
            let variance = axis.weighted().iter().map(|(variance, weight)| variance * weight).sum();
            let (square, count) = axis.resting;
            Kept { variance, poses: axis.poses.min(KEPT), resting: square, at_rest: count }
        })
    }
}

impl From<[Kept; 3]> for NoiseBelief {
    fn from(kept: [Kept; 3]) -> Self {
        let mut belief = Self::default();
        for (axis, it) in belief.0.iter_mut().zip(kept) {
            axis.poses = it.poses;
            axis.resting = (it.resting, it.at_rest);
            let square = it.variance * (DEGREES + it.poses) - DEGREES * axis.prior;
            axis.filters.iter_mut().for_each(|filter| filter.square = square.max(0.0));
        }
        belief
    }
}
