//! What is kept, as the server sees it.

use super::job_id::{JobId, StoredKind};
use super::unreadable::Unreadable;
use std::collections::BTreeMap;
use umwelt_api::RobotId;
use umwelt_api::prior::Source;
use umwelt_api::robot::{Description, Spec};
use umwelt_core::controller::Saved;
use umwelt_core::settings::{Prior, Settings};
use umwelt_core::task::Task;

/// What the controller of a robot was told.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// All of it.
    pub settings: Settings,
    /// Name of the prior in the settings; none where its values were given.
    pub prior: Option<String>,
    /// What of the settings was said; the rest is default, or followed from it.
    pub said: Description,
}

impl Told {
    /// All of these settings, said.
    pub fn all(settings: Settings) -> Self {
        let said = Description::from(&Spec::from(&settings));
        Self { settings, prior: None, said }
    }
}

/// What is kept of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What its controller was told.
    pub told: Told,
    /// Where it is to go.
    pub task: Option<Task>,
    /// Whether it is to rest until it is resumed: a restart must not set it in motion.
    pub stopped: bool,
    /// Another one with each change of settings or task. What a robot has learned counts only under the revision
    /// under which it was learned.
    pub revision: u64,
}

/// What a robot has learned and how far it has got, at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// The revision of the robot's record under which it was learned.
    pub revision: u64,
    /// What of its controller outlives a restart.
    pub saved: Saved,
}

/// A robot that is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredRobot {
    /// Its id.
    pub id: RobotId,
    /// What was said about it.
    pub record: Record,
    /// What it has learned under that record, where it can be taken up.
    pub saved: Option<Saved>,
}

/// A named prior.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredPrior {
    /// Its name.
    pub name: String,
    /// Its values.
    pub prior: Prior,
    /// What someone wrote about it.
    pub note: Option<String>,
    /// Where it comes from.
    pub source: Source,
}

/// A named simulated environment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredEnvironment {
    /// Its name.
    pub name: String,
    /// JSON, of which the store knows nothing.
    pub body: String,
}

/// A job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredJob {
    /// Which one.
    pub id: JobId,
    /// Whether it has ended, in whatever way.
    pub finished: bool,
    /// JSON, of which the store knows nothing.
    pub body: String,
}

/// One part of a job: a generation of an evolution, a distribution of a comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which one.
    pub index: usize,
    /// JSON, of which the store knows nothing.
    pub body: String,
}

/// Everything that is kept but parts and checkpoints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Robots, in the order of their ids.
    pub robots: Vec<StoredRobot>,
    /// Priors, in the order of their names.
    pub priors: Vec<StoredPrior>,
    /// Environments, in the order of their names.
    pub environments: Vec<StoredEnvironment>,
    /// Jobs, kind by kind in the order of their numbers.
    pub jobs: Vec<StoredJob>,
    /// What cannot be read, and stays as it is until someone puts another in its place or removes it.
    pub unreadable: Vec<Unreadable>,
    /// Highest number that a job of each kind ever had; a kind that never had one may be missing.
    pub last_numbers: BTreeMap<StoredKind, u64>,
}

impl Contents {
    /// The jobs of one kind, in the order of their numbers.
    pub fn jobs_of(&self, kind: StoredKind) -> impl Iterator<Item = &StoredJob> {
        self.jobs.iter().filter(move |job| job.id.kind == kind)
    }

    /// Highest number that a job of this kind ever had; 0 before the first.
    pub fn last_number(&self, kind: StoredKind) -> u64 {
        self.last_numbers.get(&kind).copied().unwrap_or(0)
    }
}
