//! Robots: described, shown, listed, removed.

use super::page::{self, Query, Robots};
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::budget::Peer;
use crate::http::extract::{Id, Json, Known};
use crate::resource::change::{Put, to_the_end};
use crate::resource::condition::Condition;
use crate::store::Kind;
use axum::extract::State;
use axum::http::StatusCode;
use tokio::time::Instant;
use umwelt_api::RobotId;
use umwelt_api::robot::{Page, Spec};

pub(crate) async fn put(
    State(app): State<App>,
    peer: Peer,
    Id(id): Id,
    condition: Condition,
    body: Json<Spec>,
) -> Result {
    let (robot, put) = to_the_end(async move {
        // Until the robot has it, the prior of this name neither changes nor goes.
        let _giving = app.priors.giving().await;
        let (spec, settings) = Spec::read_known(&body.bytes, |name| app.priors.known(name))?;
        let prior = spec.prior.name().map(str::to_owned);
        app.fleet.put(id, settings, prior, condition).await
    })
    .await?;
    tracing::info!(robot = %robot.id(), %peer, "robot described");
    let snapshot = robot.snapshot();
    let shown = snapshot.robot(robot.id(), Instant::now());
    Ok(answer::versioned(code(put), snapshot.etag(), &shown))
}

pub(crate) async fn get(Known(robot): Known) -> Result {
    let snapshot = robot.snapshot();
    let shown = snapshot.robot(robot.id(), Instant::now());
    Ok(answer::versioned(StatusCode::OK, snapshot.etag(), &shown))
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
