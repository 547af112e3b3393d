//! Evolutions: what a request and its preset mean, and how results are shown.

use super::pace::Pace;
use super::verdict::{champion, entry};
use crate::evolution::{
    self as lab, EvolutionSettings, FitnessLimits, GeneticSettings, TrainingEnvironment,
};
use umwelt_api::evolution::{
    Champion, Entry, EnvironmentResult, Estimate, Generation, GenerationEnvironment, MAX_BATCH,
    MAX_EPISODES, Optimizer, Preset, Progress, Request, SUM_TOLERANCE, Spec, Stage,
};
use umwelt_api::problem::reason;
use umwelt_api::{Check, Checked, Known, Problems, Validate, body, prior};
use umwelt_core::settings::Settings;

/// Reads the body of a POST where the simulated environments are known: the request, and what is to be run.
/// `known` says what a name stands for, as [`built_in`](super::training::built_in) does.
///
/// # Errors
/// Every problem as [`Request::read`] and [`settings`] have it, all at once.
pub fn read(
    json: &[u8],
    known: impl Fn(&str) -> Known<TrainingEnvironment>,
) -> Result<(Checked<Request>, EvolutionSettings), Problems> {
    body::read_resolved(json, |request, check| resolve(request, known, check))
}

/// What is to be run for `request`, all filled in.
///
/// # Errors
/// Every value out of its range, every unknown environment, and what contradicts the rest.
pub fn settings(
    request: &Request,
    known: impl Fn(&str) -> Known<TrainingEnvironment>,
) -> Result<EvolutionSettings, Problems> {
    let mut check = Check::default();
    request.check(&mut check);
    let settings = resolve(request, known, &mut check);
    check.finish()?;
    Ok(settings)
}

/// The preset with what was said in its place; `check` knows what is wrong with it.
fn resolve(
    request: &Request,
    known: impl Fn(&str) -> Known<TrainingEnvironment>,
    check: &mut Check,
) -> EvolutionSettings {
    let mut settings = preset(request.preset.unwrap_or_default());
    if let Some(names) = &request.environments {
        let found = names.iter().enumerate().filter_map(|(index, name)| {
            let field = format!("environments[{index}]");
            check.known(&field, name, reason::UNKNOWN_ENVIRONMENT, &known)
        });
        settings.environments = found.collect();
    }
    resolve_numbers(request, &mut settings);
    if let Some(name) = &request.prior
        && prior::built_in(name).is_ok()
    {
        let remedy = "this one comes with the server: choose another name";
        check.report(reason::BUILT_IN, "prior", name.as_str(), remedy);
    }
    agree(request, &settings, check);
    check.ok("", settings.check());
    settings
}

fn resolve_numbers(request: &Request, settings: &mut EvolutionSettings) {
    let size = |given: Option<u64>, preset| {
        given.map_or(preset, |given| usize::try_from(given).unwrap_or(usize::MAX))
    };
    if let Some(optimizer) = request.optimizer {
        settings.optimizer = optimizer.into();
    }
    settings.population = size(request.population, settings.population);
    settings.generations = size(request.generations, settings.generations);
    settings.trials = size(request.trials, settings.trials);
    settings.selection_trials = size(request.selection_trials, settings.selection_trials);
    settings.report_trials = size(request.report_trials, settings.report_trials);
    settings.seed = request.seed.unwrap_or(settings.seed);
    let genetic = settings.genetic;
    settings.genetic = GeneticSettings {
        crossover: request.crossover_probability.unwrap_or(genetic.crossover),
        reproduction: request.reproduction_probability.unwrap_or(genetic.reproduction),
        mutation: request.mutation_probability.unwrap_or(genetic.mutation),
        expansion: request.expansion.unwrap_or(genetic.expansion),
        elites: size(request.elites, genetic.elites),
    };
    settings.limits = FitnessLimits {
        deviation: request.max_deviation_m.unwrap_or(settings.limits.deviation),
        time: request.max_time_s.unwrap_or(settings.limits.time),
    };
    let controller = settings.controller;
    settings.controller =
        Settings { slots: size(request.horizon_slots, controller.slots), ..controller };
}

/// What only the whole can say.
fn agree(request: &Request, settings: &EvolutionSettings, check: &mut Check) {
    let GeneticSettings { crossover, reproduction, mutation, elites, .. } = settings.genetic;
    let remedy = format!("use fewer than the population of {}", settings.population);
    let holds = request.elites.is_none() || elites < settings.population;
    check.agrees("elites", holds, elites, &remedy);
    if request.elites.is_none() && elites >= settings.population {
        let remedy = format!("use more than the {elites} elites");
        check.agrees("population", false, settings.population, &remedy);
    }
    let sum = crossover + reproduction + mutation;
    // What is no number is reported by the checks of the fields.
    if (sum - 1.0).abs() > SUM_TOLERANCE {
        let remedy = format!(
            "crossover {crossover}, reproduction {reproduction} and mutation {mutation} sum to {sum}: make it 1"
        );
        for (name, given) in [
            ("crossover_probability", request.crossover_probability),
            ("reproduction_probability", request.reproduction_probability),
            ("mutation_probability", request.mutation_probability),
        ] {
            if let Some(given) = given {
                check.agrees(name, false, given, &remedy);
            }
        }
    }
    let (all, batch) = (settings.training_episodes(), settings.generation_episodes());
    let remedy = if batch > MAX_BATCH {
        let most = MAX_BATCH;
        format!("population x trials x environments are {batch} episodes: at most {most}")
    } else {
        let most = MAX_EPISODES;
        format!(
            "population x generations x trials x environments are {all} episodes: at most {most}"
        )
    };
    let is_small = batch <= MAX_BATCH && all <= MAX_EPISODES;
    check.agrees("population", is_small, settings.population, &remedy);
}

/// What is run where nothing but the preset is said.
pub fn preset(preset: Preset) -> EvolutionSettings {
    EvolutionSettings::preset(preset.name()).expect("a test asks for each of them")
}

impl From<Optimizer> for lab::Optimizer {
    fn from(wire: Optimizer) -> Self {
        match wire {
            Optimizer::Genetic => Self::Genetic,
            Optimizer::CmaEs => Self::CmaEs,
            Optimizer::EmpiricalBayes => Self::EmpiricalBayes,
        }
    }
}

impl From<lab::Optimizer> for Optimizer {
    fn from(lab: lab::Optimizer) -> Self {
        match lab {
            lab::Optimizer::Genetic => Self::Genetic,
            lab::Optimizer::CmaEs => Self::CmaEs,
            lab::Optimizer::EmpiricalBayes => Self::EmpiricalBayes,
        }
    }
}

/// What was asked for, all filled in; `prior` is the name that the champion is to have.
pub fn spec(settings: &EvolutionSettings, prior: Option<&str>) -> Spec {
    let genetic = settings.genetic;
    Spec {
        environments: settings.environments.iter().map(|it| it.name.clone()).collect(),
        optimizer: settings.optimizer.into(),
        population: settings.population as u64,
        generations: settings.generations as u64,
        trials: settings.trials as u64,
        selection_trials: settings.selection_trials as u64,
        report_trials: settings.report_trials as u64,
        seed: settings.seed,
        crossover_probability: genetic.crossover,
        reproduction_probability: genetic.reproduction,
        mutation_probability: genetic.mutation,
        expansion: genetic.expansion,
        elites: genetic.elites as u64,
        max_deviation_m: settings.limits.deviation,
        max_time_s: settings.limits.time,
        horizon_slots: settings.controller.slots as u64,
        prior: prior.map(str::to_owned),
    }
}

/// The stage of the wire, and how many generations have ended in it; without a stage it has not begun.
pub fn stage(settings: &EvolutionSettings, reached: Option<lab::Stage>) -> (Stage, u64) {
    let all = settings.generations as u64;
    match reached {
        None => (Stage::Queued, 0),
        Some(lab::Stage::Reference) => (Stage::Reference, 0),
        Some(lab::Stage::Generations { generation }) => (Stage::Generations, generation as u64),
        Some(lab::Stage::Selection) => (Stage::Selection, all),
        Some(lab::Stage::Report) => (Stage::Report, all),
        Some(lab::Stage::Done) => (Stage::Done, all),
    }
}

/// How far an evolution has got that is in this stage, and whose last generation had this fitness.
pub fn progress(
    settings: &EvolutionSettings,
    reached: Option<lab::Stage>,
    fitness: Option<lab::Spread>,
    pace: Pace,
) -> Progress {
    let (stage, generation) = stage(settings, reached);
    let Pace { episodes, total_episodes, elapsed_s, remaining_s } = pace;
    Progress {
        stage,
        generation,
        generations: settings.generations as u64,
        best_fitness: fitness.map(|it| it.best).filter(|it| it.is_finite()),
        mean_fitness: fitness.map(|it| it.mean).filter(|it| it.is_finite()),
        episodes,
        total_episodes,
        elapsed_s,
        remaining_s: remaining_s.filter(|it| it.is_finite()),
    }
}

impl From<lab::Estimate> for Estimate {
    fn from(lab: lab::Estimate) -> Self {
        Self { mean: lab.mean, low: lab.low, high: lab.high }
    }
}

impl From<&lab::Generation> for Generation {
    fn from(lab: &lab::Generation) -> Self {
        let environments = lab.environments.iter().map(|it| GenerationEnvironment {
            environment: it.name.clone(),
            best_deviation_m: it.deviation.best,
            mean_deviation_m: it.deviation.mean,
            best_time_s: it.time.best,
            mean_time_s: it.time.mean,
            arrived: it.arrived,
        });
        Self {
            index: lab.index as u64,
            best_fitness: lab.fitness.best,
            mean_fitness: lab.fitness.mean,
            prior: lab.prior.into(),
            environments: environments.collect(),
        }
    }
}

impl From<&lab::Entry> for Entry {
    fn from(lab: &lab::Entry) -> Self {
        let environments = lab.environments.iter().map(|it| EnvironmentResult {
            environment: it.name.clone(),
            fitness: it.fitness.into(),
            time_s: it.time,
            deviation_m: it.deviation,
            arrived: it.arrived,
        });
        entry(
            lab.name.clone(),
            lab.prior.into(),
            lab.fitness.into(),
            lab.difference.map(Estimate::from),
            environments.collect(),
        )
    }
}

impl From<&lab::Report> for Champion {
    fn from(lab: &lab::Report) -> Self {
        let entries = lab.entries.iter().map(Entry::from).collect();
        champion(lab.champion.into(), lab.trials as u64, entries)
    }
}
