//! Stopping and going on, one robot or all, and the stop of all when the server ends.

use super::{Fleet, to_the_end};
use crate::failure::Failure;
use crate::robot::{Command, Robot};
use crate::store::Record;
use futures_util::future::join_all;
use std::collections::BTreeSet;
use std::sync::atomic::Ordering;
use std::sync::{Arc, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::time::timeout;
use umwelt_api::RobotId;
use umwelt_api::problem::{Detail, MAX_DETAILS, Status, reason};

/// Longest wait for one robot where all are told something: a robot whose task hangs must not hide
/// that the others were told.
const TELL_ALL: Duration = Duration::from_secs(1);

/// Longest wait for the store before a stop is acknowledged: well below [`TELL_ALL`], or a store that hangs
/// would make a stop of all look as if it had failed.
const KEEP_STOP: Duration = Duration::from_millis(300);

impl Fleet {
    /// Stops a robot. It rests whatever the store does; where the store does not keep it, or not soon, it is
    /// logged, and tried again until it is kept: before that, a restart would let the robot go on.
    pub(crate) async fn stop(&self, robot: Arc<Robot>) -> Result<(), Failure> {
        robot.tell(Command::Stop).await?;
        let (fleet, id) = (self.clone(), robot.id().clone());
        let keeping = to_the_end(async move {
            let _writing = robot.writing.lock().await;
            fleet.keep_as_it_is(&robot).await
        });
        match timeout(KEEP_STOP, keeping).await {
            Ok(Ok(())) => return Ok(()),
            Ok(Err(failure)) => {
                tracing::warn!(robot = %id, ?failure, "stopped, but the store does not keep it");
            }
            Err(_) => tracing::warn!(robot = %id, "stopped, but the store does not answer"),
        }
        self.unkept().insert(id);
        Ok(())
    }

    /// Keeps the stops that could not be kept when they came.
    pub(super) async fn keep_stops(&self) {
        let unkept = std::mem::take(&mut *self.unkept());
        for robot in unkept.iter().filter_map(|id| self.find(id)) {
            let _writing = robot.writing.lock().await;
            match self.keep_as_it_is(&robot).await {
                Ok(()) => tracing::info!(robot = %robot.id(), "that it is stopped is kept now"),
                Err(_) => drop(self.unkept().insert(robot.id().clone())),
            }
        }
    }

    fn unkept(&self) -> MutexGuard<'_, BTreeSet<RobotId>> {
        // A set of ids is whole whatever happened behind the lock.
        self.0.unkept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a stopped robot go on.
    pub(crate) async fn resume(&self, robot: Arc<Robot>) -> Result<(), Failure> {
        let fleet = self.clone();
        to_the_end(async move {
            fleet.accepts_changes()?;
            let (_writing, snapshot) = robot.change().await?;
            let record = Record { stopped: false, ..snapshot.record() };
            fleet.keep(robot.id(), &record, None).await?;
            fleet.unkept().remove(robot.id());
            robot.tell(Command::Resume).await
        })
        .await
    }

    /// Stops all robots there are. Returns their number.
    pub(crate) async fn stop_all(&self) -> Result<usize, Failure> {
        let told = self.robots(None).into_iter().map(|robot| async move {
            let done = timeout(TELL_ALL, self.stop(Arc::clone(&robot))).await;
            (robot, done.unwrap_or_else(|_| Err(too_slow())))
        });
        all_told(join_all(told).await)
    }

    /// Lets all stopped robots go on. Returns the number of robots.
    pub(crate) async fn resume_all(&self) -> Result<usize, Failure> {
        let told = self.robots(None).into_iter().map(|robot| async move {
            let done = timeout(TELL_ALL, self.resume(Arc::clone(&robot))).await;
            (robot, done.unwrap_or_else(|_| Err(too_slow())))
        });
        all_told(join_all(told).await)
    }

    /// Begins to shut down: changes are refused, every robot is told to rest. Returns once each connected one has
    /// fetched a stopping horizon.
    pub(crate) async fn drain(&self) {
        self.0.draining.store(true, Ordering::SeqCst);
        let drained = self.robots(None).into_iter().map(|robot| async move {
            if robot.tell(Command::Drain).await.is_ok() {
                robot.drained().await;
            }
        });
        join_all(drained).await;
    }

    async fn keep_as_it_is(&self, robot: &Robot) -> Result<(), Failure> {
        let snapshot = robot.snapshot();
        if snapshot.is_removed() {
            return Ok(());
        }
        self.keep(robot.id(), &snapshot.record(), None).await
    }
}

fn too_slow() -> Failure {
    Failure::new(Status::DeadlineExceeded, format!("no answer within {} s", TELL_ALL.as_secs_f64()))
}

/// How many robots were told, or those that were not.
fn all_told(told: Vec<(Arc<Robot>, Result<(), Failure>)>) -> Result<usize, Failure> {
    let count = told.len();
    let missed: Vec<_> = told
        .into_iter()
        .filter(|(robot, result)| result.is_err() && !robot.snapshot().is_removed())
        .collect();
    if missed.is_empty() {
        return Ok(count);
    }
    let message = format!("{} of {count} robots could not be told", missed.len());
    let missed = missed.into_iter().take(MAX_DETAILS);
    Err(missed.fold(Failure::new(Status::Unavailable, message), |failure, (robot, _)| {
        let remedy = "ask again for this one";
        failure.with(Detail::new(reason::NOT_TOLD, "robot", robot.id().as_str(), remedy))
    }))
}
