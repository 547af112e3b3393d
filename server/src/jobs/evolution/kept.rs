//! The settings of an evolution as they are kept: specs of the wire, in numbers whatever names and presets they came by.

use crate::jobs::UPGRADES;
use crate::store::document::{Form, environment};
use serde::{Deserialize, Serialize};
use umwelt_api::evolution::Optimizer;
use umwelt_api::{robot, task, training};
use umwelt_lab::evolution::{EvolutionSettings, FitnessLimits, GeneticSettings};

/// How the record of an evolution is kept.
pub(super) const FORM: Form =
    Form { is_within: true, upgrades: UPGRADES, base: include_str!("kept.json") };

/// The settings of an evolution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spec {
    environments: Vec<Environment>,
    optimizer: Optimizer,
    population: usize,
    generations: usize,
    trials: usize,
    selection_trials: usize,
    report_trials: usize,
    genetic: Genetic,
    limits: Limits,
    controller: robot::Spec,
    task: task::Spec,
    seed: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Environment {
    name: String,
    #[serde(flatten)]
    spec: training::Spec,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Genetic {
    crossover: f64,
    reproduction: f64,
    mutation: f64,
    expansion: f64,
    elites: usize,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Limits {
    max_deviation_m: f64,
    max_time_s: f64,
}

impl From<&EvolutionSettings> for Spec {
    fn from(core: &EvolutionSettings) -> Self {
        let environments = core.environments.iter().map(|it| Environment {
            name: it.name.clone(),
            spec: environment::of_environment(it, None),
        });
        let GeneticSettings { crossover, reproduction, mutation, expansion, elites } = core.genetic;
        Self {
            environments: environments.collect(),
            optimizer: core.optimizer.into(),
            population: core.population,
            generations: core.generations,
            trials: core.trials,
            selection_trials: core.selection_trials,
            report_trials: core.report_trials,
            genetic: Genetic { crossover, reproduction, mutation, expansion, elites },
            limits: Limits { max_deviation_m: core.limits.deviation, max_time_s: core.limits.time },
            controller: (&core.controller).into(),
            task: (&core.task).into(),
            seed: core.seed,
        }
    }
}

impl Spec {
    /// The settings in core's terms.
    pub(super) fn convert(&self) -> Result<EvolutionSettings, String> {
        let environments =
            self.environments.iter().map(|it| environment::environment(it.name.clone(), &it.spec));
        let Genetic { crossover, reproduction, mutation, expansion, elites } = self.genetic;
        let limits = &self.limits;
        Ok(EvolutionSettings {
            environments: environments.collect::<Result<_, _>>()?,
            optimizer: self.optimizer.into(),
            population: self.population,
            generations: self.generations,
            trials: self.trials,
            selection_trials: self.selection_trials,
            report_trials: self.report_trials,
            genetic: GeneticSettings { crossover, reproduction, mutation, expansion, elites },
            limits: FitnessLimits { deviation: limits.max_deviation_m, time: limits.max_time_s },
            controller: crate::store::document::robot::controller(&self.controller)?,
            task: self.task.convert(),
            seed: self.seed,
        })
    }
}
