//! Tasks: set, shown with their progress, cancelled.

use super::robots::code;
use crate::fleet::robot::Robot;
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::budget::Peer;
use crate::http::extract::{Body, Known};
use crate::resource::condition::Condition;
use crate::resource::failure::no_task;
use axum::extract::State;
use axum::http::StatusCode;
use umwelt_api::task::Spec;

pub(crate) async fn put(
    State(app): State<App>,
    peer: Peer,
    Known(robot): Known,
    condition: Condition,
    Body(spec): Body<Spec>,
) -> Result {
    let task = spec.to_core(robot.snapshot().settings().steering.tolerance);
    let waypoints = task.waypoints.len();
    let put = app.fleet.put_task(robot.clone(), task, condition).await?;
    tracing::info!(robot = %robot.id(), %peer, waypoints, "task set");
    show(&robot, code(put))
}

pub(crate) async fn get(Known(robot): Known) -> Result {
    show(&robot, StatusCode::OK)
}

pub(crate) async fn delete(
    State(app): State<App>,
    peer: Peer,
    Known(robot): Known,
    condition: Condition,
) -> Result {
    let id = robot.id().clone();
    app.fleet.delete_task(robot, condition).await?;
    tracing::info!(robot = %id, %peer, "task cancelled");
    Ok(answer::nothing())
}

fn show(robot: &Robot, code: StatusCode) -> Result {
    let task = robot.snapshot().task(robot.id()).ok_or_else(|| no_task(robot.id()))?;
    Ok(answer::versioned(code, &task.etag, &task))
}
