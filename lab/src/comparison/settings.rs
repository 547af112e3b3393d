//! The settings of a comparison: contenders, environments, task, trials, seed.

use super::contender::Contender;
use super::environment::Environment;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::Pose;
use umwelt_core::horizon::MAX_SLOTS;
use umwelt_core::link::LinkError;
use umwelt_core::plant::PlantError;
use umwelt_core::settings::Settings;
use umwelt_core::task::Task;

/// Most contenders of one comparison.
pub const MAX_CONTENDERS: usize = 64;
/// Most environments.
pub const MAX_ENVIRONMENTS: usize = 16;
/// Most trials of a contender in an environment.
pub const MAX_TRIALS: usize = 10_000;
/// Most episodes (contenders x environments x trials): the results of each are held until the end, some 20 MB.
pub const MAX_EPISODES: u64 = 200_000;

/// The settings of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonSettings {
    /// The scenario's name.
    pub scenario: String,
    /// Who is compared, 1..=[`MAX_CONTENDERS`] of different labels.
    pub contenders: Vec<Contender>,
    /// Where, 1..=[`MAX_ENVIRONMENTS`] of different names.
    pub environments: Vec<Environment>,
    /// The settings of every contender's controller; method, prior and slots are its own.
    pub controller: Settings,
    /// What is driven.
    pub task: Task,
    /// Where the robot stands.
    pub start: Pose,
    /// Time in s after the calibration beyond which a robot counts as not arrived.
    pub time_limit: f64,
    /// Trials of each contender in each environment, 2..=[`MAX_TRIALS`].
    pub trials: usize,
    /// Of everything random.
    pub seed: u64,
}

/// Why a comparison cannot run. The contract checks each field and names all that are wrong; this is the last line.
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
    /// Two contenders or two environments have one name.
    #[error("{0} is named twice")]
    NamedTwice(String),
    /// The time limit is no time.
    #[error("time_limit is {0}, it must be positive and finite")]
    TimeLimit(f64),
    /// An environment's link means nothing.
    #[error("environment {0}: {1}")]
    Link(String, LinkError),
    /// An environment's robot means nothing.
    #[error("environment {0}: {1}")]
    Plant(String, PlantError),
    /// There is nowhere to drive.
    #[error("the task has no waypoint")]
    NoWaypoint,
}

impl ComparisonSettings {
    /// The comparison's task in one of its environments, driven by a controller of these `settings`.
    pub fn episode(&self, environment: &Environment, settings: Settings) -> Scenario {
        Scenario {
            settings,
            plant: environment.plant,
            link: environment.link.clone(),
            task: self.task.clone(),
            start: self.start,
            region: environment.region.clone(),
            frame: umwelt_core::episode::FRAME,
            time_limit: self.time_limit,
        }
    }

    /// Episodes that are compared.
    pub fn compared_episodes(&self) -> u64 {
        [self.contenders.len(), self.environments.len(), self.trials]
            .iter()
            .fold(1, |all, count| all.saturating_mul(*count as u64))
    }

    /// Whether there are environments to distinguish. Where one changes on the way there is no right one.
    pub fn tells_apart(&self) -> bool {
        self.environments.len() > 1 && self.environments.iter().all(|it| it.region.is_none())
    }

    /// Whether a comparison can run.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), SettingsError> {
        let count = |field, value: u64, low, high| {
            let is_in = (low..=high).contains(&value);
            if is_in { Ok(()) } else { Err(SettingsError::Count { field, value, low, high }) }
        };
        let Self { contenders, environments, .. } = self;
        count("contenders", contenders.len() as u64, 1, MAX_CONTENDERS as u64)?;
        count("environments", environments.len() as u64, 1, MAX_ENVIRONMENTS as u64)?;
        count("trials", self.trials as u64, 2, MAX_TRIALS as u64)?;
        let episodes = self.compared_episodes();
        count("contenders x environments x trials", episodes, 1, MAX_EPISODES)?;
        for contender in contenders {
            count("slots", contender.slots as u64, 1, MAX_SLOTS as u64)?;
        }
        let labels = contenders.iter().map(Contender::label).collect::<Vec<_>>();
        let names = environments.iter().map(|it| it.name.clone()).collect::<Vec<_>>();
        for names in [labels, names] {
            for (index, name) in names.iter().enumerate() {
                if names[..index].contains(name) {
                    return Err(SettingsError::NamedTwice(name.clone()));
                }
            }
        }
        if !(self.time_limit > 0.0 && self.time_limit.is_finite()) {
            return Err(SettingsError::TimeLimit(self.time_limit));
        }
        for it in environments {
            let of_link = |error| SettingsError::Link(it.name.clone(), error);
            it.link.validate().map_err(of_link)?;
            it.region.as_ref().map_or(Ok(()), |region| region.link.validate()).map_err(of_link)?;
            it.plant.validate().map_err(|error| SettingsError::Plant(it.name.clone(), error))?;
        }
        if self.task.waypoints.is_empty() {
            return Err(SettingsError::NoWaypoint);
        }
        Ok(())
    }
}
