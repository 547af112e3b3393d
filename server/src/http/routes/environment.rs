//! What is identified of a robot's environment.

use crate::fleet::robot::Command;
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::budget::Peer;
use crate::http::extract::Known;
use axum::http::StatusCode;

pub(crate) async fn get(Known(robot): Known) -> Result {
    Ok(answer::json(StatusCode::OK, &robot.snapshot().environment()))
}

/// Back to the prior.
pub(crate) async fn reset(peer: Peer, Known(robot): Known) -> Result {
    robot.tell(Command::ResetEnvironment).await?;
    tracing::info!(robot = %robot.id(), %peer, "environment reset");
    Ok(answer::json(StatusCode::OK, &robot.snapshot().environment()))
}
