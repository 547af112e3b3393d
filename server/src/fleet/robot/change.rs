//! A change of what a robot is or does: other settings, or another task.
//!
//! It is one value, and made in a controller by one function. What is kept of the robot after a change is foretold by
//! making it in a copy ([`Snapshot::saved_after`]); then the robot's own task makes the same.
//!
//! [`Snapshot::saved_after`]: super::Snapshot::saved_after

use crate::store::{Record, Told};
use umwelt_core::controller::Controller;
use umwelt_core::task::Task;

/// A change of what a robot is or does.
#[derive(Clone, Debug)]
pub(crate) enum RobotChange {
    /// New settings.
    Told(Box<Told>),
    /// A task in place of the one before, or none any more.
    Task(Option<Task>),
}

impl RobotChange {
    /// Makes it in a controller.
    pub(super) fn apply(&self, controller: &mut Controller) {
        match self {
            Self::Told(told) => controller.replace_settings(told.settings),
            Self::Task(Some(task)) => controller.set_task(task.clone()),
            Self::Task(None) => controller.cancel_task(),
        }
    }

    /// What is kept of a robot after it, where that was `before`.
    pub(crate) fn kept(&self, before: Record, revision: u64) -> Record {
        match self.clone() {
            Self::Told(told) => Record { told: *told, revision, ..before },
            Self::Task(task) => Record { task, revision, ..before },
        }
    }
}
