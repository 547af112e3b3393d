//! Between the wire and core: what a request and its preset mean, and what came of it.

use super::champion::{self, verdict};
use super::generation::GenerationEnvironment;
use super::{Champion, Entry, EnvironmentResult, Estimate, Generation, Optimizer, Preset};
use super::{Progress, Request, Spec, Stage, spec};
use crate::body;
use crate::check::{Check, Checked};
use crate::named::Known;
use crate::number::known as finite;
use crate::prior;
use crate::problem::{Problems, reason};
use umwelt_core::evolution::{
    self, EvolutionSettings, FitnessLimits, GeneticSettings, TrainingEnvironment,
};
use umwelt_core::settings::Settings;

impl Request {
    /// Reads the body of a POST where the simulated environments are known: the request, and what is to be run.
    /// `known` says what a name stands for, as [`crate::training::built_in`] does.
    ///
    /// # Errors
    /// Every problem as [`Request::read`] and [`Request::to_core`] have it, all at once.
    pub fn read_known(
        json: &[u8],
        known: impl Fn(&str) -> Known<TrainingEnvironment>,
    ) -> Result<(Self, EvolutionSettings), Problems> {
        body::read_resolved(json, |request: &Self, check| request.resolve(known, check))
    }

    /// What is to be run, all filled in.
    ///
    /// # Errors
    /// Every value out of its range, every environment that nobody knows, and what contradicts the rest.
    pub fn to_core(
        &self,
        known: impl Fn(&str) -> Known<TrainingEnvironment>,
    ) -> Result<EvolutionSettings, Problems> {
        let mut check = Check::default();
        self.check(&mut check);
        let settings = self.resolve(known, &mut check);
        check.finish()?;
        Ok(settings)
    }

    /// The preset with what was said in its place; `check` knows what is wrong with it.
    fn resolve(
        &self,
        known: impl Fn(&str) -> Known<TrainingEnvironment>,
        check: &mut Check,
    ) -> EvolutionSettings {
        let mut settings = self.preset.unwrap_or_default().settings();
        if let Some(names) = &self.environments {
            let found = names.iter().enumerate().filter_map(|(index, name)| {
                let field = format!("environments[{index}]");
                check.known(&field, name, reason::UNKNOWN_ENVIRONMENT, &known)
            });
            settings.environments = found.collect();
        }
        self.resolve_numbers(&mut settings);
        if let Some(name) = &self.prior
            && prior::built_in(name).is_ok()
        {
            let remedy = "this one comes with the server: choose another name";
            check.report(reason::BUILT_IN, "prior", name.as_str(), remedy);
        }
        self.agree(&settings, check);
        check.ok("", settings.check());
        settings
    }

    fn resolve_numbers(&self, settings: &mut EvolutionSettings) {
        let size = |given: Option<u64>, preset| {
            given.map_or(preset, |given| usize::try_from(given).unwrap_or(usize::MAX))
        };
        if let Some(optimizer) = self.optimizer {
            settings.optimizer = optimizer.into();
        }
        settings.population = size(self.population, settings.population);
        settings.generations = size(self.generations, settings.generations);
        settings.trials = size(self.trials, settings.trials);
        settings.selection_trials = size(self.selection_trials, settings.selection_trials);
        settings.report_trials = size(self.report_trials, settings.report_trials);
        settings.seed = self.seed.unwrap_or(settings.seed);
        let genetic = settings.genetic;
        settings.genetic = GeneticSettings {
            crossover: self.crossover_probability.unwrap_or(genetic.crossover),
            reproduction: self.reproduction_probability.unwrap_or(genetic.reproduction),
            mutation: self.mutation_probability.unwrap_or(genetic.mutation),
            expansion: self.expansion.unwrap_or(genetic.expansion),
            elites: size(self.elites, genetic.elites),
        };
        settings.limits = FitnessLimits {
            deviation: self.max_deviation_m.unwrap_or(settings.limits.deviation),
            time: self.max_time_s.unwrap_or(settings.limits.time),
        };
        let controller = settings.controller;
        settings.controller =
            Settings { slots: size(self.horizon_slots, controller.slots), ..controller };
    }

    /// What only the whole can say.
    fn agree(&self, settings: &EvolutionSettings, check: &mut Check) {
        let GeneticSettings { crossover, reproduction, mutation, elites, .. } = settings.genetic;
        let remedy = format!("use fewer than the population of {}", settings.population);
        let holds = self.elites.is_none() || elites < settings.population;
        check.agrees("elites", holds, elites, &remedy);
        if self.elites.is_none() && elites >= settings.population {
            let remedy = format!("use more than the {elites} elites");
            check.agrees("population", false, settings.population, &remedy);
        }
        let sum = crossover + reproduction + mutation;
        // What is no number is reported by the checks of the fields.
        if (sum - 1.0).abs() > spec::SUM_TOLERANCE {
            let remedy = format!(
                "crossover {crossover}, reproduction {reproduction} and mutation {mutation} sum to {sum}: make it 1"
            );
            for (name, given) in [
                ("crossover_probability", self.crossover_probability),
                ("reproduction_probability", self.reproduction_probability),
                ("mutation_probability", self.mutation_probability),
            ] {
                if let Some(given) = given {
                    check.agrees(name, false, given, &remedy);
                }
            }
        }
        let (all, batch) = (settings.training_episodes(), settings.generation_episodes());
        let remedy = if batch > spec::MAX_BATCH {
            let most = spec::MAX_BATCH;
            format!("population x trials x environments are {batch} episodes: at most {most}")
        } else {
            let most = spec::MAX_EPISODES;
            format!(
                "population x generations x trials x environments are {all} episodes: at most {most}"
            )
        };
        let is_small = batch <= spec::MAX_BATCH && all <= spec::MAX_EPISODES;
        check.agrees("population", is_small, settings.population, &remedy);
    }
}

impl Preset {
    /// What is run where nothing else is said.
    pub fn settings(self) -> EvolutionSettings {
        EvolutionSettings::preset(self.name()).expect("a test asks for each of them")
    }
}

impl From<Optimizer> for evolution::Optimizer {
    fn from(wire: Optimizer) -> Self {
        match wire {
            Optimizer::Genetic => Self::Genetic,
            Optimizer::CmaEs => Self::CmaEs,
            Optimizer::EmpiricalBayes => Self::EmpiricalBayes,
        }
    }
}

impl From<evolution::Optimizer> for Optimizer {
    fn from(core: evolution::Optimizer) -> Self {
        match core {
            evolution::Optimizer::Genetic => Self::Genetic,
            evolution::Optimizer::CmaEs => Self::CmaEs,
            evolution::Optimizer::EmpiricalBayes => Self::EmpiricalBayes,
        }
    }
}

impl Spec {
    /// What was asked for, all filled in; `prior` is the name that the champion is to have.
    pub fn from_core(core: &EvolutionSettings, prior: Option<&str>) -> Self {
        let genetic = core.genetic;
        Self {
            environments: core.environments.iter().map(|it| it.name.clone()).collect(),
            optimizer: core.optimizer.into(),
            population: core.population as u64,
            generations: core.generations as u64,
            trials: core.trials as u64,
            selection_trials: core.selection_trials as u64,
            report_trials: core.report_trials as u64,
            seed: core.seed,
            crossover_probability: genetic.crossover,
            reproduction_probability: genetic.reproduction,
            mutation_probability: genetic.mutation,
            expansion: genetic.expansion,
            elites: genetic.elites as u64,
            max_deviation_m: core.limits.deviation,
            max_time_s: core.limits.time,
            horizon_slots: core.controller.slots as u64,
            prior: prior.map(str::to_owned),
        }
    }
}

impl Stage {
    /// The stage of core, and how many generations of `generations` have ended in it.
    pub fn of(core: evolution::Stage, generations: u64) -> (Self, u64) {
        match core {
            evolution::Stage::Reference => (Self::Reference, 0),
            evolution::Stage::Generations { generation } => (Self::Generations, generation as u64),
            evolution::Stage::Selection => (Self::Selection, generations),
            evolution::Stage::Report => (Self::Report, generations),
            evolution::Stage::Done => (Self::Done, generations),
        }
    }
}

impl Progress {
    /// Of an evolution that waits for its turn: of core's, not begun.
    pub fn queued(core: &evolution::Evolution) -> Self {
        Self { stage: Stage::Queued, ..Self::of(core, None, 0.0, None) }
    }

    /// Of an evolution whose last generation had this fitness, after `elapsed_s` and with `remaining_s` to go.
    pub fn of(
        core: &evolution::Evolution,
        fitness: Option<evolution::Spread>,
        elapsed_s: f64,
        remaining_s: Option<f64>,
    ) -> Self {
        let generations = core.settings().generations as u64;
        let (stage, generation) = Stage::of(core.stage(), generations);
        Self {
            stage,
            generation,
            generations,
            best_fitness: fitness.and_then(|it| finite(it.best)),
            mean_fitness: fitness.and_then(|it| finite(it.mean)),
            episodes: core.episodes(),
            total_episodes: core.total_episodes(),
            elapsed_s,
            remaining_s: remaining_s.and_then(finite),
        }
    }
}

impl From<&evolution::Generation> for Generation {
    fn from(core: &evolution::Generation) -> Self {
        let environments = core.environments.iter().map(|it| GenerationEnvironment {
            environment: it.name.clone(),
            best_deviation_m: it.deviation.best,
            mean_deviation_m: it.deviation.mean,
            best_time_s: it.time.best,
            mean_time_s: it.time.mean,
            arrived: it.arrived,
        });
        Self {
            index: core.index as u64,
            best_fitness: core.fitness.best,
            mean_fitness: core.fitness.mean,
            prior: core.prior.into(),
            environments: environments.collect(),
        }
    }
}

impl From<&evolution::Entry> for Entry {
    fn from(core: &evolution::Entry) -> Self {
        let difference = core.difference.map(Estimate::from);
        let environments = core.environments.iter().map(|it| EnvironmentResult {
            environment: it.name.clone(),
            fitness: it.fitness.into(),
            time_s: it.time,
            deviation_m: it.deviation,
            arrived: it.arrived,
        });
        Self {
            name: core.name.clone(),
            prior: core.prior.into(),
            fitness: core.fitness.into(),
            difference,
            environments: environments.collect(),
            verdict: verdict(&core.name, difference),
        }
    }
}

impl From<&evolution::Report> for Champion {
    fn from(core: &evolution::Report) -> Self {
        let mut entries: Vec<Entry> = core.entries.iter().map(Entry::from).collect();
        champion::add_prices(&mut entries);
        let trials = core.trials as u64;
        let notes = champion::notes(&entries, trials);
        Self { prior: core.champion.into(), trials, entries, notes }
    }
}
