//! Whether a robot that is described as differential moves as skid steer does: what its poses say of sideways motion in turns
//! and of turns that change with speed, and the evidence of the one kind against the other.
//!
//! From poses alone the tracked point of a skid-steer robot cannot be told from one that is mounted ahead of the axle or
//! behind it: both go sideways by as much per radian.

use super::estimate::SkidEstimate;
use super::filter::Filters;
use super::parts::Normal;
use super::regression::Regression;
use super::spreads::{DRIFT, OTHER_FLOOR, parts};
use super::stretch::{Commanded, Stretch};
use crate::exchange::PoseNoise;
use serde::{Deserialize, Serialize};

/// Standard deviations of the sideways motion per radian as parts of the track: of skid steer, and of a differential drive,
/// whose marker is mounted to so much of where it should be.
const SIDEWAYS: [f64; 2] = [0.25, 0.03];

/// Standard deviations of the change of the turn ratio up to a usual largest speed: of skid steer, and of a differential
/// drive, whose tyres give a little.
const BY_SPEED: [f64; 2] = [0.15, 0.03];

/// Largest speeds of robots in tracks per second, about: 1.3 of the thesis's, 1.4 to 2.9 of those of the field facts.
const USUAL_SPEED: f64 = 1.5;

/// Standard deviation of the sideways motion per metre: of markers and frames that are rotated, of slopes.
const CRAB: f64 = 0.05;

/// What is believed of how it moves sideways and of how its turns change with speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SkidBelief {
    /// The track in m.
    track_width: f64,
    /// Motion to the left per radian, and per metre.
    aside: Regression<2>,
    /// Scale of turns, drift, and scale of turns per m/s.
    turn: Regression<3>,
}

impl SkidBelief {
    /// Before any sample, of a robot with this track in m.
    pub fn new(track_width: f64) -> Self {
        let of = |sd: f64| Normal { mean: 0.0, variance: sd * sd };
        let [_, scale, drift] = parts(track_width).map(|part| part.together());
        let sideways = of(SIDEWAYS[0] * track_width);
        let by_speed = of(BY_SPEED[0] / (USUAL_SPEED * track_width));
        Self {
            track_width,
            aside: Regression::new([sideways, of(CRAB)]),
            turn: Regression::new([scale, drift, by_speed]),
        }
    }

    /// Takes in a stretch of motion of a robot that follows with this dead time and lag in s, whose poses are known to
    /// `noise`.
    pub fn update(
        &mut self,
        stretch: &Stretch,
        commanded: &Commanded,
        noise: PoseNoise,
        (dead_time, lag): (f64, f64),
    ) {
        self.aside.mix(OTHER_FLOOR);
        self.turn.mix(OTHER_FLOOR);
        let mut aside = Filters::new(&self.aside, noise.position);
        let mut turn = Filters::new(&self.turn, noise.heading);
        let (half, drift) = (self.track_width / 2.0, DRIFT / self.track_width);
        stretch.compare(commanded, dead_time, lag, |motion, seen| {
            // A turn slips aside as its wheels do.
            let slips = motion.length_power + half * half * motion.turn_power;
            let turned = 2.0 * (seen.turned / 2.0).sin();
            aside.step_from(0.0, [turned, motion.length], slips, seen.aside);
            let power = motion.turn_power + drift * drift * motion.length_power;
            let speed =
                if motion.duration > 0.0 { motion.length.abs() / motion.duration } else { 0.0 };
            let by = [motion.turn, motion.length, motion.turn * speed];
            turn.step_from(motion.turn, by, power, seen.turned);
        });
        self.aside = aside.judgement().known;
        self.turn = turn.judgement().known;
    }

    /// On another floor: what is the robot's stays.
    pub fn on_another_floor(self) -> Self {
        let prior = Self::new(self.track_width);
        Self {
            track_width: self.track_width,
            aside: Regression::new([self.aside.of(0), prior.aside.of(1)]),
            turn: Regression::new([prior.turn.of(0), prior.turn.of(1), self.turn.of(2)]),
        }
    }

    /// As it is shown.
    pub fn estimate(&self) -> SkidEstimate {
        let track_width = self.track_width;
        let (sideways, by_speed) = (self.aside.of(0), self.turn.of(2));
        let speed = USUAL_SPEED * track_width;
        SkidEstimate {
            sideways: sideways.into(),
            turn_by_speed: by_speed.into(),
            ln_evidence: ln_evidence(sideways, SIDEWAYS.map(|sd| sd * track_width))
                + ln_evidence(by_speed, BY_SPEED.map(|sd| sd / speed)),
        }
    }
}

/// Natural logarithm of the evidence for a quantity being drawn from a normal distribution around zero with the first
/// standard deviation, against one with the second, where it is `known` as the first one and what was seen make it.
///
/// What was seen alone has the precision 1/V - 1/sd^2 and the mean m (1/V)/(1/V - 1/sd^2); under either distribution its
/// predictive variance is that of both.
fn ln_evidence(known: Normal, [wide, narrow]: [f64; 2]) -> f64 {
    let precision = known.variance.recip() - (wide * wide).recip();
    if precision.is_nan() || precision <= 0.0 {
        return 0.0;
    }
    let (variance, mean) = (precision.recip(), known.mean / (known.variance * precision));
    let ln_density = |sd: f64| {
        let total = variance + sd * sd;
        -0.5 * (mean * mean / total + total.ln())
    };
    ln_density(wide) - ln_density(narrow)
}
#[cfg(test)]
mod tests {
    use super::*;

    fn density(x: f64, mean: f64, sd: f64) -> f64 {
        (-0.5 * ((x - mean) / sd).powi(2)).exp() / sd
    }

    /// What was seen under each distribution, summed over what the quantity may be.
    #[test]
    fn evidence_is_what_the_predictive_densities_sum_to() {
        let (wide, narrow, seen, noise) = (0.3, 0.04, 0.17, 0.05);
        let predictive = |sd: f64| -> f64 {
            let steps = -20_000..20_000;
            steps
                .map(|i| f64::from(i) * 1e-4)
                .map(|x| density(x, 0.0, sd) * density(seen, x, noise))
                .sum()
        };
        let expected = (predictive(wide) / predictive(narrow)).ln();
        let precision = 1.0 / (wide * wide) + 1.0 / (noise * noise);
        let known = Normal { mean: seen / (noise * noise) / precision, variance: 1.0 / precision };
        assert!((ln_evidence(known, [wide, narrow]) - expected).abs() < 1e-6);
        // Nothing seen says nothing.
        let prior = Normal { mean: 0.0, variance: wide * wide };
        assert_eq!(ln_evidence(prior, [wide, narrow]), 0.0);
    }
}
