//! What must outlive the process: robots with their tasks and what they learned, priors, environments, jobs.
//!
//! A job is something that the server does in the background: its record, the parts that it leaves behind one by one,
//! and the checkpoint from which it goes on. The server holds all of it but parts and checkpoints in memory, so a store is read once, at the start, and
//! written on every change that is acknowledged. Calls may block; the server makes them off its async threads
//! (`keeper`). The form in which things are stored belongs to the store.

pub(crate) mod document;
mod job_id;
mod keeper;
mod memory;
mod record;
mod sqlite;
mod stop_journal;
mod stop_keeper;
mod unreadable;

pub use job_id::{JobId, StoredKind};
pub(crate) use keeper::Keeper;
pub use memory::MemoryStore;
pub use record::{
    Contents, Part, Posterior, Record, StoredEnvironment, StoredJob, StoredPrior, StoredRobot, Told,
};

pub use sqlite::{
    Backup, BackupError, Checked, DATA_FILE, Damage, LOCK_FILE, OpenError, SqliteStore, backup,
    check,
};
pub use stop_journal::STOPS_FILE;
pub(crate) use stop_journal::{Entry, Word, Words, open as stop_journal};
pub(crate) use stop_keeper::StopKeeper;
pub use unreadable::Unreadable;
pub(crate) use unreadable::{Kind, Unreadables};

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
    /// Keeps a job, in place of the one of that id; its parts and its checkpoint stay. Its number counts as used from
    /// then on, even when it is forgotten again: [`Contents::last_number`].
    PutJob(StoredJob),
    /// Forgets a job with its parts and its checkpoint; nothing where it is not kept.
    DeleteJob(JobId),
    /// Keeps one part of a job, in place of the one of that index; nothing where the job is not kept.
    PutPart {
        /// The job.
        job: JobId,
        /// Which one.
        index: usize,
        /// JSON, of which the store knows nothing.
        body: String,
    },
    /// Keeps the checkpoint of a job, in place of the one before; nothing where the job is not kept.
    PutCheckpoint {
        /// The job.
        job: JobId,
        /// JSON, of which the store knows nothing.
        body: String,
    },
    /// Forgets the checkpoint of a job; nothing where there is none.
    DeleteCheckpoint(JobId),
}

/// Keeps what must outlive the process. A call that returns `Ok` has taken full effect, one that fails has taken none.
pub trait Store: Send + Sync + 'static {
    /// Makes `changes` in their order, all or none of them. Once this returns `Ok` they outlive whatever happens to
    /// the process and, where the store is on a disk, to the machine.
    ///
    /// # Errors
    /// Where they cannot be made; everything stays as it was.
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError>;

    /// Everything that is kept but parts and checkpoints.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn load(&self) -> Result<Contents, StoreError>;

    /// The parts of a job from index `from` on, at most `limit`, in order; none where it is not kept.
    ///
    /// # Errors
    /// Where they cannot be read.
    fn parts(&self, job: JobId, from: usize, limit: usize) -> Result<Vec<Part>, StoreError>;

    /// The checkpoint of a job.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn checkpoint(&self, job: JobId) -> Result<Option<String>, StoreError>;

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
