//! Evolution of priors: individuals are priors, fitness is how well a controller drives with them in simulated
//! environments (thesis section 4.3 and 5.2).
//!
//! [`Evolution`] is a state machine without a clock, a thread or a file: [`Evolution::jobs`] says what is to be
//! evaluated now, [`Evolution::evaluate`] evaluates one job, on whatever thread, and [`Evolution::tell`] takes the
//! evaluations in and goes on. Between two `tell`s its whole state can be stored and taken up again: the result is
//! the same, bit for bit, whoever evaluates the jobs and in whatever order.
//!
//! 1. *Reference*: fixed-normal drives each environment; its mean fitness becomes the unit there.
//! 2. *Generations*: every individual drives the same seeds (common random numbers), fresh ones each generation.
//!    Fitness is the weighted mean over the environments and never carried over.
//! 3. *Selection*: the ten fittest of the last generation drive fresh seeds; the best of them is the champion.
//! 4. *Report*: on third seeds, beside the best of the first generation, the weak default prior and a flat one.
//!
//! Where nobody arrives there is nothing to select by: it ends without a report and says why ([`Evolution::hopeless`]).
//!
//! ```
//! use umwelt_lab::evolution::{Evolution, EvolutionSettings};
//! let quick = EvolutionSettings::preset("quick").ok_or("no such preset")?;
//! let settings = EvolutionSettings { population: 4, generations: 2, report_trials: 2, ..quick };
//! let mut evolution = Evolution::new(settings)?;
//! while evolution.report().is_none() && evolution.hopeless().is_none() {
//!     let jobs = evolution.jobs();
//!     let evaluations: Vec<_> = jobs.iter().map(|job| evolution.evaluate(job)).collect();
//!     evolution.tell(&evaluations)?;
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cma_es;
mod empirical_bayes;
mod environment;
pub mod event_probability;
mod generation;
mod genetic;
mod genome;
mod hopeless;
mod report;
mod settings;
mod work;

pub use environment::{
    ENVIRONMENTS, Fitness, FitnessLimits, SMALLEST_DEVIATION, TrainingEnvironment,
};
pub use generation::{Generation, GenerationEnvironment, Spread};
pub use genetic::GeneticSettings;
pub use hopeless::{HOPELESS_GENERATIONS, Hopeless};
pub use report::{Entry, EnvironmentResult, Estimate, LEVEL, Report};
pub use settings::{
    EvolutionSettings, MAX_BATCH, MAX_ENVIRONMENTS, MAX_EPISODES, MAX_EXPANSION, MAX_GENERATIONS,
    MAX_POPULATION, MAX_REPORT_TRIALS, MAX_SELECTION_TRIALS, MAX_TRIALS, Optimizer, PRESETS,
    SettingsError,
};

use crate::seeds::{self, Purpose};
use cma_es::CmaEs;
use genome::Genome;
use report::Driven;
use serde::{Deserialize, Serialize};
use umwelt_core::conjugate::SampleStatistics;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::Pose;
use umwelt_core::identification::estimate::Channel;
use umwelt_core::plant::PlantModel;
use umwelt_core::settings::{Method, PoseNoise, Prior, Settings};

/// Version of the stored state; a state of another version is not taken up.
pub const STATE_VERSION: u32 = 1;

/// Episodes of fixed-normal in each environment, whose mean fitness becomes the unit.
pub const REFERENCE_TRIALS: usize = 200;

/// Individuals of the last generation from whom the champion is chosen.
pub const CANDIDATES: usize = 10;

/// Time in s that an episode may take beyond `FitnessLimits::time`: the calibration takes about 20 s.
const CALIBRATION_TIME: f64 = 40.0;

/// How far an evolution has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Fixed-normal sets the unit of fitness.
    Reference,
    /// The generation of this number is evaluated.
    Generations {
        /// From 0.
        generation: usize,
    },
    /// The candidates are compared.
    Selection,
    /// The champion is measured.
    Report,
    /// There is a report.
    Done,
}

/// One episode to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job {
    /// Number of the individual, of the candidate or of who is reported.
    subject: usize,
    environment: usize,
    seed: u64,
}

/// What came of one episode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Whether the robot arrived.
    pub arrived: bool,
    /// Time in s from the end of the calibration to the arrival, or to the time limit.
    pub time: f64,
    /// Largest deviation in m of the true position.
    pub deviation: f64,
    /// The samples of each channel, in the order of [`Channel::ALL`].
    pub samples: [SampleStatistics; 4],
}

/// Evaluations do not belong to the jobs that were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given} evaluations for {asked} jobs")]
pub struct TellError {
    /// How many there were.
    pub given: usize,
    /// How many there should be.
    pub asked: usize,
}

/// What the optimiser knows between two generations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Search {
    Genetic {
        population: Vec<Genome>,
    },
    CmaEs {
        search: CmaEs,
        population: Vec<Genome>,
    },
    /// One individual, which has the trials of a whole population.
    EmpiricalBayes {
        fitted: [Genome; 1],
    },
}

impl Search {
    fn individuals(&self) -> &[Genome] {
        match self {
            Self::Genetic { population } | Self::CmaEs { population, .. } => population,
            Self::EmpiricalBayes { fitted } => fitted,
        }
    }
}

/// An evolution: settings, and how far it has got.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolution {
    settings: EvolutionSettings,
    state: State,
}

/// How far an evolution has got: what is stored between two `tell`s, beside its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    version: u32,
    stage: Stage,
    search: Search,
    /// What fixed-normal's fitness is in each environment; empty before it is known.
    units: Vec<f64>,
    first_generation: Option<Genome>,
    candidates: Vec<Genome>,
    champion: Option<Genome>,
    report: Option<Report>,
    episodes: u64,
    /// Episodes of the reference and the generations in which the robot arrived; none where an older program began it.
    #[serde(default)]
    arrivals: Option<u64>,
    #[serde(default)]
    hopeless: Option<Hopeless>,
}

impl Evolution {
    /// An evolution that has not begun.
    ///
    /// # Errors
    /// The first thing that is wrong with the settings.
    pub fn new(settings: EvolutionSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        let drift = settings.controller.drift;
        let genes = genome::prior_genes(drift);
        let mut rng = seeds::rng(settings.seed, Purpose::Populate, 0);
        let weak = genome::of_prior(&Prior::default(), drift);
        let search = match settings.optimizer {
            Optimizer::Genetic => {
                let population = genetic::populate(&genes, settings.population, &mut rng);
                Search::Genetic { population }
            }
            Optimizer::CmaEs => {
                let search = CmaEs::new(&genes, &weak);
                let population = search.ask(&genes, settings.population, &mut rng);
                Search::CmaEs { search, population }
            }
            Optimizer::EmpiricalBayes => Search::EmpiricalBayes { fitted: [weak] },
        };
        let state = State {
            version: STATE_VERSION,
            stage: Stage::Reference,
            search,
            units: Vec::new(),
            first_generation: None,
            candidates: Vec::new(),
            champion: None,
            report: None,
            episodes: 0,
            arrivals: Some(0),
            hopeless: None,
        };
        Ok(Self { settings, state })
    }

    /// An evolution of these settings that goes on where another one of them was: the same as that one, bit for bit.
    ///
    /// # Errors
    /// The first thing that is wrong with the settings.
    pub fn resume(settings: EvolutionSettings, state: State) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self { settings, state })
    }

    /// How far it has got, to be stored.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What it was told.
    pub fn settings(&self) -> &EvolutionSettings {
        &self.settings
    }

    /// How far it has got.
    pub fn stage(&self) -> Stage {
        self.state.stage
    }

    /// Episodes driven so far.
    pub fn episodes(&self) -> u64 {
        self.state.episodes
    }

    /// Episodes that the whole of it takes.
    pub fn total_episodes(&self) -> u64 {
        let settings = &self.settings;
        let candidates = match (self.state.stage, settings.optimizer) {
            (_, Optimizer::EmpiricalBayes) => 0,
            (Stage::Selection | Stage::Report | Stage::Done, _) => self.state.candidates.len(),
            (_, Optimizer::Genetic) => CANDIDATES.min(settings.population),
            (_, Optimizer::CmaEs) => CANDIDATES.min(settings.population) + 1,
        };
        let beyond = REFERENCE_TRIALS
            + candidates * settings.selection_trials
            + self.reported().len() * settings.report_trials;
        settings.training_episodes() + (beyond * settings.environments.len()) as u64
    }

    /// What came of it, once it is done.
    pub fn report(&self) -> Option<&Report> {
        self.state.report.as_ref()
    }

    /// Why it ends without a report, where it does.
    pub fn hopeless(&self) -> Option<&Hopeless> {
        self.state.hopeless.as_ref()
    }

    /// Subjects of the stage, and trials of each in each environment.
    fn sizes(&self) -> (usize, usize) {
        let settings = &self.settings;
        if self.state.hopeless.is_some() {
            return (0, 0);
        }
        match self.state.stage {
            Stage::Reference => (1, REFERENCE_TRIALS),
            Stage::Generations { .. } => {
                let individuals = self.state.search.individuals().len();
                (individuals, settings.population / individuals * settings.trials)
            }
            Stage::Selection => (self.state.candidates.len(), settings.selection_trials),
            Stage::Report => (self.reported().len(), settings.report_trials),
            Stage::Done => (0, 0),
        }
    }

    /// What is to be evaluated now: subject by subject, environment by environment, trial by trial. Empty once done
    /// or hopeless.
    pub fn jobs(&self) -> Vec<Job> {
        let (purpose, generation) = match self.state.stage {
            Stage::Reference => (Purpose::Reference, 0),
            Stage::Generations { generation } => (Purpose::Train, generation),
            Stage::Selection => (Purpose::Select, 0),
            Stage::Report => (Purpose::Report, 0),
            Stage::Done => return Vec::new(),
        };
        let (subjects, trials) = self.sizes();
        let environments = self.settings.environments.len();
        let mut jobs = Vec::with_capacity(subjects * environments * trials);
        for subject in 0..subjects {
            for environment in 0..environments {
                // Common random numbers: no seed depends on the subject.
                jobs.extend((0..trials).map(|trial| {
                    let place = [generation, environment, trial];
                    let seed = seeds::seed(self.settings.seed, purpose, place);
                    Job { subject, environment, seed }
                }));
            }
        }
        jobs
    }

    /// How a subject of the stage drives.
    fn method(&self, subject: usize) -> (Method, Prior) {
        let prior = match self.state.stage {
            Stage::Reference | Stage::Done => {
                return (Method::FixedNormal, self.settings.controller.prior);
            }
            Stage::Generations { .. } => {
                genome::to_prior(&self.state.search.individuals()[subject])
            }
            Stage::Selection => genome::to_prior(&self.state.candidates[subject]),
            Stage::Report => self.reported()[subject].1,
        };
        (Method::Bayesian, prior)
    }

    /// Drives one episode of [`Evolution::jobs`]. The same job gives the same evaluation, bit for bit, on any thread.
    pub fn evaluate(&self, job: &Job) -> Evaluation {
        let EvolutionSettings { controller, task, limits, environments, .. } = &self.settings;
        let environment = &environments[job.environment];
        // Empirical Bayes learns from samples of the floor and the link alone.
        let fits = matches!(self.state.search, Search::EmpiricalBayes { .. });
        let is_fitted = fits && matches!(self.state.stage, Stage::Generations { .. });
        let noise = if is_fitted { PoseNoise::NONE } else { controller.noise };
        let (method, prior) = self.method(job.subject);
        let scenario = Scenario {
            settings: Settings { method, prior, noise, ..*controller },
            plant: PlantModel { drive: controller.drive, slip: environment.slip, noise },
            link: environment.link.clone(),
            task: task.clone(),
            start: Pose::default(),
            region: None,
            time_limit: limits.time + CALIBRATION_TIME,
        };
        let Ok((outcome, controller)) = scenario.run_with(job.seed, |_| {}) else {
            // Checked when the evolution was made; a robot that cannot be simulated does not arrive.
            return Evaluation { time: limits.time, ..Evaluation::default() };
        };
        Evaluation {
            arrived: outcome.arrived,
            time: outcome.time,
            deviation: outcome.max_deviation,
            samples: Channel::ALL
                .map(|channel| controller.belief().channel(channel).sample_statistics()),
        }
    }

    /// Takes in the evaluations of [`Evolution::jobs`], in their order, and goes on. Returns the generation that
    /// ended with it, if one did.
    ///
    /// # Errors
    /// Where there are more or fewer than jobs; nothing has happened then.
    pub fn tell(&mut self, evaluations: &[Evaluation]) -> Result<Option<Generation>, TellError> {
        let (subjects, trials) = self.sizes();
        let asked = subjects * self.settings.environments.len() * trials;
        if evaluations.len() != asked {
            return Err(TellError { given: evaluations.len(), asked });
        }
        self.state.episodes += evaluations.len() as u64;
        if let (Some(arrivals), Stage::Reference | Stage::Generations { .. }) =
            (&mut self.state.arrivals, self.state.stage)
        {
            *arrivals += evaluations.iter().filter(|it| it.arrived).count() as u64;
        }
        match self.state.stage {
            _ if self.state.hopeless.is_some() => {}
            Stage::Reference => {
                self.state.units = self.measure_units(evaluations);
                self.state.stage = Stage::Generations { generation: 0 };
            }
            Stage::Generations { generation } => {
                let summary = self.end_generation(generation, evaluations);
                self.give_up_where_nobody_arrives(generation);
                return Ok(Some(summary));
            }
            Stage::Selection => {
                let fitness = self.fitness(self.state.candidates.len(), evaluations);
                self.state.champion =
                    Some(self.state.candidates[genetic::ranking(&fitness)[0]].clone());
                self.state.stage = Stage::Report;
            }
            Stage::Report => {
                self.state.hopeless = self.champion_fails(evaluations);
                if self.state.hopeless.is_none() {
                    self.state.report = Some(self.make_report(evaluations));
                    self.state.stage = Stage::Done;
                }
            }
            Stage::Done => {}
        }
        Ok(None)
    }

    /// Mean fitness of fixed-normal in each environment, or what just keeps the limits where it has none.
    fn measure_units(&self, evaluations: &[Evaluation]) -> Vec<f64> {
        let EvolutionSettings { environments, limits, .. } = &self.settings;
        let chunks = evaluations.chunks_exact(REFERENCE_TRIALS);
        let units = environments.iter().zip(chunks).map(|(environment, trials)| {
            let fitness = trials.iter().map(|trial| environment.fitness.of(limits, trial));
            let mean = fitness.sum::<f64>() / trials.len() as f64;
            if mean > 0.0 { mean } else { environment.fitness.at_limit(limits) }
        });
        units.collect()
    }

    /// Fitness of one episode in an environment; 1 is that of fixed-normal.
    fn normalised(&self, environment: usize, evaluation: &Evaluation) -> f64 {
        let fitness = self.settings.environments[environment].fitness;
        fitness.of(&self.settings.limits, evaluation) / self.state.units[environment]
    }

    /// Fitness of `subjects`: the weighted mean over environments of the mean over trials.
    fn fitness(&self, subjects: usize, evaluations: &[Evaluation]) -> Vec<f64> {
        let environments = &self.settings.environments;
        let trials = evaluations.len() / (subjects * environments.len());
        let total: f64 = environments.iter().map(|environment| environment.weight).sum();
        let of_subject = |evaluations: &[Evaluation]| {
            let chunks = evaluations.chunks_exact(trials).enumerate();
            let means = chunks.map(|(environment, trials)| {
                let sum: f64 = trials.iter().map(|it| self.normalised(environment, it)).sum();
                environments[environment].weight * sum / trials.len() as f64
            });
            means.sum::<f64>() / total
        };
        evaluations.chunks_exact(trials * environments.len()).map(of_subject).collect()
    }

    fn end_generation(&mut self, generation: usize, evaluations: &[Evaluation]) -> Generation {
        let drift = self.settings.controller.drift;
        let genes = genome::prior_genes(drift);
        let individuals = self.state.search.individuals();
        let fitness = self.fitness(individuals.len(), evaluations);
        let environments = &self.settings.environments;
        let summary =
            generation::summary(generation, environments, individuals, &fitness, evaluations);
        let order = genetic::ranking(&fitness);
        if generation == 0 {
            self.state.first_generation = Some(individuals[order[0]].clone());
        }
        let is_last = generation + 1 == self.settings.generations;
        let mut rng = seeds::rng(self.settings.seed, Purpose::Breed, generation);
        let mut candidates: Vec<Genome> = Vec::new();
        for index in order {
            let individual = &individuals[index];
            if candidates.len() < CANDIDATES && !candidates.contains(individual) {
                candidates.push(individual.clone());
            }
        }
        match &mut self.state.search {
            Search::Genetic { population } if !is_last => {
                let settings = &self.settings.genetic;
                *population = genetic::breed(&genes, settings, population, &fitness, &mut rng);
            }
            Search::Genetic { .. } => {}
            Search::CmaEs { search, population } => {
                search.tell(&genes, population, &fitness);
                candidates.push(search.mean(&genes));
                if !is_last {
                    *population = search.ask(&genes, population.len(), &mut rng);
                }
            }
            Search::EmpiricalBayes { fitted: [fitted] } => {
                let groups: Vec<_> = evaluations.iter().map(|it| it.samples).collect();
                let seed = seeds::seed(self.settings.seed, Purpose::Breed, [generation, 0, 0]);
                *fitted = empirical_bayes::fit(&groups, fitted, seed);
                candidates = vec![fitted.clone()];
            }
        }
        self.state.stage = Stage::Generations { generation: generation + 1 };
        if is_last {
            self.state.candidates = candidates;
            self.state.stage = match &self.state.candidates[..] {
                [only] => {
                    self.state.champion = Some(only.clone());
                    Stage::Report
                }
                _ => Stage::Selection,
            };
        }
        summary
    }

    /// Gives up after some generations in which, as before them, nobody has arrived.
    fn give_up_where_nobody_arrives(&mut self, generation: usize) {
        let enough = HOPELESS_GENERATIONS.min(self.settings.generations);
        if self.state.arrivals == Some(0) && generation + 1 >= enough {
            let environments = hopeless::names(&self.settings.environments);
            self.state.hopeless =
                Some(Hopeless::NobodyArrives { environments, episodes: self.state.episodes });
        }
    }

    /// Why the champion, whose trials are the first of the report, is of no use.
    fn champion_fails(&self, evaluations: &[Evaluation]) -> Option<Hopeless> {
        let EvolutionSettings { environments, limits, report_trials, .. } = &self.settings;
        let trials = report_trials * environments.len();
        let champion = evaluations.get(..trials)?;
        let fits = |(environment, trials): (&TrainingEnvironment, &[Evaluation])| {
            trials.iter().any(|it| environment.fitness.of(limits, it) > 0.0)
        };
        if environments.iter().zip(champion.chunks_exact(*report_trials)).any(fits) {
            return None;
        }
        let arrived = champion.iter().filter(|it| it.arrived).count() as f64 / trials as f64;
        Some(Hopeless::ChampionFails {
            environments: hopeless::names(environments),
            trials,
            arrived,
        })
    }

    /// Who is reported, the champion first.
    fn reported(&self) -> [(&'static str, Prior); 4] {
        let weak = Prior::default();
        let known = |genome: &Option<Genome>| genome.as_deref().map_or(weak, genome::to_prior);
        [
            ("champion", known(&self.state.champion)),
            ("first-generation", known(&self.state.first_generation)),
            ("default", weak),
            ("flat", Prior::flat()),
        ]
    }

    fn make_report(&self, evaluations: &[Evaluation]) -> Report {
        let environments = &self.settings.environments;
        let trials = self.settings.report_trials;
        let subjects = evaluations.chunks_exact(trials * environments.len());
        let driven = self.reported().into_iter().zip(subjects).map(|((name, prior), subject)| {
            let of_environment = |(environment, trials): (usize, &[Evaluation])| {
                let trial = |it: &Evaluation| {
                    (self.normalised(environment, it), it.time, it.deviation, it.arrived)
                };
                trials.iter().map(trial).collect()
            };
            let environments = subject.chunks_exact(trials).enumerate().map(of_environment);
            Driven { name, prior, environments: environments.collect() }
        });
        report::report(environments, driven.collect())
    }
}

#[cfg(test)]
mod tests;
