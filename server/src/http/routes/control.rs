//! The hot path, and the stop.

use crate::fleet::robot::Robot;
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::budget::Peer;
use crate::http::extract::{Body, Known};
use axum::extract::State;
use axum::http::StatusCode;
use umwelt_api::step::{Reply, Request};
use umwelt_api::stop::{Stop, StopAll};

/// Observations in, horizon out; with it the drive, where the robot asks for one and has another or none.
pub(crate) async fn step(Known(robot): Known, Body(request): Body<Request>) -> Result {
    let reply = robot.step(request.to_core(), request.epoch).await?;
    let drive = request.drive_tag.and_then(|tag| robot.other_drive(tag));
    if drive.is_none() {
        return Ok(answer::json(StatusCode::OK, &*reply));
    }
    let reply = Reply { drive: drive.map(Box::new), ..(*reply).clone() };
    Ok(answer::json(StatusCode::OK, &reply))
}

pub(crate) async fn stop(State(app): State<App>, peer: Peer, Known(robot): Known) -> Result {
    let kept = app.fleet.stop(robot.clone()).await?;
    tracing::info!(robot = %robot.id(), %peer, kept, "robot stopped");
    Ok(shown(&robot, true, kept))
}

pub(crate) async fn resume(State(app): State<App>, peer: Peer, Known(robot): Known) -> Result {
    app.fleet.resume(robot.clone()).await?;
    tracing::info!(robot = %robot.id(), %peer, "robot resumed");
    Ok(shown(&robot, false, true))
}

pub(crate) async fn stop_all(State(app): State<App>, peer: Peer) -> Result {
    let (robots, kept) = app.fleet.stop_all().await?;
    tracing::info!(robots, %peer, kept, "all robots stopped");
    Ok(answer::json(StatusCode::OK, &StopAll { robots, stopped: true, kept }))
}

pub(crate) async fn resume_all(State(app): State<App>, peer: Peer) -> Result {
    let robots = app.fleet.resume_all().await?;
    tracing::info!(robots, %peer, "all robots resumed");
    Ok(answer::json(StatusCode::OK, &StopAll { robots, stopped: false, kept: true }))
}

fn shown(robot: &Robot, stopped: bool, kept: bool) -> axum::response::Response {
    answer::json(StatusCode::OK, &Stop { robot: robot.id().clone(), stopped, kept })
}
