//! What is believed of a robot's drive: how long it takes to follow a command, identified from poses and from what the robot
//! reports to have played.
//!
//! From poses and commands alone only the **sum** of dead time, lag and the offset of the poses' stamps is known well; how
//! it parts into dead time and lag shows in the shape of starts and stops, as far as the noise allows. Both are hypotheses
//! on a grid (`grid`), each judged by how well it predicts the poses of a [`Stretch`] of motion. What else is unknown
//! meanwhile, scale and slip, is carried along (`filter`) and integrated out.

mod axis;
mod band;
mod estimate;
mod filter;
mod grid;
mod parts;
mod recording;
mod regression;
mod skid;
mod spreads;
mod standing;
mod stretch;

pub use band::{DeadBand, Turning};
pub use estimate::{DriveEstimate, PROPOSED_FROM, Quantity, ScaleEstimate, SkidEstimate};
pub use grid::{LONGEST, PRIOR_MEDIAN, PRIOR_SPREAD};
pub use recording::{Comparison, ErrorsAhead, Followed, Identified, Percentiles, Recording};
pub use standing::{settles, shows};
pub use stretch::{APART, Commanded, GAP, MAX_POSES, MAX_SPAN, Stretch};

use crate::exchange::PoseNoise;
use crate::kinematics::Drive;
use crate::prediction::Scale;
use filter::{Filters, Judgement};
use grid::{Grid, Hypothesis};
use parts::{Normal, Parts};
use regression::{Delay, Regression};
use serde::{Deserialize, Serialize};
use skid::SkidBelief;
use spreads::{DRIFT, OTHER_FLOOR};

/// Standard deviations squared of a pose from where the best hypothesis has it, on average, up to which a stretch says what
/// it seems to: half of all that are understood stay below one.
const UNDERSTOOD: f64 = 1.3;

/// The same from which on a stretch is not understood by any hypothesis, and says nothing.
const NOT_UNDERSTOOD: f64 = 25.0;

/// Times the described noise from which on it is another one.
const NOISIER: f64 = 2.0;

/// How often a stretch is judged at most, each time by hypotheses that lie finer or farther.
const ROUNDS: u32 = 5;

/// What is believed of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveBelief {
    /// Dead time and lag.
    grid: Grid,
    /// Scale of turns, and drift; scale of forward motion.
    turn: Regression<2>,
    forward: Regression<1>,
    /// What of scales and drift belongs to the robot: forward, turn, drift.
    parts: [Parts; 3],
    /// Whether it moves as skid steer does; none before the first stretch.
    #[serde(default)]
    skid: Option<SkidBelief>,
    /// Floors before this one.
    floors: u64,
    /// Stretches of motion taken in, and those that no hypothesis explains.
    stretches: u64,
    not_understood: u64,
    /// Up to which speed its wheels do not turn.
    #[serde(default)]
    band: DeadBand,
}

/// A scale below this is none: a quarter of what is commanded.
const LEAST_SCALE: f64 = -0.75;

impl DriveBelief {
    /// The belief before any sample, of a robot with this track in m of whose drive nothing else is known.
    pub fn new(track_width: f64) -> Self {
        Self::with(Grid::prior(), track_width)
    }

    /// The belief before any sample where it is known how late the drive follows.
    pub fn of_known_lag(drive: &Drive) -> Self {
        Self::with(Grid::known(drive.dead_time, drive.lag), drive.track_width)
    }

    /// The same where the sum of dead time and lag in s is about known.
    fn near(sum: f64, track_width: f64) -> Self {
        Self::with(Grid::near(sum.max(0.0)), track_width)
    }

    /// The same motors with other wheels, this track in m apart: how late they follow and below which speed they stand stays.
    pub fn with_other_wheels(self, track_width: f64) -> Self {
        let Self { stretches, not_understood, band, .. } = self;
        Self { stretches, not_understood, band, ..Self::with(self.grid, track_width) }
    }

    fn with(grid: Grid, track_width: f64) -> Self {
        let parts = spreads::parts(track_width);
        let [forward, turn, drift] = parts.map(|part| part.together());
        Self {
            grid,
            turn: Regression::new([turn, drift]),
            forward: Regression::new([forward]),
            parts,
            skid: None,
            floors: 0,
            stretches: 0,
            not_understood: 0,
            band: DeadBand::default(),
        }
    }

    /// Takes in which wheels turned in a stretch of motion of a robot with this drive, as it was `commanded` whatever its
    /// wheels make of that, and that follows after `settles` s. Whether each that could be judged did; none where none could.
    pub fn judge_wheels(
        &mut self,
        stretch: &Stretch,
        commanded: &Commanded,
        drive: &Drive,
        settles: f64,
        noise: PoseNoise,
    ) -> Option<bool> {
        let judged = standing::judgements(stretch, commanded, drive, settles, noise);
        judged.iter().for_each(|judgement| self.band.update(*judgement));
        (!judged.is_empty()).then(|| judged.iter().all(|it| it.moved))
    }

    /// Whether [`DriveBelief::judge_wheels`] would judge any.
    pub fn can_judge(
        stretch: &Stretch,
        commanded: &Commanded,
        drive: &Drive,
        settles: f64,
        noise: PoseNoise,
    ) -> bool {
        !standing::judgements(stretch, commanded, drive, settles, noise).is_empty()
    }

    /// What is believed of the dead band.
    pub fn dead_band(&self) -> &DeadBand {
        &self.band
    }

    /// Takes back what was judged since it was `band`.
    pub fn restore_dead_band(&mut self, band: DeadBand) {
        self.band = band;
    }

    /// Takes in a stretch of motion of a robot with this track in m, whose poses are known to `noise`. Whether it was
    /// understood.
    pub fn update(
        &mut self,
        stretch: &Stretch,
        commanded: &Commanded,
        noise: PoseNoise,
        track_width: f64,
    ) -> bool {
        let seen = stretch.noise().unwrap_or_default();
        let noise = PoseNoise {
            position: believed(noise.position, seen.position, PoseNoise::LEAST.position),
            heading: believed(noise.heading, seen.heading, PoseNoise::LEAST.heading),
        };
        self.turn.mix(OTHER_FLOOR);
        self.forward.mix(OTHER_FLOOR);
        let mut before = self.grid.clone();
        for round in 1..=ROUNDS {
            let judge = |it| self.judge(it, stretch, commanded, noise, track_width);
            let judged: Vec<Judged> = before.alive().map(judge).collect();
            let surprise = judged.iter().map(|it| it.surprise).fold(f64::INFINITY, f64::min);
            let after = weighed(&before, &judged, surprise);
            // Judged again, not interpolated: between the points of a coarse grid there may be a better hypothesis.
            if round < ROUNDS
                && let Some(fitted) = self.grid.fitted(&after)
            {
                before = fitted;
                continue;
            }
            if surprise > NOT_UNDERSTOOD {
                break;
            }
            let sum: f64 = judged.iter().map(|it| after.weight(&it.hypothesis)).sum();
            let weighted = || judged.iter().map(|it| (it, after.weight(&it.hypothesis) / sum));
            let turn = Regression::mixture(weighted().map(|(it, part)| (it.turn.known, part)));
            let forward =
                Regression::mixture(weighted().map(|(it, part)| (it.forward.known, part)));
            // Wheels that stand are no small wheels.
            if turn.of(0).mean < LEAST_SCALE || forward.of(0).mean < LEAST_SCALE {
                break;
            }
            (self.turn, self.forward) = (turn, forward);
            self.grid = after;
            self.stretches += 1;
            // Poses that are worse than described say less of this, too.
            let worse = surprise.max(1.0).sqrt();
            let noise =
                PoseNoise { position: worse * noise.position, heading: worse * noise.heading };
            let late = self.grid.expected();
            let skid = self.skid.get_or_insert_with(|| SkidBelief::new(track_width));
            skid.update(stretch, commanded, noise, late);
            return true;
        }
        self.not_understood += 1;
        false
    }

    /// What `hypothesis` makes of a stretch.
    fn judge(
        &self,
        hypothesis: Hypothesis,
        stretch: &Stretch,
        commanded: &Commanded,
        noise: PoseNoise,
        track_width: f64,
    ) -> Judged {
        let Hypothesis { sum, share, .. } = hypothesis;
        let delay = Delay::new(sum, share);
        let mut turn = Filters::new(&self.turn.at(delay), noise.heading);
        let mut forward = Filters::new(&self.forward.at(delay), noise.position);
        let (dead_time, lag) = (sum * (1.0 - share), sum * share);
        let drift = DRIFT / track_width;
        // The same poses for all hypotheses: a pose more is evidence more.
        let (mut steps, drives) = (0.0, commanded.drives());
        stretch.compare(commanded, dead_time, lag, |motion, seen| {
            let turn_power = motion.turn_power + drift * drift * motion.length_power;
            turn.step([motion.turn, motion.length], turn_power, seen.turned);
            if drives {
                forward.step([motion.length], motion.length_power, seen.driven);
                steps += 1.0;
            }
            steps += 1.0;
        });
        let (turn, forward) = (turn.judgement(), forward.judgement());
        let surprise = (turn.square + forward.square) / steps;
        Judged { hypothesis, turn, forward, surprise }
    }

    /// Forward motion, turns and drift against what is described, robot and floor together.
    fn together(&self) -> [Normal; 3] {
        [self.forward.of(0), self.turn.of(0), self.turn.of(1)]
    }

    /// How the drive differs from what is described, on this floor.
    pub fn scale(&self) -> Scale {
        let [forward, turn, drift] = self.together().map(|it| it.mean);
        Scale { forward, turn, drift }
    }

    /// How sure that is: standard deviations.
    pub fn scale_sd(&self) -> Scale {
        let [forward, turn, drift] = self.together().map(|it| it.variance.sqrt());
        Scale { forward, turn, drift }
    }

    /// The same belief on another floor: what the robot has shown on those before stays, as far as it was told from them.
    pub fn on_another_floor(mut self) -> Self {
        if self.stretches == 0 {
            return self;
        }
        let together = self.together();
        for (part, sum) in self.parts.iter_mut().zip(together) {
            *part = part.next(sum);
        }
        let [forward, turn, drift] = self.parts.map(|part| part.together());
        self.turn = Regression::new([turn, drift]);
        self.forward = Regression::new([forward]);
        self.skid = self.skid.map(SkidBelief::on_another_floor);
        self.floors += 1;
        self
    }

    /// The same belief of a drive that is described as of another kind: what was said of its kind was against the one before.
    pub fn of_another_kind(self) -> Self {
        Self { skid: None, ..self }
    }

    /// The same belief of a drive that is described as `now` from here on, and was as `before`.
    pub fn described_anew(mut self, before: &Drive, now: &Drive) -> Self {
        let forward = before.wheel_radius / now.wheel_radius;
        let turn = forward * now.track_width / before.track_width;
        self.forward.rescale([forward], [forward - 1.0]);
        self.turn.rescale([turn, forward], [turn - 1.0, 0.0]);
        let [of_forward, of_turn, of_drift] = self.parts;
        self.parts = [
            of_forward.rescaled(forward, forward - 1.0),
            of_turn.rescaled(turn, turn - 1.0),
            of_drift.rescaled(forward, 0.0),
        ];
        // What it says of turns is against the track as it was.
        self.of_another_kind()
    }

    /// The dead time and the lag in s that are expected, once any motion has taught them.
    pub fn late(&self) -> Option<(f64, f64)> {
        (self.stretches > 0).then(|| self.grid.expected())
    }

    /// Standard deviation in s of the sum of both.
    pub fn late_sd(&self) -> f64 {
        self.grid.sum_moments().1
    }

    /// As it is shown.
    pub fn estimate(&self) -> DriveEstimate {
        DriveEstimate {
            sum: self.grid.sum(),
            lag: self.grid.lag(),
            dead_time: self.grid.dead_time(),
            prior: Grid::prior().sum(),
            scale: std::array::from_fn(|i| {
                let (sum, part) = (self.together()[i], self.parts[i]);
                let [robot, floor] = [part.robot(sum), part.floor(sum)].map(Quantity::from);
                ScaleEstimate { together: sum.into(), robot, floor }
            }),
            skid: self.skid.as_ref().map(SkidBelief::estimate),
            dead_band: self.band.quantity(),
            dead_band_prior: DeadBand::default().quantity(),
            judgements: self.band.judged(),
            floors: self.floors,
            stretches: self.stretches,
            not_understood: self.not_understood,
        }
    }
}

/// The noise of a pose that is described so and `seen` so.
fn believed(described: f64, seen: f64, least: f64) -> f64 {
    let described = described.max(least);
    if seen > NOISIER * described { seen } else { described }
}

/// The grid `before` a stretch with what was made of it, by hypotheses the best of which leaves this `surprise`.
fn weighed(before: &Grid, judged: &[Judged], surprise: f64) -> Grid {
    // Poses that are worse than described say less.
    let worth = (UNDERSTOOD / surprise).min(1.0);
    let best = judged.iter().map(Judged::ln_evidence).fold(f64::NEG_INFINITY, f64::max);
    let mut after = before.clone();
    for it in judged {
        let likely = ((it.ln_evidence() - best) * worth).exp();
        after.set(&it.hypothesis, it.hypothesis.weight * likely);
    }
    after.normalise();
    after
}

/// What one hypothesis makes of a stretch.
struct Judged {
    hypothesis: Hypothesis,
    turn: Judgement<2>,
    forward: Judgement<1>,
    /// Mean square of how far the poses lie off in standard deviations, of the level that predicts them best.
    surprise: f64,
}

impl Judged {
    fn ln_evidence(&self) -> f64 {
        self.turn.ln_evidence + self.forward.ln_evidence
    }
}

#[cfg(test)]
mod tests;
