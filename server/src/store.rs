//! What must outlive the process: robots with what was said about them, and their tasks.
//!
//! The fleet holds every robot in memory, so a store is read once, at the start, and written on every change that
//! is acknowledged. Calls may block; the server makes them off its async threads, one at a time per robot.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use umwelt_api::RobotId;
use umwelt_core::controller::settings::Settings;
use umwelt_core::controller::task::Task;

/// What is kept of one robot. The form in which it is stored belongs to the store.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What its controller was told.
    pub settings: Settings,
    /// Where it is to go.
    pub task: Option<Task>,
    /// Whether it is to rest until it is resumed: a restart must not set it in motion.
    pub stopped: bool,
}

/// Why a store did not do what it was asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError {
    /// It cannot now; the same call may succeed later.
    #[error("the store is unavailable: {0}")]
    Unavailable(String),
    /// What it holds is damaged.
    #[error("the store is damaged: {0}")]
    Damaged(String),
}

/// Keeps robots. A call that returns `Ok` has taken full effect, one that fails has taken none.
pub trait Store: Send + Sync + 'static {
    /// Keeps `record` for `robot`, in place of the one before.
    ///
    /// # Errors
    /// Where it cannot be kept; the record before stays.
    fn put(&self, robot: &RobotId, record: &Record) -> Result<(), StoreError>;

    /// Everything that is kept, in the order of the ids.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn list(&self) -> Result<Vec<(RobotId, Record)>, StoreError>;

    /// Forgets `robot`; nothing where it is not kept.
    ///
    /// # Errors
    /// Where it cannot be forgotten; the record stays.
    fn delete(&self, robot: &RobotId) -> Result<(), StoreError>;
}

/// Keeps robots as long as the process lives.
#[derive(Debug, Default)]
pub struct MemoryStore(Mutex<BTreeMap<RobotId, Record>>);

impl Store for MemoryStore {
    fn put(&self, robot: &RobotId, record: &Record) -> Result<(), StoreError> {
        self.records().insert(robot.clone(), record.clone());
        Ok(())
    }

    fn list(&self) -> Result<Vec<(RobotId, Record)>, StoreError> {
        Ok(self.records().iter().map(|(id, record)| (id.clone(), record.clone())).collect())
    }

    fn delete(&self, robot: &RobotId) -> Result<(), StoreError> {
        self.records().remove(robot);
        Ok(())
    }
}

impl MemoryStore {
    fn records(&self) -> std::sync::MutexGuard<'_, BTreeMap<RobotId, Record>> {
        // No call panics between two changes, so a poisoned map is whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
