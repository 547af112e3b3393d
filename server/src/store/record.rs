//! What is kept, as the server sees it.

use super::Change;
use umwelt_api::RobotId;
use umwelt_core::controller::Saved;
use umwelt_core::controller::settings::{Prior, Settings};
use umwelt_core::controller::task::Task;

/// What is kept of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What its controller was told.
    pub settings: Settings,
    /// Name of the prior in the settings; none where its values were given.
    pub prior: Option<String>,
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
    /// What somebody wrote about it.
    pub note: Option<String>,
    /// Where it comes from.
    pub source: PriorSource,
}

/// Where a prior comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum PriorSource {
    /// Somebody put it.
    Put,
    /// It is the champion of an evolution.
    Evolution {
        /// Id of the evolution, which may be gone by now.
        evolution: String,
        /// Its seed.
        seed: u64,
        /// Its optimizer, by name.
        optimizer: String,
        /// The champion's fitness on fresh seeds.
        fitness: f64,
    },
}

/// A named simulated environment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredEnvironment {
    /// Its name.
    pub name: String,
    /// JSON, of which the store knows nothing.
    pub body: String,
}

/// An evolution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredEvolution {
    /// Its id.
    pub id: String,
    /// Its number: greater than that of every evolution before it, and never used again.
    pub number: u64,
    /// Whether it has ended, in whatever way: such a one may be [pruned](prune).
    pub finished: bool,
    /// JSON, of which the store knows nothing.
    pub body: String,
}

/// One generation of an evolution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Generation {
    /// Which one.
    pub index: usize,
    /// JSON, of which the store knows nothing.
    pub body: String,
}

/// Everything that is kept but generations and checkpoints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Robots, in the order of their ids.
    pub robots: Vec<StoredRobot>,
    /// Priors, in the order of their names.
    pub priors: Vec<StoredPrior>,
    /// Environments, in the order of their names.
    pub environments: Vec<StoredEnvironment>,
    /// Evolutions, in the order of their numbers.
    pub evolutions: Vec<StoredEvolution>,
    /// Highest number that an evolution ever had; 0 before the first.
    pub last_evolution: u64,
}

/// The changes that forget the oldest finished ones of `evolutions` so that `keep` finished ones remain.
pub fn prune(evolutions: &[StoredEvolution], keep: usize) -> Vec<Change> {
    let mut finished: Vec<_> = evolutions.iter().filter(|evolution| evolution.finished).collect();
    finished.sort_by_key(|evolution| evolution.number);
    let excess = finished.len().saturating_sub(keep);
    let forget = finished.into_iter().take(excess);
    forget.map(|evolution| Change::DeleteEvolution(evolution.id.clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bug to fear: a running evolution, or a recent one, goes instead of an old one.
    #[test]
    fn the_oldest_finished_evolutions_are_pruned() {
        let evolution = |number: u64, finished| StoredEvolution {
            id: format!("evolution-{number}"),
            number,
            finished,
            body: String::new(),
        };
        let all =
            [(10, true), (9, true), (1, false), (2, true)].map(|(n, done)| evolution(n, done));
        let forgets = |keep| -> Vec<String> {
            let changes = prune(&all, keep).into_iter();
            changes.map(|change| format!("{change:?}")).collect()
        };
        assert_eq!(
            forgets(1),
            [r#"DeleteEvolution("evolution-2")"#, r#"DeleteEvolution("evolution-9")"#]
        );
        assert_eq!(forgets(3), [""; 0]);
        assert_eq!(forgets(0).len(), 3);
    }
}
