//! A motion that the robot makes by itself and that ends with a report: it is set as a task and followed to its end.

use super::super::failure::Failure;
use super::super::progress::{StatusLine, wait};
use super::super::quantity;
use super::super::task::assign;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};
use umwelt_api::RobotId;
use umwelt_api::robot::Robot;
use umwelt_api::task::{Spec, Stage, Task};
use umwelt_client::{Client, Error};

/// One kind of motion, whose report is an `R`.
pub(super) struct Motion<R> {
    /// What it is called.
    pub(super) name: &'static str,
    /// What to do again where its report is lost.
    pub(super) again: &'static str,
    /// How often it is asked how far the robot is.
    pub(super) look: Duration,
    /// Times the planned duration after which nothing comes of it any more: the robot ends by itself before.
    pub(super) longest: f64,
    /// The report of a task that is over.
    pub(super) report: fn(Task) -> Option<R>,
    /// What is to be said of how far the robot is; or why nothing comes of it any more.
    pub(super) how_far: fn(&Robot) -> Result<String, String>,
}

impl<R> Motion<R> {
    /// Sets the task, which is planned to take `duration` s, and follows it to its report. Where that fails, or Ctrl-C is
    /// pressed, the robot comes to rest.
    pub(super) async fn drive(
        &self,
        client: &Client,
        id: &RobotId,
        spec: &Spec,
        duration: f64,
    ) -> Result<R, Failure> {
        let task = wait(assign(client, id, spec, true)).await?;
        let report = tokio::select! {
            ended = self.follow(client, &task, duration) => ended,
            _ = tokio::signal::ctrl_c() => {
                Err(Failure::Failed(format!("the {} was broken off", self.name)))
            }
        };
        if report.is_err() {
            // Only this one: another task that was set meanwhile is not cancelled. It may have gone already.
            let _ = wait(client.if_match(&task.etag).cancel_task(id)).await;
        }
        report
    }

    async fn follow(&self, client: &Client, task: &Task, duration: f64) -> Result<R, Failure> {
        let (id, name) = (&task.robot, self.name);
        let mut line = StatusLine::new();
        let mut looks = interval(self.look);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let begun = Instant::now();
        loop {
            looks.tick().await;
            let elapsed = begun.elapsed().as_secs_f64();
            let late = elapsed > self.longest * duration;
            match look(client, id).await {
                Ok((now, _)) if now.etag != task.etag => {
                    return Err(Failure::Failed(format!("{id} was given another task meanwhile")));
                }
                Ok((now, _)) if now.progress.stage == Stage::Arrived => {
                    line.clear();
                    return (self.report)(now).ok_or_else(|| {
                        Failure::Failed(format!(
                            "the report is lost: the server was restarted; {} again",
                            self.again
                        ))
                    });
                }
                Ok((_, robot)) if robot.stopped => {
                    return Err(Failure::Failed(format!(
                        "{id} was stopped; the {name} is given up"
                    )));
                }
                Ok((_, robot)) => {
                    let how_far = (self.how_far)(&robot);
                    let how_far =
                        how_far.map_err(|why| Failure::Failed(format!("{id} is {why}")))?;
                    let presence = quantity::presence(&robot);
                    if late {
                        return Err(Failure::Failed(format!(
                            "{id} does not come to an end: {presence}"
                        )));
                    }
                    line.show(
                        &format!("{presence}{how_far}"),
                        &format!(
                            "{id}: {presence}{how_far}, {elapsed:.0} s of some {duration:.0} s"
                        ),
                    );
                }
                Err(error) if error.is_transient() && !late => {
                    line.show("no answer", &format!("still trying: {error}"));
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
}

async fn look(client: &Client, robot: &RobotId) -> Result<(Task, Robot), Error> {
    let (task, robot) = tokio::join!(client.get_task(robot), client.get_robot(robot));
    Ok((task?, robot?))
}
