//! The settings of an evolution: environments, sizes, optimiser, seed.

use super::environment::{FitnessLimits, TrainingEnvironment};
use super::genetic::GeneticSettings;
use umwelt_core::link::{Link, LinkError};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::Task;

/// Most environments of one evolution.
pub const MAX_ENVIRONMENTS: usize = 32;
/// Most individuals.
pub const MAX_POPULATION: usize = 1000;
/// Most generations: what is kept of each is bounded by it.
pub const MAX_GENERATIONS: usize = 1000;
/// Most trials of an individual in an environment.
pub const MAX_TRIALS: usize = 100;
/// Most fresh trials that choose the champion.
pub const MAX_SELECTION_TRIALS: usize = 500;
/// Most fresh trials on which it is reported.
pub const MAX_REPORT_TRIALS: usize = 1000;
/// Most episodes of one evolution, about a day of one core.
pub const MAX_EPISODES: u64 = 20_000_000;
/// Most episodes of one generation: the evaluation of each is held until the generation ends, some 30 MB.
pub const MAX_BATCH: u64 = 200_000;
/// Largest expansion of a crossover.
pub const MAX_EXPANSION: f64 = 10.0;

/// The names that [`EvolutionSettings::preset`] knows.
pub const PRESETS: [&str; 3] = ["default", "thesis", "quick"];

/// How the prior is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Optimizer {
    /// The thesis's genetic algorithm.
    Genetic,
    /// Covariance matrix adaptation (Hansen 2016).
    CmaEs,
    /// The prior under which the samples of the same environments are likeliest: an honest belief, made without
    /// regard to fitness.
    EmpiricalBayes,
}

/// The settings of an evolution.
#[derive(Clone, Debug, PartialEq)]
pub struct EvolutionSettings {
    /// Where individuals are tried, 1..=[`MAX_ENVIRONMENTS`] of different names.
    pub environments: Vec<TrainingEnvironment>,
    /// How the prior is searched for.
    pub optimizer: Optimizer,
    /// Individuals of a generation, 2..=[`MAX_POPULATION`].
    pub population: usize,
    /// Generations, 1..=[`MAX_GENERATIONS`].
    pub generations: usize,
    /// Trials of each individual in each environment, 1..=[`MAX_TRIALS`].
    pub trials: usize,
    /// Fresh trials in each environment of each of the candidates from whom the champion is chosen,
    /// 1..=[`MAX_SELECTION_TRIALS`].
    pub selection_trials: usize,
    /// Fresh trials in each environment on which the champion is reported, 2..=[`MAX_REPORT_TRIALS`].
    pub report_trials: usize,
    /// What the genetic algorithm does.
    pub genetic: GeneticSettings,
    /// Beyond what an individual has no fitness.
    pub limits: FitnessLimits,
    /// The controller; its prior is the individual's.
    pub controller: Settings,
    /// What is driven.
    pub task: Task,
    /// Of everything random.
    pub seed: u64,
}

/// Why an evolution cannot run. The contract checks each field and names all that are wrong; this is the last line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A count is out of its range.
    #[error("{field} is {value}, it must be from {low} to {high}")]
    Count {
        /// The field.
        field: &'static str,
        /// Its value.
        value: u64,
        /// Smallest.
        low: u64,
        /// Largest.
        high: u64,
    },
    /// The probabilities of crossover, reproduction and mutation are not probabilities that sum to one.
    #[error(
        "crossover, reproduction and mutation are {0}, {1} and {2}: they must not be negative and must sum to 1"
    )]
    Probabilities(f64, f64, f64),
    /// A number is not positive or too large.
    #[error("{field} is {value}, it must be above 0 and at most {high}")]
    Number {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Largest.
        high: f64,
    },
    /// Two environments have one name.
    #[error("the environment {0} is named twice")]
    NamedTwice(String),
    /// An environment's link means nothing.
    #[error("environment {0}: {1}")]
    Link(String, LinkError),
    /// There is nowhere to drive.
    #[error("the task has no waypoint")]
    NoWaypoint,
}

impl EvolutionSettings {
    /// The settings called `name`, one of [`PRESETS`].
    ///
    /// - `thesis`: tables 1 and 2, one command per reply, its two environments, two trials of each individual.
    /// - `quick`: the same, small enough to watch: a few seconds.
    /// - `default`: the six environments of [`super::ENVIRONMENTS`], twenty slots per horizon, a minute or two.
    ///
    /// All drive the thesis's simulated round trip, calibration first, seen by the camera of field facts.
    pub fn preset(name: &str) -> Option<Self> {
        let (environments, slots) = match name {
            "default" => (&super::ENVIRONMENTS[..], 20),
            "thesis" | "quick" => (&super::ENVIRONMENTS[..2], 1),
            _ => return None,
        };
        let thesis = Self {
            environments: environments
                .iter()
                .filter_map(|name| TrainingEnvironment::preset(name))
                .collect(),
            optimizer: Optimizer::Genetic,
            population: 100,
            generations: 100,
            trials: 2,
            selection_trials: 100,
            report_trials: 400,
            genetic: GeneticSettings::default(),
            limits: FitnessLimits::default(),
            controller: Settings { slots, noise: PoseNoise::CAMERA, ..Settings::default() },
            task: Task::thesis(),
            seed: 1,
        };
        Some(match name {
            "quick" => Self {
                population: 24,
                generations: 12,
                selection_trials: 20,
                report_trials: 60,
                ..thesis
            },
            "default" => Self { population: 40, generations: 30, ..thesis },
            _ => thesis,
        })
    }

    /// Whether an evolution can run.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), SettingsError> {
        let count = |field, value: usize, low: usize, high: usize| {
            let (value, low, high) = (value as u64, low as u64, high as u64);
            let is_in = (low..=high).contains(&value);
            if is_in { Ok(()) } else { Err(SettingsError::Count { field, value, low, high }) }
        };
        let positive = |field, value: f64, high: f64| {
            let is_in = value > 0.0 && value <= high;
            if is_in { Ok(()) } else { Err(SettingsError::Number { field, value, high }) }
        };
        count("environments", self.environments.len(), 1, MAX_ENVIRONMENTS)?;
        count("population", self.population, 2, MAX_POPULATION)?;
        count("generations", self.generations, 1, MAX_GENERATIONS)?;
        count("trials", self.trials, 1, MAX_TRIALS)?;
        count("selection_trials", self.selection_trials, 1, MAX_SELECTION_TRIALS)?;
        count("report_trials", self.report_trials, 2, MAX_REPORT_TRIALS)?;
        count("elites", self.genetic.elites, 0, self.population - 1)?;
        for (field, value, high) in [
            ("population x trials x environments", self.generation_episodes(), MAX_BATCH),
            (
                "population x generations x trials x environments",
                self.training_episodes(),
                MAX_EPISODES,
            ),
        ] {
            if value > high {
                return Err(SettingsError::Count { field, value, low: 1, high });
            }
        }
        let GeneticSettings { crossover, reproduction, mutation, expansion, .. } = self.genetic;
        let all = [crossover, reproduction, mutation];
        let is_sum = (all.iter().sum::<f64>() - 1.0).abs() <= 1e-9;
        if !(is_sum && all.iter().all(|part| (0.0..=1.0).contains(part))) {
            return Err(SettingsError::Probabilities(crossover, reproduction, mutation));
        }
        if expansion != 0.0 {
            positive("expansion", expansion, MAX_EXPANSION)?;
        }
        positive("max_deviation", self.limits.deviation, 1e3)?;
        positive("max_time", self.limits.time, 1e5)?;
        for (index, environment) in self.environments.iter().enumerate() {
            let TrainingEnvironment { name, link, weight, .. } = environment;
            positive("weight", *weight, 1e9)?;
            if self.environments[..index].iter().any(|other| other.name == *name) {
                return Err(SettingsError::NamedTwice(name.clone()));
            }
            Link::new(link.clone(), 0).map_err(|error| SettingsError::Link(name.clone(), error))?;
        }
        if self.task.waypoints.is_empty() { Err(SettingsError::NoWaypoint) } else { Ok(()) }
    }

    /// Episodes of all generations.
    pub fn training_episodes(&self) -> u64 {
        self.generation_episodes().saturating_mul(self.generations as u64)
    }

    /// Episodes of one generation.
    pub fn generation_episodes(&self) -> u64 {
        let sizes = [self.population, self.trials, self.environments.len()];
        sizes.into_iter().fold(1, |product: u64, size| product.saturating_mul(size as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quick() -> EvolutionSettings {
        EvolutionSettings::preset("quick").unwrap()
    }

    #[test]
    fn presets_can_run_and_the_thesis_is_its_table_2() {
        for name in PRESETS {
            assert_eq!(EvolutionSettings::preset(name).unwrap().check(), Ok(()), "{name}");
        }
        let thesis = EvolutionSettings::preset("thesis").unwrap();
        assert_eq!((thesis.population, thesis.generations), (100, 100));
        let GeneticSettings { crossover, reproduction, mutation, expansion, elites } =
            thesis.genetic;
        assert_eq!((crossover, reproduction, mutation), (0.49, 0.49, 0.02));
        assert_eq!((expansion, elites, thesis.limits.deviation), (1.2, 0, 0.1));
        assert_eq!(thesis.controller.slots, 1);
        assert_eq!(EvolutionSettings::preset("fast"), None);
    }

    #[test]
    fn what_cannot_run_is_refused() {
        let wrong: [fn(&mut EvolutionSettings); 16] = [
            |it| it.environments.clear(),
            |it| it.environments = vec![it.environments[0].clone(); 33],
            |it| it.environments[1].name = it.environments[0].name.clone(),
            |it| it.environments[0].weight = 0.0,
            |it| it.environments[0].weight = f64::NAN,
            |it| it.environments[0].link.late.probability = 2.0,
            |it| it.population = 1,
            |it| it.generations = 0,
            |it| it.trials = 101,
            |it| it.report_trials = 1,
            |it| it.genetic.elites = it.population,
            |it| it.genetic.mutation = 0.03,
            |it| (it.genetic.mutation, it.genetic.crossover) = (-0.02, 0.53),
            |it| it.genetic.expansion = f64::INFINITY,
            |it| it.limits.time = f64::NAN,
            |it| it.task.waypoints.clear(),
        ];
        for (index, change) in wrong.iter().enumerate() {
            let mut settings = quick();
            change(&mut settings);
            assert!(settings.check().is_err(), "{index}");
        }
        let huge =
            EvolutionSettings { population: 1000, generations: 1000, trials: 100, ..quick() };
        assert!(matches!(huge.check(), Err(SettingsError::Count { value: 200_000_000, .. })));
        let wide = EvolutionSettings { population: 1000, generations: 1, trials: 100, ..quick() };
        assert_eq!((wide.generation_episodes(), wide.check()), (MAX_BATCH, Ok(())));
        let mut wider = wide;
        wider.environments.extend(TrainingEnvironment::preset("slippery"));
        assert!(matches!(wider.check(), Err(SettingsError::Count { value: 300_000, .. })));
    }
}
