//! What an evolution found, in plain words.

use umwelt_api::evolution::{Champion, Entry, EnvironmentResult, Estimate, Ranking};
use umwelt_api::robot;

/// What a difference says in plain words: the champion's fitness minus that of `name`.
fn verdict(name: &str, difference: Option<Estimate>) -> (Option<Ranking>, String) {
    let Some(difference) = difference else { return (None, "the champion itself".to_owned()) };
    let Estimate { mean, low, high } = difference;
    let (ranking, better, by) = match mean {
        _ if difference.includes_zero() => {
            let words = format!(
                "the interval {low:.3} to {high:.3} includes zero: no difference to {name} is shown"
            );
            return (Some(Ranking::NoDifference), words);
        }
        mean if mean > 0.0 => (Ranking::Better, "better", mean),
        mean => (Ranking::Worse, "worse", -mean),
    };
    let words = format!("the champion is {better} than {name} by {by:.3} ({low:.3} to {high:.3})");
    (Some(ranking), words)
}

/// What an evolution found, with its words: the champion is the first of `entries`.
pub(in crate::wire) fn champion(
    prior: robot::Prior,
    trials: u64,
    mut entries: Vec<Entry>,
) -> Champion {
    add_prices(&mut entries);
    let notes = notes(&entries, trials);
    Champion { prior, trials, entries, notes }
}

/// One prior, with what `difference` says in plain words.
pub(in crate::wire) fn entry(
    name: String,
    prior: robot::Prior,
    fitness: Estimate,
    difference: Option<Estimate>,
    environments: Vec<EnvironmentResult>,
) -> Entry {
    let (champion_is, verdict) = verdict(&name, difference);
    let champion_worse_in = Vec::new();
    Entry {
        name,
        prior,
        fitness,
        difference,
        environments,
        verdict,
        champion_is,
        champion_worse_in,
    }
}

/// Environments in which `this` is fitter than `champion`: those in which the two intervals are apart. Gives the
/// champion's result and that of `this`.
fn fitter_in<'a>(
    this: &'a Entry,
    champion: &'a Entry,
) -> impl Iterator<Item = (&'a EnvironmentResult, &'a EnvironmentResult)> {
    let both = champion.environments.iter().zip(&this.environments);
    both.filter(|(of_champion, this)| of_champion.fitness.high < this.fitness.low)
}

/// What is to be said of environments in which none of `entries` arrived in any of `trials` trials.
fn notes(entries: &[Entry], trials: u64) -> Vec<String> {
    let environments = entries.first().map_or(&[][..], |champion| &champion.environments);
    let none_arrives = |index: usize| {
        let results = entries.iter().filter_map(|entry| entry.environments.get(index));
        results.into_iter().all(|result| result.arrived <= 0.0)
    };
    let unreached = environments.iter().enumerate().filter(|(index, _)| none_arrives(*index));
    unreached
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
        let (mut prices, mut worse_in) = (String::new(), Vec::new());
        for (champion, this) in fitter_in(entry, champion) {
            let (name, paid, kept) =
                (&champion.environment, champion.fitness.mean, this.fitness.mean);
            prices += &format!("; in {name} it is worse, {paid:.3} against {kept:.3}");
            worse_in.push(name.clone());
        }
        entry.verdict += &prices;
        entry.champion_worse_in = worse_in;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards against a better mean that is bought with one environment, unsaid.
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
            champion_is: None,
            champion_worse_in: Vec::new(),
        };
        let mut entries =
            [entry("champion", 0.3, 2.2), entry("default", 1.0, 0.9), entry("flat", 0.45, 0.9)];
        add_prices(&mut entries);
        let verdicts: Vec<_> = entries.iter().map(|entry| entry.verdict.as_str()).collect();
        let priced = "better; in normal it is worse, 0.300 against 1.000";
        assert_eq!(verdicts, ["better", priced, "better"], "0.3 and 0.45 are not apart");
        let worse_in = entries.map(|entry| entry.champion_worse_in);
        assert_eq!(worse_in, [vec![], vec!["normal".to_owned()], vec![]]);
    }

    #[test]
    fn environments_in_which_no_robot_arrives_are_named() {
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
            champion_is: None,
            champion_worse_in: Vec::new(),
        };
        let of = |entries: &[Entry]| super::notes(entries, 7);
        assert_eq!(of(&[entry([1.0, 0.0]), entry([0.0, 0.1])]), Vec::<String>::new());
        let notes = of(&[entry([1.0, 0.0]), entry([0.0, 0.0])]);
        assert_eq!(notes.len(), 1);
        assert!(notes[0].starts_with("in dead nobody arrives in any of 7 trials"), "{notes:?}");
    }

    #[test]
    fn a_verdict_says_where_the_interval_includes_zero() {
        let say = |mean, low, high| verdict("flat", Some(Estimate { mean, low, high })).1;
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
        assert_eq!(verdict("champion", None), (None, "the champion itself".to_owned()));
    }
}
