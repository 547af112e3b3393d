//! Evolution of priors: individuals are priors, fitness is how well a controller drives with them in simulated
//! environments (thesis section 4.3 and 5.2).
//!
//! [`Evolution`] is a state machine without a clock, a thread or a file: [`Evolution::batch`] says which episodes are to
//! be driven now, [`Evolution::evaluate`] drives one of them, on whatever thread, and [`Evolution::tell`] takes the
//! evaluations in and goes on. Between two `tell`s its whole state can be stored and taken up again: the result is
//! the same, bit for bit, wherever the episodes are evaluated and in whatever order.
//!
//! 1. *Reference*: fixed-normal drives each environment; its mean fitness becomes the unit there.
//! 2. *Generations*: every individual drives the same seeds (common random numbers), fresh ones each generation.
//!    Fitness is the weighted mean over the environments and never carried over.
//! 3. *Selection*: the ten fittest of the last generation drive fresh seeds; the best of them is the champion.
//! 4. *Report*: on third seeds, beside the best of the first generation, the weak default prior and a flat one.
//!
//! Where no robot arrives there is nothing to select by: it ends without a report and says why ([`Evolution::failure`]).
//!
//! ```
//! use umwelt_lab::evolution::{Evolution, EvolutionSettings};
//! let quick = EvolutionSettings::preset("quick").ok_or("no such preset")?;
//! let settings = EvolutionSettings { population: 4, generations: 2, report_trials: 2, ..quick };
//! let mut evolution = Evolution::new(settings)?;
//! while evolution.report().is_none() && evolution.failure().is_none() {
//!     let evaluate = |episode: &_| Evolution::evaluate(evolution.settings(), episode);
//!     let evaluations: Vec<_> = evolution.batch().iter().map(evaluate).collect();
//!     evolution.tell(&evaluations)?;
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod breeding;
mod cma_es;
mod empirical_bayes;
mod ending;
mod environment;
mod episode;
pub mod event_probability;
mod failure;
mod fitness;
mod generation;
mod genetic;
mod genome;
mod report;
mod search;
mod settings;
mod state;
mod work;

pub use environment::{
    ENVIRONMENTS, Fitness, FitnessLimits, SMALLEST_DEVIATION, TrainingEnvironment,
};
pub use episode::{Episode, Evaluation, TellError};
pub use failure::{Failure, GENERATIONS_WITHOUT_ARRIVAL};
pub use generation::{Generation, GenerationEnvironment, Spread};
pub use genetic::GeneticSettings;
pub use report::{Entry, EnvironmentResult, Estimate, LEVEL, Report};
pub use settings::{
    EvolutionSettings, MAX_BATCH, MAX_ENVIRONMENTS, MAX_EPISODES, MAX_EXPANSION, MAX_GENERATIONS,
    MAX_POPULATION, MAX_REPORT_TRIALS, MAX_SELECTION_TRIALS, MAX_TRIALS, Optimizer, PRESETS,
    SettingsError,
};
pub use state::{STATE_VERSION, Stage, State};

use crate::seeds::{self, Purpose};
use search::Search;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::Pose;
use umwelt_core::identification::estimate::Channel;
use umwelt_core::plant::PlantModel;
use umwelt_core::settings::{Method, PoseNoise, Prior, Settings};

/// Episodes of fixed-normal in each environment, whose mean fitness becomes the unit.
pub const REFERENCE_TRIALS: usize = 200;

/// Individuals of the last generation from whom the champion is chosen.
pub const CANDIDATES: usize = 10;

/// Time in s that an episode may take beyond `FitnessLimits::time`: the calibration takes about 20 s.
const CALIBRATION_TIME: f64 = 40.0;

/// An evolution: settings, and how far it has got.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolution {
    settings: EvolutionSettings,
    state: State,
}

impl Evolution {
    /// An evolution that has not begun.
    ///
    /// # Errors
    /// The first thing that is wrong with the settings.
    pub fn new(settings: EvolutionSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        let state = State::new(&settings);
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

    /// What was asked for.
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

    /// Its final result, once it is done.
    pub fn report(&self) -> Option<&Report> {
        self.state.report.as_ref()
    }

    /// Why it ends without a report, where it does.
    pub fn failure(&self) -> Option<&Failure> {
        self.state.failure.as_ref()
    }

    /// Subjects of the stage, and trials of each in each environment.
    fn sizes(&self) -> (usize, usize) {
        let settings = &self.settings;
        if self.state.failure.is_some() {
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

    /// The episodes to drive now: subject by subject, environment by environment, trial by trial. Empty once it has
    /// ended, with a report or without.
    pub fn batch(&self) -> Vec<Episode> {
        let (purpose, generation) = match self.state.stage {
            Stage::Reference => (Purpose::Reference, 0),
            Stage::Generations { generation } => (Purpose::Train, generation),
            Stage::Selection => (Purpose::Select, 0),
            Stage::Report => (Purpose::Report, 0),
            Stage::Done => return Vec::new(),
        };
        let (subjects, trials) = self.sizes();
        let environments = self.settings.environments.len();
        // Empirical Bayes learns from samples of the floor and the link alone.
        let fits = matches!(self.state.search, Search::EmpiricalBayes { .. });
        let is_noiseless = fits && matches!(self.state.stage, Stage::Generations { .. });
        let mut batch = Vec::with_capacity(subjects * environments * trials);
        for subject in 0..subjects {
            let (method, prior) = self.method(subject);
            for environment in 0..environments {
                // Common random numbers: no seed depends on the subject.
                batch.extend((0..trials).map(|trial| {
                    let place = [generation, environment, trial];
                    let seed = seeds::seed(self.settings.seed, purpose, place);
                    Episode { subject, method, prior, environment, is_noiseless, seed }
                }));
            }
        }
        batch
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

    /// Drives one episode of [`Evolution::batch`] of an evolution of these settings. The same episode gives the same
    /// evaluation, bit for bit, on any thread and in any process.
    pub fn evaluate(settings: &EvolutionSettings, episode: &Episode) -> Evaluation {
        let EvolutionSettings { controller, task, limits, environments, .. } = settings;
        let environment = &environments[episode.environment];
        let noise = if episode.is_noiseless { PoseNoise::NONE } else { controller.noise };
        let Episode { method, prior, .. } = *episode;
        let scenario = Scenario {
            settings: Settings { method, prior, noise, ..*controller },
            plant: PlantModel {
                drive: controller.drive,
                slip: environment.slip,
                noise,
                ..PlantModel::default()
            },
            link: environment.link.clone(),
            task: task.clone(),
            start: Pose::default(),
            region: None,
            frame: umwelt_core::episode::FRAME,
            time_limit: limits.time + CALIBRATION_TIME,
        };
        let Ok((outcome, controller)) = scenario.run_with(episode.seed, |_| {}) else {
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

    /// Takes in the evaluations of [`Evolution::batch`], in their order, and goes on. Returns the generation that
    /// ended with it, if one did.
    ///
    /// # Errors
    /// Where there are more or fewer than episodes; nothing has happened then.
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
            _ if self.state.failure.is_some() => {}
            Stage::Reference => {
                self.state.units = self.measure_units(evaluations);
                self.state.stage = Stage::Generations { generation: 0 };
            }
            Stage::Generations { generation } => {
                let summary = self.end_generation(generation, evaluations);
                self.give_up_without_arrivals(generation);
                return Ok(Some(summary));
            }
            Stage::Selection => {
                let fitness = self.fitness(self.state.candidates.len(), evaluations);
                self.state.champion =
                    Some(self.state.candidates[genetic::ranking(&fitness)[0]].clone());
                self.state.stage = Stage::Report;
            }
            Stage::Report => {
                self.state.failure = self.champion_fails(evaluations);
                if self.state.failure.is_none() {
                    self.state.report = Some(self.make_report(evaluations));
                    self.state.stage = Stage::Done;
                }
            }
            Stage::Done => {}
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests;
