//! An axis: its range, round ticks, and its name with the unit.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// Values of no greater magnitude are drawn; nothing real comes near it.
const LARGEST: f64 = 1e15;
/// A smaller range is none.
const SMALLEST: f64 = 1e-12;

/// Whether a value can be drawn: neither infinite nor not a number nor beyond everything.
pub(super) fn is_drawable(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// What it shows, with its unit.
    pub(super) name: &'static str,
    from: f64,
    to: f64,
    ticks: Vec<f64>,
    scale: Scale,
}

/// How values lie along an axis, and how its ticks are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    /// Evenly; with so many decimals.
    Linear(usize),
    /// By their logarithms; as short as they can be.
    Logarithmic,
}

/// Where a decade has ticks: more of them the fewer decades there are.
const IN_DECADE: [&[f64]; 3] = [&[1.0, 2.0, 3.0, 5.0, 7.0], &[1.0, 2.0, 5.0], &[1.0]];

impl Axis {
    /// From 0, or from the smallest value if one is negative, to a round number no smaller than the largest; `ticks`
    /// is how many intervals there are at most. What is not drawable counts for nothing.
    pub(super) fn from_zero(
        name: &'static str,
        values: impl Iterator<Item = f64>,
        ticks: usize,
    ) -> Self {
        let (low, high) = values
            .filter(|value| is_drawable(*value))
            .fold((0.0_f64, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let high = if high - low < SMALLEST { low + 1.0 } else { high };
        let step = round_step((high - low) / ticks as f64);
        // What rounding puts just beyond a tick needs no further one.
        let (from, to) = ((low / step + 1e-6).floor(), (high / step - 1e-6).ceil());
        let (from, to) = (from * step, to * step);
        Self::with_step(name, from..to, step)
    }

    /// Counts from 0 to `last`, with a little room on both sides.
    pub(super) fn counting(name: &'static str, last: usize, ticks: usize) -> Self {
        let last = (last as f64).min(LARGEST);
        let room = if last > 0.0 { 0.025 * last } else { 0.5 };
        let step = round_step(last / ticks as f64).max(1.0);
        Self::with_step(name, -room..last + room, step)
    }

    /// By logarithms, from a tick at or below the smallest value to one at or above the largest, with at most `ticks`
    /// ticks. What is not positive and drawable counts for nothing.
    pub(super) fn logarithmic(
        name: &'static str,
        values: impl Iterator<Item = f64>,
        ticks: usize,
    ) -> Self {
        let (low, high) = values
            .filter(|value| is_drawable(*value) && *value > SMALLEST)
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (0.1, 1.0) };
        let decades = (low.log10().floor() as i32 - 1)..=(high.log10().ceil() as i32 + 1);
        let ticks_of = |digits: &[f64]| {
            let all = decades.clone().flat_map(|decade| {
                let power = 10_f64.powi(decade);
                digits.iter().map(move |digit| digit * power).collect::<Vec<_>>()
            });
            let all: Vec<f64> = all.collect();
            // What rounding puts just beyond a tick needs no further one.
            let first = all.iter().rposition(|tick| *tick <= low * (1.0 + 1e-9)).unwrap_or(0);
            let last = all.iter().position(|tick| *tick >= high * (1.0 - 1e-9));
            let last = last.unwrap_or(all.len() - 1).max(first + 1);
            all[first..=last].to_vec()
        };
        let mut candidates = IN_DECADE.into_iter().map(ticks_of);
        let fitting = candidates.find(|found| found.len() <= ticks + 1);
        let ticks = fitting.unwrap_or_else(|| {
            let decades = ticks_of(&[1.0]);
            let every = decades.len().div_ceil(ticks.max(1));
            let last = decades[decades.len() - 1];
            let mut some: Vec<f64> = decades.into_iter().step_by(every).collect();
            some.extend((some[some.len() - 1] < last).then_some(last));
            some
        });
        let (from, to) = (ticks[0], ticks[ticks.len() - 1]);
        Self { name, from, to, ticks, scale: Scale::Logarithmic }
    }

    fn with_step(name: &'static str, range: Range<f64>, step: f64) -> Self {
        let Range { start: from, end: to } = range;
        // A tick that rounding puts just outside is meant to be on the edge.
        let (first, last) = ((from / step - 1e-6).ceil() as i64, (to / step + 1e-6).floor() as i64);
        let ticks = (first..=last).map(|index| index as f64 * step).collect();
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        Self { name, from, to, ticks, scale: Scale::Linear(decimals) }
    }

    /// What stands at the ticks.
    pub(super) fn labels(&self) -> impl Iterator<Item = String> {
        self.ticks.iter().map(|tick| self.format_ext(tick))
    }

    /// The smallest value that it shows.
    pub(super) fn bottom(&self) -> f64 {
        self.from
    }

    /// The largest.
    pub(super) fn top(&self) -> f64 {
        self.to
    }
}

/// 1, 2 or 5 times a power of ten: the smallest that is no less than `least`.
fn round_step(least: f64) -> f64 {
    let least = least.max(SMALLEST);
    let power = 10_f64.powf(least.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    factors
        .map(|factor| factor * power)
        .into_iter()
        .find(|step| *step >= least * 0.999_999)
        .unwrap_or(10.0 * power)
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let share = match self.scale {
            Scale::Linear(_) => (value - self.from) / (self.to - self.from),
            Scale::Logarithmic => (value / self.from).ln() / (self.to / self.from).ln(),
        };
        start + (share * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let decimals = match self.scale {
            Scale::Linear(decimals) => decimals,
            Scale::Logarithmic => (-value.log10().floor()).max(0.0) as usize,
        };
        if self.to.abs().max(self.from.abs()) >= 1e5 || decimals > 4 {
            return if *value == 0.0 { "0".into() } else { short_exponent(*value) };
        }
        // A true minus sign, as wide as a plus.
        format!("{value:.decimals$}").replace('-', "\u{2212}")
    }
}

/// `2e6`, `1.5e-7`: what is left of rounding noise is cut.
fn short_exponent(value: f64) -> String {
    let text = format!("{value:.2e}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
        .replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.labels().collect()
    }

    #[test]
    fn ticks_are_round_and_the_top_one_is_at_or_above_the_largest_value() {
        let labels_to = |high| labels(&Axis::from_zero("", [high].into_iter(), 5));
        assert_eq!(labels_to(34.2), ["0", "10", "20", "30", "40"]);
        assert_eq!(labels_to(2.1), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5"]);
        assert_eq!(labels_to(0.6), ["0.0", "0.2", "0.4", "0.6"]);
        assert_eq!(labels_to(0.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels_to(-3.0), ["\u{2212}3", "\u{2212}2", "\u{2212}1", "0"]);
        assert_eq!(labels_to(3.9e8), ["0", "1e8", "2e8", "3e8", "4e8"]);
        for exponent in -11..15 {
            for digits in 1..100 {
                let high = f64::from(digits) * 0.1 * 10_f64.powi(exponent);
                let axis = Axis::from_zero("", [high].into_iter(), 5);
                assert!(axis.top() >= high * 0.999_999, "{high}: {axis:?}");
                assert!((2..=6).contains(&axis.ticks.len()), "{high}: {axis:?}");
                let mut labels = labels(&axis);
                assert!(labels.iter().all(|label| label.chars().count() <= 7), "{labels:?}");
                labels.dedup();
                assert_eq!(labels.len(), axis.ticks.len(), "{labels:?}");
            }
        }
    }

    #[test]
    fn generations_are_counted_in_whole_numbers() {
        let labels_to = |last| labels(&Axis::counting("", last, 5));
        assert_eq!(labels_to(0), ["0"]);
        assert_eq!(labels_to(1), ["0", "1"]);
        assert_eq!(labels_to(11), ["0", "5", "10"]);
        assert_eq!(labels_to(99), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(labels_to(999), ["0", "200", "400", "600", "800", "1000"]);
        assert!(labels(&Axis::counting("", usize::MAX, 5)).len() < 8);
    }

    #[test]
    fn ticks_of_a_logarithm_enclose_the_values_and_are_few() {
        let labels_of = |low: f64, high| labels(&Axis::logarithmic("", [low, high].into_iter(), 7));
        assert_eq!(labels_of(0.001, 1.0), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels_of(10.8, 46.0), ["10", "20", "30", "50"]);
        assert_eq!(labels_of(0.8, 58.0), ["0.5", "1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(labels_of(0.8, 580.0), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels_of(5.0, 5.0), ["5", "7"]);
        for low in -20..20 {
            for span in 0..40 {
                let low = 10_f64.powf(f64::from(low) / 3.0);
                let high = low * 10_f64.powf(f64::from(span) / 7.0);
                let axis = Axis::logarithmic("", [low, high].into_iter(), 7);
                assert!(axis.from <= low * 1.000_001 && axis.to >= high * 0.999_999, "{axis:?}");
                assert!((2..=9).contains(&axis.ticks.len()), "{low} {high} {axis:?}");
            }
        }
        let nothing = Axis::logarithmic("", [0.0, -1.0, f64::NAN].into_iter(), 6);
        assert_eq!((nothing.from, nothing.to), (0.1, 1.0));
        let axis = Axis::logarithmic("", [1.0, 100.0].into_iter(), 3);
        assert_eq!([1.0, 10.0, 100.0].map(|value| axis.map(&value, (0, 800))), [0, 400, 800]);
    }

    #[test]
    fn what_is_not_finite_counts_for_nothing() {
        let values = [f64::NAN, 3.0, f64::INFINITY, -f64::INFINITY, f64::MAX];
        assert_eq!(Axis::from_zero("", values.into_iter(), 5).range(), 0.0..3.0);
        assert_eq!(Axis::from_zero("", [f64::NAN].into_iter(), 5).range(), 0.0..1.0);
    }

    #[test]
    fn more_is_farther_along() {
        let axis = Axis::from_zero("", [0.0, 8.0].into_iter(), 5);
        assert_eq!([0.0, 2.0, 8.0].map(|value| axis.map(&value, (100, 900))), [100, 300, 900]);
        assert_eq!([0.0, 2.0, 8.0].map(|value| axis.map(&value, (900, 100))), [900, 700, 100]);
    }
}
