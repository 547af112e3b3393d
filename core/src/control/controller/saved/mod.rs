//! What of a controller outlives a restart: what was learned, and how far the task has got.

use super::Controller;
use super::follows::Follows;
use super::plan::Phase;
use super::record::Record;
use crate::drive::{DriveBelief, DriveEstimate};
use crate::fusion::{Identified, NoiseBelief};
use crate::identification::Belief;
use crate::identification::estimate::Estimates;
use crate::settings::Settings;
use crate::task::{Stage, Task};
use crate::watch::{Kept, Watch};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What of a controller outlives a restart. It holds no time of the robot's clock: none is known to go on.
/// Its stored form is of version [`STATE_VERSION`](super::STATE_VERSION); one of another version is not taken up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    pub(super) belief: Belief,
    pub(super) phase: Phase,
    pub(super) record: Record,
    /// Left out where there is none: the stored form is then that of earlier versions.
    #[serde(default, skip_serializing_if = "Kept::is_none")]
    pub(super) watch: Kept,
    /// How late the drive follows; left out where that is described.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) drive: Option<Arc<DriveBelief>>,
    /// How noisy poses are; left out where that does not matter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) noise: Option<[Identified; 2]>,
}

impl Saved {
    /// What is believed.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// What was identified.
    pub fn estimates(&self) -> Estimates {
        self.belief.estimates(self.watch.rejects())
    }

    /// What is believed of how late the drive follows; none where that is described.
    pub fn drive_estimate(&self) -> Option<DriveEstimate> {
        Some(self.drive.as_ref()?.estimate())
    }

    /// The noise of positions and of headings as it is identified; none where that does not matter.
    pub fn noise(&self) -> Option<[Identified; 2]> {
        self.noise
    }

    /// Whether it can have been taken under `settings` and `task`: the belief is of that method with that prior,
    /// and what the robot is doing is a part of that task.
    pub fn fits(&self, settings: &Settings, task: Option<&Task>) -> bool {
        let Settings { method, prior, .. } = settings;
        let mut blank = self.belief.clone();
        blank.reset();
        blank == Belief::new(*method, prior, settings.uses_drift())
            && match task {
                None => self.phase == Phase::Idle && self.record == Record::default(),
                Some(task) => self.is_part_of(task),
            }
    }

    fn is_part_of(&self, task: &Task) -> bool {
        let legs = task.waypoints.len();
        let reached = self.record.progress(Stage::Idle, legs).leg;
        let is_phase_of = match self.phase {
            Phase::Idle => legs == 0 && task.check.is_none() && task.square.is_none(),
            Phase::Checking { .. } => task.check.is_some(),
            Phase::Squaring { .. } => task.square.is_some(),
            Phase::Ramping { .. } | Phase::Calibrating { .. } | Phase::Straight { .. } => {
                task.calibration.is_some()
            }
            Phase::Settling => true,
            Phase::Turning { leg, .. } | Phase::Driving { leg } | Phase::Stopping { leg, .. } => {
                leg < legs
            }
            Phase::Arrived => reached == legs,
        };
        is_phase_of && reached <= legs
    }
}

impl Controller {
    /// What of it outlives a restart.
    pub fn saved(&self) -> Saved {
        let (mut belief, mut record) = (self.belief.clone(), self.record);
        belief.link.restart_clock();
        record.restart_clock();
        let drive = self.follows.as_ref().map(|follows| Arc::clone(follows.belief()));
        let (phase, watch) = (self.phase.resumed(), self.watch.kept());
        let noise = self.noise.as_ref().map(|belief| belief.identified());
        Saved { belief, phase, record, watch, drive, noise }
    }

    /// A controller that goes on where another one was when `saved` was taken, the robot's clock counting anew as
    /// in [`Controller::restart_clock`]. A calibration that was over is not repeated, a leg that was begun is taken
    /// up again with a turn toward its waypoint, a check or a square begins anew. The time elapsed counts on from where it stood: the robot rested
    /// meanwhile, and for how long its new clock does not say.
    ///
    /// None where `saved` was taken under other settings or another task.
    pub fn restore(
        settings: Settings,
        task: Option<Task>,
        stopped: bool,
        saved: Saved,
    ) -> Option<Self> {
        saved.fits(&settings, task.as_ref()).then(|| {
            let Saved { belief, phase, record, watch, drive, noise } = saved;
            let watch = Watch::restored(watch);
            let trace = matches!(phase, Phase::Checking { .. })
                .then(|| Self::trace_of(&settings, task.as_ref()))
                .flatten();
            let (mut runs, mut phase) = (None, phase);
            if matches!(phase, Phase::Squaring { .. }) {
                // The runs before are not kept.
                phase = Phase::run_of_square(0);
                runs = Self::runs_of(&settings, task.as_ref());
            }
            let mut restored = Self {
                belief,
                phase,
                record,
                watch,
                task,
                stopped,
                trace,
                runs,
                ..Self::new(settings)
            };
            if let (Some(follows), Some(belief)) = (&mut restored.follows, drive) {
                *follows = Follows::of(belief, &settings);
            }
            if let (Some(belief), Some(noise)) = (&mut restored.noise, noise) {
                **belief = NoiseBelief::of(noise);
            }
            restored.act();
            restored
        })
    }
}

#[cfg(test)]
mod tests;
