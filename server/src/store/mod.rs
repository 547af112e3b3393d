//! What must outlive the process: robots with their tasks and what they learned, priors, environments, evolutions.
//!
//! The server holds all of it but generations and checkpoints in memory, so a store is read once, at the start, and
//! written on every change that is acknowledged. Calls may block; the server makes them off its async threads
//! (`keeper`). The form in which things are stored belongs to the store.

mod keeper;
mod memory;
mod record;
mod sqlite;

pub(crate) use keeper::Keeper;
pub use memory::MemoryStore;
pub use record::{
    Contents, Generation, Posterior, PriorSource, Record, StoredEnvironment, StoredEvolution,
    StoredPrior, StoredRobot, prune,
};

pub use sqlite::{Backup, BackupError, DATA_FILE, LOCK_FILE, OpenError, SqliteStore, backup};

use umwelt_api::RobotId;

/// Why a store did not do what it was asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError {
    /// It cannot now; the same call may succeed later.
    #[error("the store is unavailable: {0}")]
    Unavailable(String),
    /// What it holds is damaged.
    #[error("the store is damaged: {0}")]
    Damaged(String),
    /// This one thing cannot be stored, whatever state the store is in.
    #[error("the store cannot keep this: {0}")]
    Rejected(String),
}

/// One change of what is kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Keeps a robot, in place of the record before. Where the [revision](Record::revision) is another one, what it
    /// has learned is forgotten.
    PutRobot(RobotId, Box<Record>),
    /// Forgets a robot and what it has learned; nothing where it is not kept.
    DeleteRobot(RobotId),
    /// Keeps what a robot has learned. Nothing where the robot is not kept or has another revision: it was learned
    /// under other settings or another task then.
    PutPosterior(RobotId, Box<Posterior>),
    /// Keeps a prior, in place of the one of that name.
    PutPrior(StoredPrior),
    /// Forgets a prior; nothing where it is not kept.
    DeletePrior(String),
    /// Keeps an environment, in place of the one of that name.
    PutEnvironment(StoredEnvironment),
    /// Forgets an environment; nothing where it is not kept.
    DeleteEnvironment(String),
    /// Keeps an evolution, in place of the one of that id; its generations and its checkpoint stay. Its number counts
    /// as used from then on, even when it is forgotten again: [`Contents::last_evolution`].
    PutEvolution(StoredEvolution),
    /// Forgets an evolution with its generations and its checkpoint; nothing where it is not kept.
    DeleteEvolution(String),
    /// Keeps one generation of an evolution, in place of the one of that index; nothing where the evolution is not
    /// kept.
    PutGeneration {
        /// Id of the evolution.
        evolution: String,
        /// Which one.
        index: usize,
        /// JSON, of which the store knows nothing.
        body: String,
    },
    /// Keeps the checkpoint of an evolution, in place of the one before; nothing where the evolution is not kept.
    PutCheckpoint {
        /// Id of the evolution.
        evolution: String,
        /// JSON, of which the store knows nothing.
        body: String,
    },
    /// Forgets the checkpoint of an evolution; nothing where there is none.
    DeleteCheckpoint(String),
}

/// Keeps what must outlive the process. A call that returns `Ok` has taken full effect, one that fails has taken none.
pub trait Store: Send + Sync + 'static {
    /// Makes `changes` in their order, all or none of them. Once this returns `Ok` they outlive whatever happens to
    /// the process and, where the store is on a disk, to the machine.
    ///
    /// # Errors
    /// Where they cannot be made; everything stays as it was.
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError>;

    /// Everything that is kept but generations and checkpoints.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn load(&self) -> Result<Contents, StoreError>;

    /// The generations of an evolution from index `from` on, at most `limit`, in order; none where it is not kept.
    ///
    /// # Errors
    /// Where they cannot be read.
    fn generations(
        &self,
        evolution: &str,
        from: usize,
        limit: usize,
    ) -> Result<Vec<Generation>, StoreError>;

    /// The checkpoint of an evolution.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn checkpoint(&self, evolution: &str) -> Result<Option<String>, StoreError>;

    /// Whether something could be kept now: tries it as `commit` does, and changes nothing.
    ///
    /// # Errors
    /// As `commit`.
    fn probe(&self) -> Result<(), StoreError> {
        self.commit(Vec::new())
    }

    /// Tidies up before the process ends; nothing is lost where it is not called.
    ///
    /// # Errors
    /// Where that fails.
    fn settle(&self) -> Result<(), StoreError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
