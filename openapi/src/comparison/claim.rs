//! What the thesis's claims come to, in numbers and in plain words.

use super::Reductions;
use crate::estimate::Estimate;
use crate::number;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What the thesis claims of `bayesian` against `statistic`, and what it comes to in one environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Claim)]
pub struct Claim {
    /// The environment.
    pub environment: String,
    /// Slots per horizon of both.
    pub slots: u64,
    /// For whom it is claimed, as `bayesian/20`.
    pub contender: String,
    /// Against whom, as `statistic/20`.
    pub against: String,
    /// How much smaller the deviation is.
    pub deviation_reduction: Reductions,
    /// How much shorter the time is.
    pub time_reduction: Reductions,
    /// How much smaller the thesis says that the deviation is, as a part.
    #[serde(serialize_with = "number::finite")]
    pub promised_deviation: f64,
    /// How much shorter the thesis says that the time is, as a part.
    #[serde(serialize_with = "number::finite")]
    pub promised_time: f64,
    /// Share of the trials in which `contender` arrived within the time limit, 0 to 1.
    #[serde(serialize_with = "number::finite")]
    pub arrived: f64,
    /// Share of the trials in which `against` did.
    #[serde(serialize_with = "number::finite")]
    pub against_arrived: f64,
    /// What the means say, in plain words: how much less or more, with the interval, and which share of the thesis's
    /// number is reached; says so where the interval includes zero, and where robots did not arrive.
    pub verdict: String,
}

impl Claim {
    /// What the means say, in plain words: what `verdict` holds.
    pub fn in_words(&self) -> String {
        let deviation = Promise { of: "deviation", less: "smaller", more: "larger" };
        let time = Promise { of: "time", less: "shorter", more: "longer" };
        if let Some(nobody) = self.without_arrival() {
            return nobody;
        }
        format!(
            "{}; {}{}",
            deviation.kept(self.deviation_reduction.mean, self.promised_deviation),
            time.kept(self.time_reduction.mean, self.promised_time),
            self.arrivals()
        )
    }

    /// The verdict where one of the two never arrived: its time is the limit, and its deviation that of standing still.
    fn without_arrival(&self) -> Option<String> {
        let both = [(&self.contender, self.arrived), (&self.against, self.against_arrived)];
        let never: Vec<_> = both
            .iter()
            .filter(|(_, arrived)| *arrived <= 0.0)
            .map(|(name, _)| name.as_str())
            .collect();
        (!never.is_empty()).then(|| {
            format!(
                "{} arrived in no trial, so neither deviation nor time says anything; use an environment that can be \
                 driven",
                never.join(" and ")
            )
        })
    }

    /// Who did not always arrive: such a trial takes the time limit, and who does not get far does not stray far.
    fn arrivals(&self) -> String {
        let Self { contender, against, arrived, against_arrived, .. } = self;
        if *arrived >= 1.0 && *against_arrived >= 1.0 {
            return String::new();
        }
        let share = |arrived: f64| match percent(arrived, 1) {
            // One in ten thousand is not none.
            all if all == "100.0" && arrived < 1.0 => "more than 99.9".to_owned(),
            share => share,
        };
        format!(
            "; not all arrived: {contender} in {} % of the trials, {against} in {} %, the others count with the time \
             limit and as far as they got",
            share(*arrived),
            share(*against_arrived)
        )
    }
}

/// The words for one of the two quantities.
struct Promise {
    of: &'static str,
    less: &'static str,
    more: &'static str,
}

impl Promise {
    /// How far `reduction` keeps what was `promised`.
    fn kept(&self, reduction: Option<Estimate>, promised: f64) -> String {
        let Self { of, less, more } = self;
        let promised_percent = percent(promised, 0);
        let Some(estimate) = reduction else {
            return format!("{of} cannot be said as a part of the other's, which is zero");
        };
        let Estimate { mean, low, high } = estimate;
        let size = |value: f64| {
            // Above 100 % a decimal says nothing any more.
            let rounded = percent(value, 1);
            if rounded.len() < "100.0".len() { rounded } else { percent(value, 0) }
        };
        let direction = |value: f64| if value < 0.0 { more } else { less };
        let (by, way) = (size(mean), direction(mean));
        if estimate.includes_zero() {
            let ends = [low, high].map(|end| format!("{} % {}", size(end), direction(end)));
            return format!(
                "{of} {by} % {way} (95 %: {}): the interval includes zero, no difference is shown, none of the \
                 thesis's {promised_percent} % {less}",
                ends.join(" to ")
            );
        }
        if mean < 0.0 {
            // Much longer: the end of the interval that is nearer to zero comes first here too.
            let (low, high) = (size(high), size(low));
            return format!(
                "{of} {by} % {more} (95 %: {low} to {high}): the opposite of the thesis's {promised_percent} % \
                 {less}, none of it is reached"
            );
        }
        let share = match percent(mean / promised, 0) {
            none if none == "0" => "less than 1".to_owned(),
            share => share,
        };
        format!(
            "{of} {by} % {less} (95 %: {} to {}): {share} % of the thesis's {promised_percent} %",
            size(low),
            size(high)
        )
    }
}

/// The size of a part in percent, without its sign.
fn percent(part: f64, decimals: usize) -> String {
    format!("{:.decimals$}", 1e2 * part.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    type Interval = (f64, f64, f64);

    fn words(deviation: Option<Interval>, time: Option<Interval>) -> String {
        claim(deviation, time).in_words()
    }

    fn claim(deviation: Option<Interval>, time: Option<Interval>) -> Claim {
        let reductions = |mean: Option<Interval>| Reductions {
            mean: mean.map(|(mean, low, high)| Estimate { mean, low, high }),
            // Neither says anything in the verdict.
            median: Some(Estimate { mean: 0.9, low: 0.8, high: 1.0 }),
            p90: None,
        };
        Claim {
            environment: "bad-link".to_owned(),
            slots: 20,
            contender: "bayesian/20".to_owned(),
            against: "statistic/20".to_owned(),
            deviation_reduction: reductions(deviation),
            time_reduction: reductions(time),
            promised_deviation: 0.75,
            promised_time: 0.35,
            arrived: 1.0,
            against_arrived: 1.0,
            verdict: String::new(),
        }
    }

    #[test]
    fn a_share_of_the_promise_is_told_and_so_is_its_opposite() {
        assert_eq!(
            words(Some((0.123, 0.081, 0.16)), Some((-1.04, -1.08, -1.0))),
            "deviation 12.3 % smaller (95 %: 8.1 to 16.0): 16 % of the thesis's 75 %; \
             time 104 % longer (95 %: 100 to 108): the opposite of the thesis's 35 % shorter, none of it is reached"
        );
        assert_eq!(
            words(Some((-0.2, -0.31, -0.1)), Some((0.42, 0.4, 0.44))),
            "deviation 20.0 % larger (95 %: 10.0 to 31.0): the opposite of the thesis's 75 % smaller, none of it is \
             reached; time 42.0 % shorter (95 %: 40.0 to 44.0): 120 % of the thesis's 35 %"
        );
    }

    /// The bug to fear: noise that is told as an improvement.
    #[test]
    fn an_interval_with_zero_shows_no_difference() {
        assert_eq!(
            words(Some((0.012, -0.03, 0.051)), Some((-0.01, -0.02, 0.0))),
            "deviation 1.2 % smaller (95 %: 3.0 % larger to 5.1 % smaller): the interval includes zero, no \
             difference is shown, none of the thesis's 75 % smaller; \
             time 1.0 % longer (95 %: 2.0 % longer to 0.0 % shorter): the interval includes zero, no difference is \
             shown, none of the thesis's 35 % shorter"
        );
        for interval in [(0.1, 0.0, 0.2), (-0.1, -0.2, 0.0), (0.0, 0.0, 0.0)] {
            let words = words(Some(interval), Some(interval));
            assert_eq!(words.matches("no difference is shown").count(), 2, "{words}");
            assert!(!words.contains("of the thesis's 75 %;"), "{words}");
        }
    }

    #[test]
    fn what_is_next_to_nothing_and_what_does_not_exist_is_told() {
        let little = words(Some((0.002, 0.001, 0.003)), None);
        assert!(little.contains("): less than 1 % of the thesis's 75 %;"), "{little}");
        assert!(little.ends_with("time cannot be said as a part of the other's, which is zero"));
    }

    #[test]
    fn decimals_end_at_a_hundred() {
        let at = |mean| words(Some((mean, mean - 1e-3, mean + 1e-3)), None);
        assert!(at(-0.999_4).starts_with("deviation 99.9 % larger (95 %: 99.8 to 100)"));
        assert!(at(-0.999_6).starts_with("deviation 100 % larger"));
        assert!(at(-12.5).starts_with("deviation 1250 % larger"));
    }

    /// The bug to fear: a robot that stands still is praised for how little it deviates.
    #[test]
    fn who_did_not_arrive_is_told() {
        let less = Some((0.75, 0.7, 0.8));
        let of = |arrived, against_arrived| {
            let claim = Claim { arrived, against_arrived, ..claim(less, less) };
            claim.in_words()
        };
        assert!(!of(1.0, 1.0).contains("arrived"));
        let told = "; not all arrived: bayesian/20 in 12.5 % of the trials, statistic/20 in 100.0 %, the others count \
                    with the time limit and as far as they got";
        assert!(of(0.125, 1.0).ends_with(told), "{}", of(0.125, 1.0));
        assert!(of(1.0, 0.9999).contains("statistic/20 in more than 99.9 %"));
        let nothing =
            "statistic/20 arrived in no trial, so neither deviation nor time says anything";
        assert!(of(1.0, 0.0).starts_with(nothing), "{}", of(1.0, 0.0));
        assert!(of(0.0, 0.0).starts_with("bayesian/20 and statistic/20 arrived in no trial"));
    }
}
