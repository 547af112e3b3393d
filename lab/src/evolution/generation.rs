//! What is kept of a generation: enough for the thesis's figures 6 and 7, and for watching.

use super::environment::TrainingEnvironment;
use super::episode::Evaluation;
use super::genetic::ranking;
use super::genome::{self, Genome};
use serde::{Deserialize, Serialize};
use umwelt_core::settings::Prior;

/// The best and the mean of a generation's individuals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Of the best individual.
    pub best: f64,
    /// Over all individuals.
    pub mean: f64,
}

/// A generation in one environment. Each individual counts with its mean over its trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GenerationEnvironment {
    /// The environment.
    pub name: String,
    /// Largest deviation in m: smallest and mean (thesis figure 6).
    pub deviation: Spread,
    /// Time in s from the end of the calibration to the arrival, or to the time limit: smallest and mean (figure 7).
    pub time: Spread,
    /// Share of the episodes in which the robot arrived.
    pub arrived: f64,
}

/// The results of a generation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Generation {
    /// Its number, from 0.
    pub index: usize,
    /// Fitness: 1 is that of fixed-normal.
    pub fitness: Spread,
    /// The prior of the fittest individual: on the seeds of this generation, so not yet the best of anything else.
    pub prior: Prior,
    /// Each environment.
    pub environments: Vec<GenerationEnvironment>,
}

/// The results of `individuals`, whose evaluations follow one another: for each its environments, for each its trials.
pub(super) fn summary(
    index: usize,
    environments: &[TrainingEnvironment],
    individuals: &[Genome],
    fitness: &[f64],
    evaluations: &[Evaluation],
) -> Generation {
    let trials = evaluations.len() / (individuals.len() * environments.len());
    let best = ranking(fitness)[0];
    let of_environment = |(place, environment): (usize, &TrainingEnvironment)| {
        let chunks = evaluations.chunks_exact(trials).skip(place).step_by(environments.len());
        let mean = |of: fn(&Evaluation) -> f64| -> Vec<f64> {
            chunks.clone().map(|it| it.iter().map(of).sum::<f64>() / trials as f64).collect()
        };
        let arrived = mean(|it| f64::from(u8::from(it.arrived)));
        GenerationEnvironment {
            name: environment.name.clone(),
            deviation: spread(&mean(|it| it.deviation), f64::min),
            time: spread(&mean(|it| it.time), f64::min),
            arrived: arrived.iter().sum::<f64>() / individuals.len() as f64,
        }
    };
    Generation {
        index,
        fitness: spread(fitness, f64::max),
        prior: genome::to_prior(&individuals[best]),
        environments: environments.iter().enumerate().map(of_environment).collect(),
    }
}

fn spread(values: &[f64], better: fn(f64, f64) -> f64) -> Spread {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    Spread { best: values.iter().copied().reduce(better).unwrap_or(mean), mean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_individual_counts_with_its_mean_over_the_trials_of_its_environment() {
        let environments =
            ["normal", "bad-link"].map(|name| TrainingEnvironment::preset(name).unwrap());
        let evaluation = |deviation: f64, time: f64, arrived| Evaluation {
            arrived,
            time,
            deviation,
            ..Evaluation::default()
        };
        // Two individuals x two environments x two trials.
        let evaluations = [
            evaluation(1.0, 10.0, true),
            evaluation(3.0, 20.0, true),
            evaluation(5.0, 30.0, false),
            evaluation(7.0, 40.0, true),
            evaluation(0.0, 12.0, true),
            evaluation(2.0, 12.0, true),
            evaluation(9.0, 33.0, false),
            evaluation(9.0, 35.0, false),
        ];
        let individuals = [[0.1, 1.0, 1.0, 0.1].repeat(3), [0.2, 1.0, 1.0, 0.1].repeat(3)];
        let it = summary(4, &environments, &individuals, &[0.5, 0.75], &evaluations);
        assert_eq!((it.index, it.fitness), (4, Spread { best: 0.75, mean: 0.625 }));
        assert_eq!(it.prior.forward.mu(), 0.2);
        let [normal, bad] = &it.environments[..] else { panic!("two environments") };
        assert_eq!(normal.deviation, Spread { best: 1.0, mean: 1.5 });
        assert_eq!(normal.time, Spread { best: 12.0, mean: 13.5 });
        assert_eq!((normal.arrived, bad.arrived), (1.0, 0.25));
        assert_eq!(bad.deviation, Spread { best: 6.0, mean: 7.5 });
        assert_eq!((bad.name.as_str(), bad.time.best), ("bad-link", 34.0));
    }
}
