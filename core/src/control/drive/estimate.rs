//! What is believed of a drive, as it is shown.

use crate::identification::Status;
use crate::identification::estimate::{LEVEL, NORMAL_HALF_WIDTH};

/// Probability of each tail outside an interval that is shown.
const TAIL: f64 = (1.0 - LEVEL) / 2.0;

/// A quantity with its uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantity {
    /// Its expected value.
    pub mean: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// Holds it with probability [`LEVEL`], as likely below as above.
    pub interval: (f64, f64),
}

impl Quantity {
    /// Of a normal distribution.
    pub fn normal(mean: f64, variance: f64) -> Self {
        let sd = variance.max(0.0).sqrt();
        let half = NORMAL_HALF_WIDTH * sd;
        Self { mean, sd, interval: (mean - half, mean + half) }
    }

    /// Of a mixture of even distributions, each from its first to its second value with its weight.
    pub(super) fn of(cells: impl Iterator<Item = Cell> + Clone) -> Self {
        // Weights are kept to three digits: they sum to about one.
        let sum: f64 = cells.clone().map(|(_, _, weight)| weight).sum();
        let (mean, sd) = moments(cells.clone());
        let cells = cells.map(|(low, high, weight)| (low, high, weight / sum));
        let quantile = |p: f64| {
            let below = |x: f64| -> f64 {
                let part = |low: f64, high: f64| {
                    if high > low {
                        ((x - low) / (high - low)).clamp(0.0, 1.0)
                    } else {
                        f64::from(u8::from(x >= low))
                    }
                };
                cells.clone().map(|(low, high, weight)| weight * part(low, high)).sum()
            };
            let (mut low, mut high) = cells
                .clone()
                .fold((f64::INFINITY, 0.0f64), |(low, high), it| (low.min(it.0), high.max(it.1)));
            for _ in 0..40 {
                let middle = (low + high) / 2.0;
                if below(middle) < p { low = middle } else { high = middle }
            }
            (low + high) / 2.0
        };
        Self { mean, sd, interval: (quantile(TAIL), quantile(1.0 - TAIL)) }
    }
}

/// An even distribution from the first to the second value, and its weight.
pub(super) type Cell = (f64, f64, f64);

/// Mean and standard deviation of a mixture.
pub(super) fn moments(cells: impl Iterator<Item = Cell> + Clone) -> (f64, f64) {
    let sum: f64 = cells.clone().map(|(_, _, weight)| weight).sum();
    let cells = cells.map(|(low, high, weight)| (low, high, weight / sum));
    let mean: f64 = cells.clone().map(|(low, high, weight)| weight * (low + high) / 2.0).sum();
    let variance = |(low, high, weight): Cell| {
        let (off, half) = ((low + high) / 2.0 - mean, (high - low) / 2.0);
        weight * (off * off + half * half / 3.0)
    };
    (mean, cells.map(variance).sum::<f64>().sqrt())
}

/// By how much motion differs from what was commanded.
///
/// On one floor only `together` is known from poses and commands; robot and floor part over several floors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleEstimate {
    /// Robot and floor together.
    pub together: Quantity,
    /// What of it belongs to the robot.
    pub robot: Quantity,
    /// What of it belongs to the floor.
    pub floor: Quantity,
}

/// Natural logarithm of the evidence from which on skid steer is proposed: a hundred to one.
pub const PROPOSED_FROM: f64 = 4.605;

/// How a robot differs from a differential drive if it is skid-steer, and the evidence that it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkidEstimate {
    /// Motion of the tracked point to the left in m per radian of turn to the left. A point that is tracked ahead of the axle
    /// or behind it moves in the same way.
    pub sideways: Quantity,
    /// By what part turns grow per m/s of speed, in s/m.
    pub turn_by_speed: Quantity,
    /// Natural logarithm of the evidence of skid steer against differential drive.
    pub ln_evidence: f64,
}

impl SkidEstimate {
    /// Whether the robot is to be proposed to be described as skid steer.
    pub fn is_proposed(&self) -> bool {
        self.ln_evidence >= PROPOSED_FROM
    }
}

/// What is believed of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveEstimate {
    /// Dead time, lag and offset of the poses' stamps in s, together.
    pub sum: Quantity,
    /// The lag in s.
    pub lag: Quantity,
    /// The dead time in s, with the offset of the stamps in it.
    pub dead_time: Quantity,
    /// The sum before any sample.
    pub prior: Quantity,
    /// Forward motion per forward motion commanded, less one; turn per turn, less one; turn in rad per metre.
    pub scale: [ScaleEstimate; 3],
    /// Whether it moves as skid steer does; none before any motion.
    pub skid: Option<SkidEstimate>,
    /// Commanded speed of a wheel in rad/s up to which it does not turn. Where it may be none to speak of its interval
    /// begins at 0 and leaves the rest above.
    pub dead_band: Quantity,
    /// The same before any judgement.
    pub dead_band_prior: Quantity,
    /// How often a wheel was seen to turn at a steady command, or to stand.
    pub judgements: u64,
    /// Floors before this one.
    pub floors: u64,
    /// Stretches of motion taken in.
    pub stretches: u64,
    /// Those that no hypothesis explains.
    pub not_understood: u64,
}

impl DriveEstimate {
    /// How far the estimate of the sum has got: what is known of it beyond the prior, against what that says.
    pub fn status(&self) -> Status {
        status(self.sum, self.prior)
    }

    /// The same of the dead band.
    pub fn dead_band_status(&self) -> Status {
        status(self.dead_band, self.dead_band_prior)
    }
}

/// How far an estimate has got whose prior is `prior`: where it knows as much again it is complete.
fn status(now: Quantity, prior: Quantity) -> Status {
    let information = |it: Quantity| (it.sd * it.sd).recip();
    let before = information(prior);
    Status::of(((information(now) - before) / before).clamp(0.0, 1.0))
}
