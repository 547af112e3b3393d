//! What an evolution found, and what it is worth beside what was there before.

use crate::estimate::Estimate;
use crate::number;
use crate::robot;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A prior in one environment, on the seeds of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentResult)]
pub struct EnvironmentResult {
    /// The environment.
    pub environment: String,
    /// Fitness, 1 being that of a fixed model.
    pub fitness: Estimate,
    /// Mean time from the end of the calibration to the arrival; the limit where there was none.
    #[serde(serialize_with = "number::finite")]
    pub time_s: f64,
    /// Mean of the largest deviations.
    #[serde(serialize_with = "number::finite")]
    pub deviation_m: f64,
    /// Share of the trials in which the robot arrived, 0 to 1.
    #[serde(serialize_with = "number::finite")]
    pub arrived: f64,
}

/// One prior on the seeds of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EvolutionEntry)]
pub struct Entry {
    /// `champion`, `first-generation` (the best of it), `default` or `flat`; expect others.
    pub name: String,
    /// The prior.
    pub prior: robot::Prior,
    /// Its fitness: the weighted mean over the environments.
    pub fitness: Estimate,
    /// The champion's fitness minus this one's, paired by seed; null for the champion itself.
    pub difference: Option<Estimate>,
    /// Each environment alone.
    pub environments: Vec<EnvironmentResult>,
    /// What the difference says, in plain words; says so where the interval includes zero, and where the champion is
    /// worse in a single environment.
    pub verdict: String,
}

/// What an evolution found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Champion)]
pub struct Champion {
    /// The champion's prior.
    pub prior: robot::Prior,
    /// Fresh trials in each environment behind every number here.
    pub trials: u64,
    /// The champion first, then what it has to beat.
    pub entries: Vec<Entry>,
    /// What one should know before one uses it, in plain words: environments in which nobody arrives.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// What a difference says in plain words: the champion's fitness minus that of `name`.
fn verdict(name: &str, difference: Option<Estimate>) -> String {
    let Some(difference) = difference else { return "the champion itself".to_owned() };
    let Estimate { mean, low, high } = difference;
    if difference.includes_zero() {
        return format!(
            "the interval {low:.3} to {high:.3} includes zero: no difference to {name} is shown"
        );
    }
    let (better, by) = if mean > 0.0 { ("better", mean) } else { ("worse", -mean) };
    format!("the champion is {better} than {name} by {by:.3} ({low:.3} to {high:.3})")
}

impl Champion {
    /// What an evolution found, told in plain words: the champion is the first of `entries`.
    pub fn new(prior: robot::Prior, trials: u64, mut entries: Vec<Entry>) -> Self {
        add_prices(&mut entries);
        let notes = notes(&entries, trials);
        Self { prior, trials, entries, notes }
    }
}

impl Entry {
    /// One prior, with what `difference` says in plain words.
    pub fn new(
        name: String,
        prior: robot::Prior,
        fitness: Estimate,
        difference: Option<Estimate>,
        environments: Vec<EnvironmentResult>,
    ) -> Self {
        let verdict = verdict(&name, difference);
        Self { name, prior, fitness, difference, environments, verdict }
    }

    /// Environments in which this one is fitter than `champion`, whatever the mean over all of them says: those in which
    /// the two intervals are apart. Gives the champion's result and this one's.
    pub fn fitter_in<'a>(
        &'a self,
        champion: &'a Self,
    ) -> impl Iterator<Item = (&'a EnvironmentResult, &'a EnvironmentResult)> {
        let both = champion.environments.iter().zip(&self.environments);
        both.filter(|(of_champion, this)| of_champion.fitness.high < this.fitness.low)
    }
}

/// What is to be said of environments in which none of `entries` arrived in any of `trials` trials.
fn notes(entries: &[Entry], trials: u64) -> Vec<String> {
    let environments = entries.first().map_or(&[][..], |champion| &champion.environments);
    let nobody_arrives = |index: usize| {
        let results = entries.iter().filter_map(|entry| entry.environments.get(index));
        results.into_iter().all(|result| result.arrived <= 0.0)
    };
    let hopeless = environments.iter().enumerate().filter(|(index, _)| nobody_arrives(*index));
    hopeless
        .map(|(_, EnvironmentResult { environment, .. })| {
            format!(
                "in {environment} nobody arrives in any of {trials} trials, so it took no part in the choice; leave it \
                 out, or make it easier: a shorter round trip, fewer late packets and outages, less slip"
            )
        })
        .collect()
}

/// Adds to each verdict what the champion, the first entry, pays in single environments.
fn add_prices(entries: &mut [Entry]) {
    let Some((champion, others)) = entries.split_first_mut() else { return };
    for entry in others {
        let prices: String = entry
            .fitter_in(champion)
            .map(|(champion, this)| {
                let (name, paid, kept) =
                    (&champion.environment, champion.fitness.mean, this.fitness.mean);
                format!("; in {name} it is worse, {paid:.3} against {kept:.3}")
            })
            .collect();
        entry.verdict += &prices;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bug to fear: a mean that is better, and nobody is told that it is bought with one environment.
    #[test]
    fn a_verdict_names_the_environments_that_pay_for_it() {
        let estimate = |mean| Estimate { mean, low: mean - 0.1, high: mean + 0.1 };
        let entry = |name: &str, normal, bad| Entry {
            name: name.to_owned(),
            prior: robot::Prior::default(),
            fitness: estimate(normal + bad),
            difference: None,
            environments: [("normal", normal), ("bad-link", bad)]
                .map(|(environment, mean)| EnvironmentResult {
                    environment: environment.to_owned(),
                    fitness: estimate(mean),
                    time_s: 10.0,
                    deviation_m: 0.01,
                    arrived: 1.0,
                })
                .into(),
            verdict: "better".to_owned(),
        };
        let mut entries =
            [entry("champion", 0.3, 2.2), entry("default", 1.0, 0.9), entry("flat", 0.45, 0.9)];
        add_prices(&mut entries);
        let verdicts: Vec<_> = entries.iter().map(|entry| entry.verdict.as_str()).collect();
        let priced = "better; in normal it is worse, 0.300 against 1.000";
        assert_eq!(verdicts, ["better", priced, "better"], "0.3 and 0.45 are not apart");
    }

    #[test]
    fn environments_in_which_nobody_arrives_are_named() {
        let estimate = Estimate { mean: 0.0, low: 0.0, high: 0.0 };
        let entry = |arrived: [f64; 2]| Entry {
            name: "champion".to_owned(),
            prior: robot::Prior::default(),
            fitness: estimate,
            difference: None,
            environments: [("normal", arrived[0]), ("dead", arrived[1])]
                .map(|(environment, arrived)| EnvironmentResult {
                    environment: environment.to_owned(),
                    fitness: estimate,
                    time_s: 0.0,
                    deviation_m: 0.0,
                    arrived,
                })
                .into(),
            verdict: String::new(),
        };
        let of = |entries: &[Entry]| notes(entries, 7);
        assert_eq!(of(&[entry([1.0, 0.0]), entry([0.0, 0.1])]), Vec::<String>::new());
        let told = of(&[entry([1.0, 0.0]), entry([0.0, 0.0])]);
        assert_eq!(told.len(), 1);
        assert!(told[0].starts_with("in dead nobody arrives in any of 7 trials"), "{told:?}");
    }

    #[test]
    fn a_verdict_says_where_the_interval_includes_zero() {
        let say = |mean, low, high| verdict("flat", Some(Estimate { mean, low, high }));
        for (low, high) in [(-0.1, 0.3), (0.0, 0.2), (-0.2, 0.0)] {
            let words = say((low + high) / 2.0, low, high);
            assert!(words.contains("includes zero") && words.contains("no difference"), "{words}");
        }
        assert_eq!(
            say(0.2, 0.1, 0.3),
            "the champion is better than flat by 0.200 (0.100 to 0.300)"
        );
        assert_eq!(
            say(-0.2, -0.3, -0.1),
            "the champion is worse than flat by 0.200 (-0.300 to -0.100)"
        );
        assert_eq!(verdict("champion", None), "the champion itself");
    }
}
