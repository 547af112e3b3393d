//! Robots: described, shown, listed, removed.

use super::page::{self, Query, Robots};
use crate::fleet::robot::Robot;
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::budget::Peer;
use crate::http::extract::{Body, Id, Json, Known};
use crate::resource::change::{Put, to_the_end};
use crate::resource::condition::Condition;
use crate::resource::failure;
use crate::store::{Kind, Told};
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use tokio::time::Instant;
use umwelt_api::RobotId;
use umwelt_api::problem::Problems;
use umwelt_api::robot::{Description, Page, Patch};

pub(crate) async fn put(
    State(app): State<App>,
    peer: Peer,
    Id(id): Id,
    condition: Condition,
    body: Json<Description>,
) -> Result {
    let (robot, put) = to_the_end(async move {
        // Until the robot has it, the prior of this name neither changes nor goes.
        let _giving = app.priors.giving().await;
        app.fleet.put(id, told(&app, &body.bytes)?, condition).await
    })
    .await?;
    tracing::info!(robot = %robot.id(), %peer, "robot described");
    Ok(show(&robot, code(put)))
}

/// Changes parts of what was said. Whoever changes other parts meanwhile is not undone.
pub(crate) async fn patch(
    State(app): State<App>,
    peer: Peer,
    Known(robot): Known,
    condition: Condition,
    Body(patch): Body<Patch>,
) -> Result {
    let id = robot.id().clone();
    let (robot, _) = to_the_end(async move {
        let _giving = app.priors.giving().await;
        loop {
            let robot = app.fleet.find(&id).ok_or_else(|| failure::no_such_robot(&id))?;
            let snapshot = robot.snapshot();
            condition.check(Some(snapshot.etag()))?;
            let told = told(&app, &snapshot.said().patched(&patch))?;
            let unchanged = Condition::of(snapshot.etag());
            match app.fleet.put(id.clone(), told, unchanged).await {
                Err(failure) if failure.is_of_version() => {}
                done => return done,
            }
        }
    })
    .await?;
    tracing::info!(robot = %robot.id(), %peer, "robot described in parts");
    Ok(show(&robot, StatusCode::OK))
}

/// What a description tells a controller, with the priors that there are.
fn told(app: &App, json: &[u8]) -> std::result::Result<Told, Problems> {
    let (said, settings) = Description::read_known(json, |name| app.priors.known(name))?;
    let prior = said.prior().map(str::to_owned);
    Ok(Told { settings, prior, said })
}

pub(crate) async fn get(Known(robot): Known) -> Result {
    Ok(show(&robot, StatusCode::OK))
}

fn show(robot: &Robot, code: StatusCode) -> Response {
    let snapshot = robot.snapshot();
    let shown = snapshot.robot(robot.id(), Instant::now());
    answer::versioned(code, snapshot.etag(), &shown)
}

pub(crate) async fn delete(
    State(app): State<App>,
    peer: Peer,
    Id(id): Id,
    condition: Condition,
) -> Result {
    match app.fleet.find(&id) {
        Some(robot) => app.fleet.delete(robot, condition).await?,
        None => app.fleet.give_up(id.clone(), condition).await?,
    }
    tracing::info!(robot = %id, %peer, "robot removed");
    Ok(answer::nothing())
}

pub(crate) async fn list(State(app): State<App>, query: Query<Robots>) -> Result {
    let now = Instant::now();
    let robots = app.fleet.robots(query.after.as_ref());
    let mut found = robots
        .iter()
        .map(|robot| (robot.id(), robot.snapshot()))
        .filter(|(_, snapshot)| query.state.is_none_or(|state| snapshot.state() == state));
    let page: Vec<_> = found.by_ref().take(query.size).map(|(id, it)| it.robot(id, now)).collect();
    let is_last = found.next().is_none();
    let next_page_token = page.last().filter(|_| !is_last).map(|last| last.robot.to_string());
    let unreadable = if query.state.is_none() {
        let after = query.after.as_ref().map(RobotId::as_str);
        let is_listed = page::holds(after, next_page_token.as_deref());
        app.unreadable.page(Kind::Robot, is_listed)
    } else {
        Vec::new()
    };
    Ok(answer::json(StatusCode::OK, &Page { robots: page, unreadable, next_page_token }))
}

/// The HTTP status of a PUT.
pub(super) fn code(put: Put) -> StatusCode {
    match put {
        Put::Created => StatusCode::CREATED,
        Put::Replaced => StatusCode::OK,
    }
}
