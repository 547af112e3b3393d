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
use crate::identification::{Status, progress};
use crate::settings::Method;
use serde::{Deserialize, Serialize};

/// Ratios of the variance that a walk gains per unit of commanded motion to that of the noise, half a decade apart.
const RATIOS: usize = 17;

/// The least ratio: of a position in 1/m^2, where errors of 0.3 % of the motion in 100 ms are seen with 10 mm; of a heading on
/// the way of a wheel in 1/m^2, with 0.1 rad.
const LEAST_RATIO: [f64; 2] = [0.1, 1.0];

/// A ratio to the one before.
const RATIO: f64 = 3.162_277_660_168_379_5;

/// Steps between two of them in which their evidence is interpolated.
const FINER: usize = 4;

/// Ratios of which the evidence is known so.
const PLACES: usize = (RATIOS - 1) * FINER + 1;

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

/// Poses after which a noise is computed anew, once there are many.
const SOME: u32 = 16;

/// The noise of positions or headings as it is identified: standard deviations in m or rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// The standard deviation that is as likely more as less.
    pub sd: f64,
    /// Its 90 % interval, as likely below as above.
    pub interval: (f64, f64),
    /// How many poses that is worth.
    pub poses: f64,
}

/// How a robot moved between two poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Not at all.
    Rest,
    /// It drove, straight on or along a curve.
    Drive,
    /// It turned in place.
    Turn,
    /// It became faster or slower: how late it follows is not known well enough.
    Unsteady,
}

/// What one pose after another adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// How far the pose lies from where the pose before it and the commands lead: forward, lateral in m and turn in rad.
    pub off: [f64; 3],
    /// The turn commanded between them in rad.
    pub turn: f64,
    /// What kind of motion that was.
    pub kind: Kind,
    /// What of the motion a ratio's variance over 100 ms is multiplied with, in m^2: that of the wheels.
    pub power: f64,
}

/// What is believed of the noise of poses. What of it is to be kept is what is [identified](NoiseBelief::identified).
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseBelief {
    /// Forward, lateral and turn, of a driving robot and of one that turns in place: floors treat them each in its way.
    banks: [[Bank; 3]; 2],
    /// The kind of motion under way.
    kind: Kind,
    /// Sums of squares of the differences of poses at rest, of position and heading, and their number.
    resting: [(f64, f64); 2],
    /// Position and heading, and after how many more poses they are computed anew.
    identified: [Identified; 2],
    due: u32,
}

impl Default for NoiseBelief {
    fn default() -> Self {
        let bank = Bank { filters: [Filter::NEW; RATIOS], poses: 0.0 };
        let mut new = Self {
            banks: [[bank; 3]; 2],
            kind: Kind::Rest,
            resting: [(0.0, 0.0); 2],
            identified: [Identified { sd: 0.0, interval: (0.0, 0.0), poses: 0.0 }; 2],
            due: 0,
        };
        new.identify();
        new
    }
}

impl Identified {
    /// How far it has got.
    pub fn status(&self) -> Status {
        Status::of(progress(self.poses, DEGREES))
    }
}

impl NoiseBelief {
    /// The belief at first, where a robot of this `method` is one whose poses are fused.
    pub fn asked(method: Method) -> Option<Box<Self>> {
        (method == Method::Adaptive).then(Box::default)
    }

    /// Goes on from what was identified, of which the last poses count: the tracker may be another one.
    pub fn of(identified: [Identified; 2]) -> Self {
        let mut belief = Self { identified, ..Self::default() };
        for (axis, it) in [0, 2].into_iter().zip(identified) {
            let bank = &mut belief.banks[0][axis];
            bank.poses = it.poses.clamp(0.0, KEPT);
            let square = bank.poses * it.sd * it.sd;
            bank.filters.iter_mut().for_each(|filter| filter.square = square);
        }
        belief
    }

    /// Takes in a pose.
    pub fn push(&mut self, step: &Step) {
        if step.kind != self.kind && step.kind != Kind::Rest {
            self.begin();
        }
        let banks = match step.kind {
            Kind::Unsteady => return self.begin(),
            Kind::Rest => return self.rest(step),
            Kind::Drive => &mut self.banks[0],
            Kind::Turn => &mut self.banks[1],
        };
        let [of_position, of_heading] = LEAST_RATIO;
        let gained = [of_position, of_position, of_heading].map(|it| it * step.power);
        // What lay ahead lies aside after a turn.
        let (sin, cos) = step.turn.sin_cos();
        for index in 0..RATIOS {
            let [ahead, aside] = [0, 1].map(|axis| banks[axis].filters[index].mean);
            banks[0].filters[index].mean = cos * ahead + sin * aside;
            banks[1].filters[index].mean = cos * aside - sin * ahead;
        }
        for ((bank, off), gained) in banks.iter_mut().zip(step.off).zip(gained) {
            bank.push(off, gained);
        }
        self.kind = step.kind;
        self.due = self.due.saturating_sub(1);
        if self.due == 0 {
            self.identify();
        }
    }

    fn rest(&mut self, step: &Step) {
        self.begin();
        let [ahead, aside, around] = step.off.map(|off| off * off / 2.0);
        for ((square, count), off) in
            self.resting.iter_mut().zip([f64::midpoint(ahead, aside), around])
        {
            *square = *square * STAYS + off;
            *count = *count * STAYS + 1.0;
        }
    }

    /// Poses begin anew.
    pub fn begin(&mut self) {
        self.kind = Kind::Rest;
        self.banks.iter_mut().flatten().for_each(Bank::begin);
    }

    /// Computes both anew.
    fn identify(&mut self) {
        let PoseNoise { position, heading } = PoseNoise::CAMERA;
        let [driving, turning] = &self.banks;
        let of_position = [&driving[0], &driving[1], &turning[0], &turning[1]];
        let of_heading = [&driving[2], &turning[2]];
        self.identified = [
            identified(&of_position.map(|bank| bank.belief(position * position))),
            identified(&of_heading.map(|bank| bank.belief(heading * heading))),
        ];
        let poses = self.identified[0].poses;
        self.due = if poses < f64::from(4 * SOME) { 1 } else { SOME };
    }

    /// The noise of positions and of headings.
    pub fn identified(&self) -> [Identified; 2] {
        self.identified
    }

    /// The noise of a pose to reckon with: that of a moving robot, or of one at rest where that is surely more.
    pub fn noise(&self) -> PoseNoise {
        let least = [PoseNoise::LEAST.position, PoseNoise::LEAST.heading];
        let [position, heading] = [0, 1].map(|index| {
            let (square, count) = self.resting[index];
            let surely = 1.0 - 2.0 * (2.0 / count.max(ENOUGH)).sqrt();
            let resting = if count >= ENOUGH { surely * square / count } else { 0.0 };
            self.identified[index].sd.max(resting.sqrt()).max(least[index])
        });
        PoseNoise { position, heading }
    }
}

/// One axis of poses in one kind of motion: a filter for each ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bank {
    filters: [Filter; RATIOS],
    /// Poses taken in.
    poses: f64,
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

    /// Goes on to a pose that lies `off` from where the last one and the commands lead, where the walk `gained` this variance,
    /// and learns by how much it lies off from what is expected.
    fn push(&mut self, off: f64, gained: f64) {
        let before = self.variance + gained;
        let total = before + 1.0;
        let innovation = off - self.mean;
        self.mean = -innovation / total;
        self.variance = before / total;
        self.square = self.square * STAYS + innovation * innovation / total;
        self.ln_variance = self.ln_variance * STAYS + total.ln();
    }
}

impl Bank {
    fn push(&mut self, off: f64, least: f64) {
        self.poses = self.poses * STAYS + 1.0;
        let mut gained = least;
        for filter in &mut self.filters {
            filter.push(off, gained);
            gained *= RATIO;
        }
    }

    fn begin(&mut self) {
        for filter in &mut self.filters {
            (filter.mean, filter.variance) = (0.0, 1.0);
        }
    }

    /// Mean and variance of the logarithm of the noise's variance, which is expected to be `prior`: those of scaled inverse
    /// chi-squared for each ratio, by the evidence of each. Between the ratios the sums are interpolated: they change little
    /// from one to the next.
    fn belief(&self, prior: f64) -> (f64, f64) {
        let degrees = DEGREES + self.poses;
        let at = |place: f64| {
            let index = (place as usize).min(RATIOS - 2);
            let part = place - index as f64;
            let of = |value: fn(&Filter) -> f64| {
                let ends = [-1isize, 0, 1, 2].map(|off| {
                    let index = index.saturating_add_signed(off).min(RATIOS - 1);
                    value(&self.filters[index])
                });
                cubic(ends, part)
            };
            let square = DEGREES * prior + of(|it| it.square).max(0.0);
            let ln_evidence = -0.5 * (of(|it| it.ln_variance) + degrees * square.ln());
            ((square / degrees).ln() + degrees.recip(), ln_evidence)
        };
        let places: [(f64, f64); PLACES] =
            std::array::from_fn(|step| at(step as f64 / FINER as f64));
        let best = places.iter().map(|(_, ln)| *ln).fold(f64::NEG_INFINITY, f64::max);
        let mut sums = [0.0; 3];
        for (value, ln_evidence) in places {
            let weight = (ln_evidence - best).exp();
            let next = [weight, weight * value, weight * value * value];
            sums.iter_mut().zip(next).for_each(|(sum, next)| *sum += next);
        }
        let (mean, square) = (sums[1] / sums[0], sums[2] / sums[0]);
        let within = 2.0 / degrees + 2.0 / (degrees * degrees);
        (mean, (square - mean * mean).max(0.0) + within)
    }
}

/// The noise of which several beliefs tell: normal distributions of the logarithm of its variance.
fn identified(beliefs: &[(f64, f64)]) -> Identified {
    let information: f64 = beliefs.iter().map(|(_, variance)| variance.recip()).sum();
    let mean = beliefs.iter().map(|(mean, variance)| mean / variance).sum::<f64>() / information;
    let half = NORMAL_HALF_WIDTH * information.recip().sqrt();
    let sd = |ln_variance: f64| (0.5 * ln_variance).exp();
    Identified {
        sd: sd(mean),
        interval: (sd(mean - half), sd(mean + half)),
        poses: 2.0 * information,
    }
}

/// A value between the two in the middle of four that are evenly apart, `part` of the way (Catmull-Rom).
fn cubic([before, from, to, after]: [f64; 4], part: f64) -> f64 {
    let (slope, end) = ((to - before) / 2.0, (after - from) / 2.0);
    let apart = to - from;
    let bend = 3.0 * apart - 2.0 * slope - end;
    let twist = slope + end - 2.0 * apart;
    from + part * (slope + part * (bend + part * twist))
}
