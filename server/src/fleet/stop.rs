//! Stopping and going on, one robot or all, and the stop of all when the server ends.
//!
//! The last word wins: each request takes its place when it arrives ([`Arrival`]). A stop acts first and is kept then;
//! a resume is kept first and acts then, unless a stop has come meanwhile (`keeping` says how they are kept).
//!
//! Of two requests on two connections, sent one after the other, either may arrive first, by some milliseconds where the
//! machine is busy. No one can tell then, so the stop wins: it acts when it arrives, and once more after [`SETTLES`],
//! before it is acknowledged.

use super::Fleet;
use crate::fleet::robot::{Arrival, Command, Robot};
use crate::resource::change::to_the_end;
use crate::resource::failure::Failure;
use futures_util::future::join_all;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::time::{sleep, timeout};
use umwelt_api::problem::{Detail, MAX_DETAILS, Status, reason};

/// How long after its arrival a stop takes its final place: far above what two connections differ by, far below what a
/// person notices.
const SETTLES: Duration = Duration::from_millis(20);

/// Longest wait until robots that may go on show it: it holds all the same.
const SHOW: Duration = Duration::from_secs(1);

impl Fleet {
    /// Stops a robot. It rests from its next exchange on, whatever its task and the store do. Returns whether that is
    /// kept: where it is not, a restart now would let the robot go on.
    pub(crate) async fn stop(&self, robot: Arc<Robot>) -> Result<bool, Failure> {
        let kept = self.stop_these(vec![Arc::clone(&robot)], self.0.arrivals.next()).await?;
        if robot.is_alive() { Ok(kept) } else { Err(robot.ended()) }
    }

    /// Stops all robots there are. Returns their number, and whether that is kept.
    pub(crate) async fn stop_all(&self) -> Result<(usize, bool), Failure> {
        // First its place, then the robots: one that comes later is not meant.
        let arrival = self.0.arrivals.next();
        let robots = self.robots(None);
        let kept = self.stop_these(robots.clone(), arrival).await?;
        let count = robots.len();
        // One whose computation does not end was told: it rests once it ends.
        let missed: Vec<_> = robots.into_iter().filter(|robot| !robot.is_alive()).collect();
        not_told(count, missed)?;
        Ok((count, kept))
    }

    /// Lets a stopped robot go on.
    pub(crate) async fn resume(&self, robot: Arc<Robot>) -> Result<(), Failure> {
        let (fleet, arrival) = (self.clone(), self.0.arrivals.next());
        to_the_end(async move {
            fleet.accepts_changes()?;
            if let Some(failure) = robot.unable() {
                return Err(failure);
            }
            overtaken(&fleet.resume_these(vec![robot], arrival).await?)
        })
        .await
    }

    /// Lets all stopped robots go on. Returns the number of robots.
    pub(crate) async fn resume_all(&self) -> Result<usize, Failure> {
        let (fleet, arrival) = (self.clone(), self.0.arrivals.next());
        to_the_end(async move {
            fleet.accepts_changes()?;
            let robots = fleet.robots(None);
            let count = robots.len();
            let (able, unable): (Vec<_>, Vec<_>) =
                robots.into_iter().partition(|robot| robot.unable().is_none());
            let resumed = fleet.resume_these(able, arrival).await;
            overtaken(&resumed.map_err(|failure| none_goes_on(count, &failure))?)?;
            not_told(count, unable)?;
            Ok(count)
        })
        .await
    }

    /// Stops `robots` at once and keeps it; returns whether it is kept.
    async fn stop_these(
        &self,
        mut robots: Vec<Arc<Robot>>,
        arrival: Arrival,
    ) -> Result<bool, Failure> {
        for robot in &robots {
            robot.stop(arrival);
        }
        let fleet = self.clone();
        to_the_end(async move {
            sleep(SETTLES).await;
            let place = fleet.0.arrivals.next();
            // One that a later resume has let go on already is not stopped by this any more.
            robots.retain(|robot| robot.stop(place).is_stopped());
            Ok(fleet.keep_stops(robots, place).await)
        })
        .await
    }

    /// Lets `robots` go on once that is kept. Returns those that a stop has overtaken, which rest.
    async fn resume_these(
        &self,
        robots: Vec<Arc<Robot>>,
        arrival: Arrival,
    ) -> Result<Vec<Arc<Robot>>, Failure> {
        let overtaken = self.keep_and_resume(&robots, arrival).await?;
        // It holds already; that it shows when it is answered is a courtesy.
        let shown = robots.iter().map(|robot| robot.tell(Command::Look));
        let _ = timeout(SHOW, join_all(shown)).await;
        Ok(overtaken)
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
}

/// What it means that a later stop has overtaken the resume of `robots`.
fn overtaken(robots: &[Arc<Robot>]) -> Result<(), Failure> {
    if robots.is_empty() {
        return Ok(());
    }
    let message = match robots {
        [robot] => format!("robot {} rests: a stop has come after this resume", robot.id()),
        _ => format!("{} robots rest: a stop has come after this resume", robots.len()),
    };
    let named = robots.iter().take(MAX_DETAILS);
    Err(named.fold(Failure::new(Status::Aborted, message), |failure, robot| {
        let remedy = "find out who stopped it and why, then resume again";
        failure.with(Detail::new(reason::OVERTAKEN, "robot", robot.id().as_str(), remedy))
    }))
}

/// What it means that none of `count` robots goes on, since that could not be kept.
fn none_goes_on(count: usize, why: &Failure) -> Failure {
    let message = format!("none of {count} robots goes on: {}", why.message());
    let remedy = "nothing was changed: they rest; ask again";
    let detail = Detail::new(reason::STORE_FAILED, "", (), remedy);
    Failure::new(Status::Unavailable, message).with(detail)
}

/// What it means that of `count` robots the `missed` ones could not be told.
fn not_told(count: usize, mut missed: Vec<Arc<Robot>>) -> Result<(), Failure> {
    missed.retain(|robot| !robot.snapshot().is_removed());
    if missed.is_empty() {
        return Ok(());
    }
    let message = format!("{} of {count} robots could not be told", missed.len());
    let missed = missed.into_iter().take(MAX_DETAILS);
    Err(missed.fold(Failure::new(Status::Unavailable, message), |failure, robot| {
        let remedy = "ask again for this one";
        failure.with(Detail::new(reason::NOT_TOLD, "robot", robot.id().as_str(), remedy))
    }))
}
