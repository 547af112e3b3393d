//! The results of a comparison: every contender's distributions in numbers, and what the thesis's claims come to.

use super::bootstrap::{Replicates, Resamples, Sorted};
use super::contender::{BASELINE, CHAMPION, Contender};
use super::coverage::Coverage;
use super::episode::Trial;
use super::quantities::Quantities;
use super::settings::ComparisonSettings;
use crate::evolution::Estimate;
use serde::{Deserialize, Serialize};

/// How much smaller the thesis's abstract says the deviation is than that of [`BASELINE`].
pub const PROMISED_DEVIATION: f64 = 0.75;

/// How much shorter it says the completion time is.
pub const PROMISED_TIME: f64 = 0.35;

/// Completion time in s and largest deviation in m, or what is made of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Time from the end of the calibration to the arrival; a robot that did not arrive counts with the time limit.
    pub time: Quantities<Estimate>,
    /// Largest deviation of the true position from the current leg.
    pub deviation: Quantities<Estimate>,
}

/// When a contender recognised the environment that it was in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recognition {
    /// Share of the trials at whose end it did.
    pub share: f64,
    /// Samples, of all channels together, after which it did so for good, in half of the trials; none where it never
    /// did in more than half of them.
    pub median: Option<u64>,
    /// The same in 90 % of the trials.
    pub p90: Option<u64>,
}

/// A contender beside [`BASELINE`] with as many slots, paired by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// The other's label.
    pub against: String,
    /// This one's minus the other's.
    pub absolute: Summary,
    /// How much smaller this one's is, as a part of the other's: 1 - this/other.
    pub reduction: Summary,
}

/// A contender in an environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its label.
    pub contender: String,
    /// Share of the trials in which it arrived within the time limit.
    pub arrived: Estimate,
    /// Time and deviation.
    pub summary: Summary,
    /// When it recognised the right one; none where there was nothing to distinguish or it does not identify.
    pub recognition: Option<Recognition>,
    /// Share of the samples within the 90 % interval that it had predicted for each; none where it does not identify.
    pub coverage: Option<Estimate>,
    /// Beside [`BASELINE`]; none for that one itself or where it did not drive.
    pub difference: Option<Difference>,
}

/// An environment, with every contender in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentReport {
    /// Its name.
    pub environment: String,
    /// The contenders, in their order.
    pub entries: Vec<Entry>,
}

/// What the thesis's claim comes to: how much less [`CHAMPION`] deviates than [`BASELINE`], and how much sooner it
/// arrives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Where.
    pub environment: String,
    /// With how many slots.
    pub slots: usize,
    /// How much smaller the deviation is, as a part; the thesis says [`PROMISED_DEVIATION`].
    pub deviation: Quantities<Estimate>,
    /// How much shorter the time is, as a part; the thesis says [`PROMISED_TIME`].
    pub time: Quantities<Estimate>,
}

/// The results of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Trials of each contender in each environment.
    pub trials: usize,
    /// Environment by environment.
    pub environments: Vec<EnvironmentReport>,
    /// What the thesis's claims come to, wherever both methods drove.
    pub claims: Vec<Claim>,
}

/// A contender's trials in an environment, and what they are where they are drawn again.
struct Driven {
    time: Replicates<Quantities<f64>>,
    deviation: Replicates<Quantities<f64>>,
}

type Pick = fn(Quantities<f64>) -> f64;

/// The three numbers of a quantity.
const PICKS: Quantities<Pick> =
    Quantities { mean: |it| it.mean, median: |it| it.median, p90: |it| it.p90 };

impl Driven {
    fn new(trials: &[Trial], resamples: &Resamples) -> Self {
        let replicates = |of: fn(&Trial) -> f64| {
            let sorted = Sorted::new(trials.iter().map(of));
            resamples.of(|counts| sorted.quantities(counts))
        };
        Self { time: replicates(|it| it.time), deviation: replicates(|it| it.deviation) }
    }

    fn summary(&self) -> Summary {
        Summary {
            time: PICKS.map(|pick| self.time.estimate(pick)),
            deviation: PICKS.map(|pick| self.deviation.estimate(pick)),
        }
    }

    /// What `of` makes of each number and the same of `other`.
    fn paired(&self, other: &Self, of: fn(f64, f64) -> f64) -> Summary {
        let time =
            |pick: Pick| self.time.paired(&other.time, |this, other| of(pick(this), pick(other)));
        let deviation = |pick: Pick| {
            self.deviation.paired(&other.deviation, |this, other| of(pick(this), pick(other)))
        };
        Summary { time: PICKS.map(time), deviation: PICKS.map(deviation) }
    }
}

/// The report of `cells`: environment by environment, contender by contender.
pub(super) fn report(settings: &ComparisonSettings, cells: &[Vec<Trial>]) -> Report {
    let ComparisonSettings { contenders, environments, trials, seed, .. } = settings;
    let (mut reports, mut claims) = (Vec::new(), Vec::new());
    for (index, (environment, cells)) in
        environments.iter().zip(cells.chunks_exact(contenders.len())).enumerate()
    {
        let resamples = Resamples::new(*trials, *seed, index);
        let driven: Vec<_> = cells.iter().map(|trials| Driven::new(trials, &resamples)).collect();
        let mut entries = Vec::with_capacity(contenders.len());
        for (place, contender) in contenders.iter().enumerate() {
            let baseline = baseline(contenders, contender);
            let difference = baseline.filter(|baseline| *baseline != place).map(|baseline| {
                let (this, other) = (&driven[place], &driven[baseline]);
                Difference {
                    against: contenders[baseline].label(),
                    absolute: this.paired(other, |this, other| this - other),
                    reduction: this.paired(other, |this, other| 1.0 - this / other),
                }
            });
            if contender.name == CHAMPION
                && let Some(Difference { reduction, .. }) = &difference
            {
                let Summary { time, deviation } = *reduction;
                let (environment, slots) = (environment.name.clone(), contender.slots);
                claims.push(Claim { environment, slots, deviation, time });
            }
            let trials = &cells[place];
            entries.push(Entry {
                contender: contender.label(),
                arrived: arrived(trials),
                summary: driven[place].summary(),
                recognition: recognition(settings, contender, trials),
                coverage: coverage(trials, &resamples),
                difference,
            });
        }
        reports.push(EnvironmentReport { environment: environment.name.clone(), entries });
    }
    Report { trials: *trials, environments: reports, claims }
}

/// The place of [`BASELINE`] with as many slots as `contender`.
fn baseline(contenders: &[Contender], contender: &Contender) -> Option<usize> {
    contenders.iter().position(|it| it.name == BASELINE && it.slots == contender.slots)
}

/// Share of the trials that arrived, with Wilson's interval: it is one even where all or none did.
fn arrived(trials: &[Trial]) -> Estimate {
    const Z: f64 = 1.959_963_984_540_054;
    let n = trials.len() as f64;
    let share = trials.iter().filter(|trial| trial.arrived).count() as f64 / n;
    let wide = 1.0 + Z * Z / n;
    let centre = (share + Z * Z / (2.0 * n)) / wide;
    let half = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt() / wide;
    Estimate { mean: share, low: (centre - half).max(0.0), high: (centre + half).min(1.0) }
}

fn recognition(
    settings: &ComparisonSettings,
    contender: &Contender,
    trials: &[Trial],
) -> Option<Recognition> {
    if !contender.approach.identifies() || !settings.tells_apart() {
        return None;
    }
    let mut samples: Vec<_> = trials.iter().filter_map(|trial| trial.recognised).collect();
    samples.sort_unstable();
    let of_all = trials.len() as f64;
    let rank = |share: f64| samples.get((share * of_all).ceil() as usize - 1).copied();
    let share = samples.len() as f64 / of_all;
    Some(Recognition { share, median: rank(0.5), p90: rank(0.9) })
}

/// Samples of one trial depend on each other: whole trials are drawn again.
fn coverage(trials: &[Trial], resamples: &Resamples) -> Option<Estimate> {
    let coverages: Vec<Coverage> = trials.iter().filter_map(|trial| trial.coverage).collect();
    if coverages.len() < trials.len() || coverages.iter().all(|it| it.samples == 0) {
        return None;
    }
    let share = |counts: &[u16]| {
        let (within, samples) =
            coverages.iter().zip(counts).fold((0.0, 0.0), |sum, (it, count)| {
                let count = f64::from(*count);
                (sum.0 + count * f64::from(it.within), sum.1 + count * f64::from(it.samples))
            });
        within / f64::max(samples, 1.0)
    };
    Some(resamples.of(share).estimate(|share| share))
}
