//! Where the robot stood between its motions, and how long after its command each motion is seen.
//!
//! Nothing is presumed of frame, units or wheels: a rest is where the poses stay the same.

use super::trace::{Motion, Sample, Trace};
use super::wiggle::MOTIONS;

/// Delays in s that are tried: from stamps of another clock to a slow camera behind a slow motor.
const DELAYS: (f64, f64) = (-1.2, 1.6);

/// Step in s between them.
const STEP: f64 = 0.04;

/// Longest part in s of the last rest that counts.
const LAST: f64 = 0.8;

/// Longest part in s of the first rest that counts.
const FIRST: f64 = 1.0;

/// Part of the largest change of a coordinate that counts as its noise where the poses have less.
const LEAST_NOISE: f64 = 0.004;

/// A change that is seen is at least so many standard deviations of a difference of two rests.
const SEEN: f64 = 8.0;

/// What one motion changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Whether it is a turn in place; else a drive.
    pub is_turn: bool,
    /// What was commanded, in rad or m.
    pub commanded: f64,
    /// Change of x and y in m and of the heading in rad, as the poses have them.
    pub moved: [f64; 3],
    /// Mean heading in rad of the rests before and after it, unwrapped, less that of the first pose.
    pub heading: f64,
}

/// The rests of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// What each motion changed.
    pub changes: [Change; MOTIONS],
    /// Time in s from command to motion; none where no motion is seen.
    pub delay: Option<f64>,
}

/// Times in s between which the commands rest.
type Rests = [(f64, f64); MOTIONS + 1];

impl Levels {
    /// The rests of `trace`; none where they cannot be told: too few poses.
    pub fn of(trace: &Trace) -> Option<Self> {
        let motions: &[Motion; MOTIONS] = trace.motions().try_into().ok()?;
        let samples = trace.samples();
        let noise = noise(trace);
        let rests = rests(motions, samples.last()?.time.into());
        let count = ((DELAYS.1 - DELAYS.0) / STEP) as u32;
        let delays = (0..=count).map(|step| DELAYS.0 + STEP * f64::from(step));
        let scattered =
            delays.filter_map(|delay| Some((delay, scatter(samples, &rests, delay, noise)?)));
        let (delay, _) = scattered.min_by(|(_, one), (_, other)| one.total_cmp(other))?;
        let mut means = [[0.0; 3]; MOTIONS + 1];
        let mut fewest = usize::MAX;
        for (mean, rest) in means.iter_mut().zip(rests) {
            let (sum, count) = mean_of(samples, rest, delay)?;
            *mean = sum;
            fewest = fewest.min(count);
        }
        let mut changes = [Change::default(); MOTIONS];
        let mut centres = arrayvec::ArrayVec::<f64, MOTIONS>::new();
        let sure = SEEN * (2.0 / fewest as f64).sqrt();
        for (i, motion) in motions.iter().enumerate() {
            let (before, after) = (means[i], means[i + 1]);
            let moved = [0, 1, 2].map(|k| after[k] - before[k]);
            let heading = f64::midpoint(before[2], after[2]);
            changes[i] =
                Change { is_turn: motion.is_turn, commanded: motion.commanded, moved, heading };
            let size = (0..3).map(|k| (moved[k] / noise[k]).powi(2)).sum::<f64>().sqrt();
            if size > sure {
                let middle = |(from, until): (f64, f64)| f64::midpoint(from, until) + delay;
                let window = (middle(rests[i]), middle(rests[i + 1]));
                centres.push(centre(samples, window, before, moved, noise) - motion.centre());
            }
        }
        centres.sort_unstable_by(f64::total_cmp);
        let middle = centres.len() / 2;
        let delay = centres.get(middle).map(|upper| {
            let lower = if centres.len() % 2 == 0 { centres[middle - 1] } else { *upper };
            f64::midpoint(lower, *upper)
        });
        Some(Self { changes, delay })
    }
}

/// Standard deviations of a sample to reckon with.
fn noise(trace: &Trace) -> [f64; 3] {
    let rest = trace.noise().unwrap_or_default();
    let mut range = [(f32::INFINITY, f32::NEG_INFINITY); 3];
    for sample in trace.samples() {
        for (range, at) in range.iter_mut().zip(sample.at) {
            *range = (range.0.min(at), range.1.max(at));
        }
    }
    let [x, y, heading] = range.map(|(low, high)| f64::from((high - low).max(f32::MIN_POSITIVE)));
    let position = rest.position.max(LEAST_NOISE * x.max(y));
    [position, position, rest.heading.max(LEAST_NOISE * heading)]
}

fn rests(motions: &[Motion; MOTIONS], end: f64) -> Rests {
    let mut rests = [(0.0, 0.0); MOTIONS + 1];
    rests[0] = (motions[0].from - FIRST, motions[0].from);
    for i in 1..MOTIONS {
        rests[i] = (motions[i - 1].until, motions[i].from);
    }
    let last = motions[MOTIONS - 1].until;
    rests[MOTIONS] = (last, end.min(last + LAST));
    rests
}

fn within(samples: &[Sample], rest: (f64, f64), delay: f64) -> &[Sample] {
    let (from, until) = ((rest.0 + delay) as f32, (rest.1 + delay) as f32);
    let first = samples.partition_point(|sample| sample.time < from);
    let end = samples.partition_point(|sample| sample.time <= until);
    &samples[first.min(end)..end]
}

fn mean_of(samples: &[Sample], rest: (f64, f64), delay: f64) -> Option<([f64; 3], usize)> {
    let samples = within(samples, rest, delay);
    if samples.is_empty() {
        return None;
    }
    let count = samples.len() as f64;
    let sum = |i: usize| samples.iter().map(|sample| f64::from(sample.at[i])).sum::<f64>();
    Some(([0, 1, 2].map(|i| sum(i) / count), samples.len()))
}

/// How much the poses move within the rests where they are seen `delay` s after their commands, per degree of freedom; none
/// where a rest has no poses.
fn scatter(samples: &[Sample], rests: &Rests, delay: f64, noise: [f64; 3]) -> Option<f64> {
    let (mut sum, mut free) = (0.0, 0);
    for rest in rests {
        let (mean, count) = mean_of(samples, *rest, delay)?;
        for sample in within(samples, *rest, delay) {
            let off = |i: usize| (f64::from(sample.at[i]) - mean[i]) / noise[i];
            sum += [0, 1, 2].map(|i| off(i) * off(i)).iter().sum::<f64>();
        }
        free += count - 1;
    }
    (free >= rests.len()).then(|| sum / free as f64)
}

/// The centre in time of the motion by `moved` from `before`: where what is still to come equals what has come. The area
/// above its progress is its distance from the beginning of the window, whatever its speed was.
fn centre(
    samples: &[Sample],
    (from, until): (f64, f64),
    before: [f64; 3],
    moved: [f64; 3],
    noise: [f64; 3],
) -> f64 {
    let along = [0, 1, 2].map(|i| moved[i] / (noise[i] * noise[i]));
    let size: f64 = (0..3).map(|i| along[i] * moved[i]).sum();
    let progress = |sample: &Sample| {
        (0..3).map(|i| along[i] * (f64::from(sample.at[i]) - before[i])).sum::<f64>() / size
    };
    let (mut time, mut left, mut area) = (from, 1.0, 0.0);
    for sample in within(samples, (from, until), 0.0) {
        let (then, now) = (f64::from(sample.time), 1.0 - progress(sample));
        area += (then - time) * f64::midpoint(left, now);
        (time, left) = (then, now);
    }
    from + area + (until - time) * left / 2.0
}
