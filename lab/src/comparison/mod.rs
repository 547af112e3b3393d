//! Methods compared: contenders x environments x trials, on the same seeds.
//!
//! [`Comparison`] is a state machine without a clock, a thread or a file, as
//! [`Evolution`](crate::evolution::Evolution) is: [`Comparison::batch`] says which episodes are to be driven
//! now, [`Comparison::evaluate`] drives one, on whatever thread, [`Comparison::tell`] takes the evaluations in. Between two
//! `tell`s its whole state can be stored and taken up again: the report is the same, bit for bit.
//!
//! 1. *Reference*: on seeds of their own, how each environment shows in the samples, so that it can be said when a
//!    contender recognises the right one.
//! 2. *Trials*: every contender drives the same seeds (common random numbers): the same slots are late for each, the
//!    same cells of the floor slip.
//! 3. *Report*: distributions, differences to `statistic` paired by seed, with bootstrap intervals.
//!
//! ```
//! use umwelt_lab::comparison::{Comparison, ComparisonSettings};
//! let thesis = ComparisonSettings::scenario("thesis").ok_or("no such scenario")?;
//! let mut comparison = Comparison::new(ComparisonSettings { trials: 2, ..thesis })?;
//! while comparison.report().is_none() {
//!     let evaluate = |episode: &_| Comparison::evaluate(comparison.settings(), episode);
//!     let evaluations: Vec<_> = comparison.batch().iter().map(evaluate).collect();
//!     comparison.tell(&evaluations)?;
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod beliefs;
mod bootstrap;
mod contender;
mod coverage;
mod environment;
mod episode;
mod oracle;
mod quantities;
mod report;
mod scenario;
mod settings;
mod signature;
mod work;

pub use contender::{Approach, BASELINE, CHAMPION, Contender, method_names};
pub use coverage::{Coverage, SAMPLES_BEFORE};
pub use environment::Environment;
pub use episode::{Distribution, Episode, Evaluation, Trial};
pub use quantities::{LEVEL, Quantities};
pub use report::{
    Claim, Difference, Entry, EnvironmentReport, PROMISED_DEVIATION, PROMISED_TIME, Recognition,
    Report, Summary,
};
pub use scenario::{SCENARIOS, TRIALS};
pub use settings::{
    ComparisonSettings, MAX_CONTENDERS, MAX_ENVIRONMENTS, MAX_EPISODES, MAX_TRIALS, SettingsError,
};
pub use signature::EnvironmentSignature;

use crate::evolution::TellError;
use crate::seeds::{self, Purpose};
use episode::Driver;
use serde::{Deserialize, Serialize};

/// Version of the stored state; a state of another version is not taken up.
pub const STATE_VERSION: u32 = 1;

/// Episodes of each environment that say how it shows in the samples.
pub const REFERENCE_TRIALS: usize = 20;

/// Episodes of a batch, at least, about: some seconds, which is what a restart costs.
const BATCH: usize = 2000;

/// Batches at most, about: after each the whole state is kept.
const BATCHES: usize = 20;

/// How far a comparison has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// It is measured how each environment shows in the samples.
    Reference,
    /// Contenders drive.
    Trials {
        /// Trials that all have driven.
        done: usize,
    },
    /// There is a report.
    Done,
}

/// A comparison: settings, and how far it has got.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    settings: ComparisonSettings,
    state: State,
}

/// How far a comparison has got: what is stored between two `tell`s, beside its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    version: u32,
    stage: Stage,
    /// How each environment shows in the samples, by number of slots; empty where that is not asked.
    known: Vec<Known>,
    /// Of each environment and contender, in that order.
    cells: Vec<Vec<Trial>>,
    episodes: u64,
    report: Option<Report>,
}

/// How the environments show in the samples of a robot that is sent so many slots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Known {
    slots: usize,
    environments: Vec<EnvironmentSignature>,
}

impl Comparison {
    /// A comparison that has not begun.
    ///
    /// # EnvironmentSignature
    /// The first thing that is wrong with the settings.
    pub fn new(settings: ComparisonSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        let cells = settings.environments.len() * settings.contenders.len();
        let state = State {
            version: STATE_VERSION,
            stage: Stage::Reference,
            known: Vec::new(),
            cells: vec![Vec::new(); cells],
            episodes: 0,
            report: None,
        };
        let mut comparison = Self { settings, state };
        if comparison.slots().is_empty() {
            comparison.state.stage = Stage::Trials { done: 0 };
        }
        Ok(comparison)
    }

    /// A comparison of these settings that goes on where another one of them was: the same as that one, bit for bit.
    ///
    /// # EnvironmentSignature
    /// The first thing that is wrong with the settings.
    pub fn resume(settings: ComparisonSettings, state: State) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self { settings, state })
    }

    /// How far it has got, to be stored.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Its settings.
    pub fn settings(&self) -> &ComparisonSettings {
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
        let reference = self.slots().len() * self.settings.environments.len() * REFERENCE_TRIALS;
        reference as u64 + self.settings.compared_episodes()
    }

    /// The report, once it is done.
    pub fn report(&self) -> Option<&Report> {
        self.state.report.as_ref()
    }

    /// Every trial so far, environment by environment, contender by contender.
    pub fn distributions(&self) -> Vec<Distribution> {
        let ComparisonSettings { environments, contenders, .. } = &self.settings;
        let places = environments.iter().flat_map(|environment| {
            contenders.iter().map(move |contender| (environment.name.clone(), contender.label()))
        });
        let cells = places.zip(&self.state.cells);
        cells
            .map(|((environment, contender), trials)| Distribution {
                environment,
                contender,
                trials: trials.clone(),
            })
            .collect()
    }

    /// Numbers of slots of those who identify, where there are environments to distinguish.
    fn slots(&self) -> Vec<usize> {
        if !self.settings.tells_apart() {
            return Vec::new();
        }
        let identifying = self.settings.contenders.iter().filter(|it| it.approach.identifies());
        let mut slots: Vec<_> = identifying.map(|it| it.slots).collect();
        slots.sort_unstable();
        slots.dedup();
        slots
    }

    /// The episodes to drive now. Empty once done.
    pub fn batch(&self) -> Vec<Episode> {
        let ComparisonSettings { environments, contenders, seed, trials, .. } = &self.settings;
        let (purpose, drivers, trials): (_, Vec<_>, _) = match self.state.stage {
            Stage::Reference => {
                let reference = |slots| (Driver::Reference { slots }, &[][..]);
                let drivers = self.slots().into_iter().map(reference).collect();
                (Purpose::Recognise, drivers, 0..REFERENCE_TRIALS)
            }
            Stage::Trials { done } => {
                let batch = BATCH.max(self.settings.compared_episodes() as usize / BATCHES);
                let batch = (batch / (environments.len() * contenders.len())).max(1);
                let drivers = contenders.iter().enumerate().map(|(index, contender)| {
                    let known = self.state.known.iter().find(|it| it.slots == contender.slots);
                    let known = known.map_or(&[][..], |known| &known.environments);
                    (Driver::Contender { index }, known)
                });
                (Purpose::Compare, drivers.collect(), done..(done + batch).min(*trials))
            }
            Stage::Done => return Vec::new(),
        };
        let of_trial = |trial| {
            let drivers = &drivers;
            (0..environments.len()).flat_map(move |environment| {
                // Common random numbers: no seed depends on the contender.
                let seed = seeds::seed(*seed, purpose, [environment, trial, 0]);
                drivers.iter().map(move |(driver, known)| {
                    let (driver, known) = (*driver, known.to_vec());
                    Episode { driver, environment, seed, known }
                })
            })
        };
        trials.flat_map(of_trial).collect()
    }

    /// Drives one episode of [`Comparison::batch`] of a comparison of these settings. The same episode gives the same
    /// evaluation, bit for bit, on any thread and in any process.
    pub fn evaluate(settings: &ComparisonSettings, episode: &Episode) -> Evaluation {
        let reference;
        let contender = match episode.driver {
            Driver::Contender { index } => &settings.contenders[index],
            Driver::Reference { slots } => {
                reference = Contender {
                    name: BASELINE.to_owned(),
                    approach: Approach::Statistic,
                    slots,
                    prior: settings.controller.prior,
                };
                &reference
            }
        };
        let told = contender.settings(&settings.controller);
        let scenario = settings.episode(&settings.environments[episode.environment], told);
        let Episode { known, environment, seed, .. } = episode;
        let (trial, samples) = contender.drive(scenario, known, *environment, *seed);
        Evaluation { trial, samples }
    }

    /// Takes in the evaluations of [`Comparison::batch`], in their order, and goes on.
    ///
    /// # EnvironmentSignature
    /// Where there are more or fewer than episodes; nothing has happened then.
    pub fn tell(&mut self, evaluations: &[Evaluation]) -> Result<(), TellError> {
        let asked = self.batch().len();
        if evaluations.len() != asked {
            return Err(TellError { given: evaluations.len(), asked });
        }
        self.state.episodes += evaluations.len() as u64;
        let environments = self.settings.environments.len();
        match self.state.stage {
            Stage::Reference => {
                let slots = self.slots();
                let of_place = |place: usize| -> Vec<_> {
                    let places = environments * slots.len();
                    evaluations.iter().skip(place).step_by(places).map(|it| it.samples).collect()
                };
                let known = slots.iter().enumerate().map(|(subject, &slots_sent)| Known {
                    slots: slots_sent,
                    environments: (0..environments)
                        .map(|environment| {
                            EnvironmentSignature::of(&of_place(environment * slots.len() + subject))
                        })
                        .collect(),
                });
                self.state.known = known.collect();
                self.state.stage = Stage::Trials { done: 0 };
            }
            Stage::Trials { done } => {
                let cells = self.state.cells.len();
                for batch in evaluations.chunks_exact(cells) {
                    for (cell, evaluation) in self.state.cells.iter_mut().zip(batch) {
                        cell.push(evaluation.trial);
                    }
                }
                let done = done + evaluations.len() / cells;
                self.state.stage = Stage::Trials { done };
                if done == self.settings.trials {
                    self.state.report = Some(report::report(&self.settings, &self.state.cells));
                    self.state.stage = Stage::Done;
                }
            }
            Stage::Done => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
