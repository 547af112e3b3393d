//! What is said of the champion: on seeds that neither bred nor chose it, beside what it has to beat.

use super::environment::TrainingEnvironment;
use serde::{Deserialize, Serialize};
use umwelt_core::conjugate::student_t_half_width;
use umwelt_core::settings::Prior;

/// Probability mass of every interval of a report.
pub const LEVEL: f64 = 0.95;

/// A mean with its confidence interval, by Student's t over independent trials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Estimate {
    /// The mean of `values`, of which there are at least two.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        // Values that are all the same have no width, whatever t is.
        let half = if variance > 0.0 {
            student_t_half_width(n - 1.0, LEVEL) * (variance / n).sqrt()
        } else {
            0.0
        };
        Self { mean, low: mean - half, high: mean + half }
    }

    /// Whether the interval says nothing about the sign.
    pub fn includes_zero(&self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }
}

/// How a prior drove in one environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentResult {
    /// The environment.
    pub name: String,
    /// Fitness, 1 where it is that of fixed-normal.
    pub fitness: Estimate,
    /// Mean time in s from the end of the calibration to the arrival; the time limit where there was none.
    pub time: f64,
    /// Mean largest deviation in m.
    pub deviation: f64,
    /// Share of the trials in which the robot arrived.
    pub arrived: f64,
}

/// One prior on the report's seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// `champion`, `first-generation` (the best of it), `default` or `flat`.
    pub name: String,
    /// The prior.
    pub prior: Prior,
    /// Its fitness: the weighted mean over the environments.
    pub fitness: Estimate,
    /// Champion minus this one, paired by seed; none for the champion itself.
    pub difference: Option<Estimate>,
    /// Each environment alone.
    pub environments: Vec<EnvironmentResult>,
}

/// The result of an evolution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The champion's prior.
    pub champion: Prior,
    /// Fresh trials in each environment behind every number here.
    pub trials: usize,
    /// The champion first, then what it has to beat.
    pub entries: Vec<Entry>,
}

/// Fitness, time, deviation and arrival of each trial in one environment.
pub(super) type Trials = Vec<(f64, f64, f64, bool)>;

/// One prior's trials, environment by environment.
pub(super) struct Driven {
    pub(super) name: &'static str,
    pub(super) prior: Prior,
    pub(super) environments: Vec<Trials>,
}

/// The report of what was driven, the champion first.
pub(super) fn report(environments: &[TrainingEnvironment], driven: Vec<Driven>) -> Report {
    let total: f64 = environments.iter().map(|environment| environment.weight).sum();
    let trials = driven[0].environments[0].len();
    let means: Vec<Vec<f64>> = driven
        .iter()
        .map(|driven| {
            let mean = |trial: usize| {
                let weighted = driven.environments.iter().zip(environments);
                weighted.map(|(trials, it)| it.weight * trials[trial].0).sum::<f64>() / total
            };
            (0..trials).map(mean).collect()
        })
        .collect();
    let champion = driven[0].prior;
    let entry = |(index, driven): (usize, Driven)| {
        let paired = means[0].iter().zip(&means[index]).map(|(champion, other)| champion - other);
        let difference = (index > 0).then(|| Estimate::of(&paired.collect::<Vec<f64>>()));
        let results = environments.iter().zip(&driven.environments);
        Entry {
            name: driven.name.to_owned(),
            prior: driven.prior,
            fitness: Estimate::of(&means[index]),
            difference,
            environments: results.map(|(it, trials)| result(&it.name, trials)).collect(),
        }
    };
    Report { champion, trials, entries: driven.into_iter().enumerate().map(entry).collect() }
}

fn result(name: &str, trials: &Trials) -> EnvironmentResult {
    let n = trials.len() as f64;
    let fitness: Vec<f64> = trials.iter().map(|trial| trial.0).collect();
    EnvironmentResult {
        name: name.to_owned(),
        fitness: Estimate::of(&fitness),
        time: trials.iter().map(|trial| trial.1).sum::<f64>() / n,
        deviation: trials.iter().map(|trial| trial.2).sum::<f64>() / n,
        arrived: trials.iter().filter(|trial| trial.3).count() as f64 / n,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// t_4 at 97.5 % is 2.7764; the standard error of 1..5 is sqrt(2.5/5).
    #[test]
    fn an_interval_is_that_of_students_t() {
        let estimate = Estimate::of(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(estimate.mean, 3.0);
        let half = 2.776_445_105 * 0.5_f64.sqrt();
        assert!(
            (estimate.high - 3.0 - half).abs() < 1e-6 && (3.0 - estimate.low - half).abs() < 1e-6
        );
        assert!(!estimate.includes_zero());
        assert!(Estimate::of(&[-1.0, 1.2]).includes_zero());
        assert_eq!(Estimate::of(&[2.0, 2.0]), Estimate { mean: 2.0, low: 2.0, high: 2.0 });
    }

    /// Differences are paired: two priors that follow the same luck differ by what they differ, not by the luck.
    #[test]
    fn differences_are_paired_by_seed_and_weighted() {
        let environment = |name: &str, weight| TrainingEnvironment {
            name: name.to_owned(),
            weight,
            ..TrainingEnvironment::preset("normal").unwrap()
        };
        let environments = [environment("a", 3.0), environment("b", 1.0)];
        let driven = |name, plus: f64| {
            let trial = |luck: f64| (luck + plus, 10.0, 0.01, luck < 5.0);
            let trials: Trials = [1.0, 5.0, 9.0].into_iter().map(trial).collect();
            let other = trials.iter().map(|it| (2.0 * plus, it.1, it.2, true)).collect();
            Driven { name, prior: Prior::default(), environments: vec![trials, other] }
        };
        let report = report(&environments, vec![driven("champion", 0.5), driven("flat", 0.1)]);
        assert_eq!((report.trials, report.entries.len()), (3, 2));
        assert_eq!(report.entries[0].difference, None);
        assert!((report.entries[0].fitness.mean - (3.0 * 5.5 + 1.0) / 4.0).abs() < 1e-12);
        let difference = report.entries[1].difference.unwrap();
        let expected = (3.0 * 0.4 + 0.8) / 4.0;
        assert!(
            (difference.low - expected).abs() < 1e-9 && (difference.high - expected).abs() < 1e-9
        );
        assert_eq!(report.entries[1].environments[0].arrived, 1.0 / 3.0);
    }
}
