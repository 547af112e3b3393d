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

/// A linear axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// What it shows, with its unit.
    pub(super) name: &'static str,
    from: f64,
    to: f64,
    ticks: Vec<f64>,
    decimals: usize,
}

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

    fn with_step(name: &'static str, range: Range<f64>, step: f64) -> Self {
        let Range { start: from, end: to } = range;
        // A tick that rounding puts just outside is meant to be on the edge.
        let (first, last) = ((from / step - 1e-6).ceil() as i64, (to / step + 1e-6).floor() as i64);
        let ticks = (first..=last).map(|index| index as f64 * step).collect();
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        Self { name, from, to, ticks, decimals }
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
        let share = (value - self.from) / (self.to - self.from);
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
        if self.to.abs().max(self.from.abs()) >= 1e5 || self.decimals > 4 {
            return if *value == 0.0 { "0".into() } else { short_exponent(*value) };
        }
        // A true minus sign, as wide as a plus.
        format!("{value:.*}", self.decimals).replace('-', "\u{2212}")
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
