//! Simulated environments by name: put, shown, listed, removed.

use super::page::{self, Query};
use super::robots::code;
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::extract::{Body, Environment};
use crate::library::training::{MAX_ENVIRONMENTS, Named};
use crate::resource::change::{Put, to_the_end};
use crate::resource::condition::Condition;
use crate::resource::failure::{self, Failure};
use crate::store::{Change, Kind};
use axum::extract::State;
use axum::http::StatusCode;
use umwelt_api::EnvironmentId;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::training::{Page, Spec};
use umwelt_lab::wire;

pub(crate) async fn put(
    State(app): State<App>,
    Environment(id): Environment,
    condition: Condition,
    Body(spec): Body<Spec>,
) -> Result {
    let environment = wire::training::environment(&spec, &id);
    to_the_end(async move {
        accepts_changes(&app)?;
        let _changing = app.environments.changing().await;
        let before = app.environments.all().find(&id);
        condition.check(before.as_ref().map(Named::etag).as_deref())?;
        check_own(&id)?;
        if before.is_none() {
            id.check_new()?;
        }
        if before.is_none() && app.environments.all().len() >= MAX_ENVIRONMENTS {
            return Err(failure::limit_reached("environments", MAX_ENVIRONMENTS));
        }
        let named = Named { id, environment, note: spec.into_inner().note, built_in: false };
        let stored = named.stored().map_err(|error| failure::internal(error.to_string()))?;
        app.keeper.commit(vec![Change::PutEnvironment(stored)]).await?;
        app.environments.all().insert(named.clone());
        app.unreadable.remove(Kind::Environment, named.id.as_str());
        let put = if before.is_some() { Put::Replaced } else { Put::Created };
        Ok(answer::versioned(code(put), &named.etag(), &named.shown()))
    })
    .await
}

pub(crate) async fn get(State(app): State<App>, Environment(id): Environment) -> Result {
    let named = app.environments.all().find(&id).ok_or_else(|| missing(&app, &id))?;
    Ok(answer::versioned(StatusCode::OK, &named.etag(), &named.shown()))
}

pub(crate) async fn delete(
    State(app): State<App>,
    Environment(id): Environment,
    condition: Condition,
) -> Result {
    to_the_end(async move {
        accepts_changes(&app)?;
        let _changing = app.environments.changing().await;
        let Some(named) = app.environments.all().find(&id) else {
            if !app.unreadable.has(Kind::Environment, id.as_str()) {
                return Err(missing(&app, &id));
            }
            condition.check(None)?;
            app.keeper.commit(vec![Change::DeleteEnvironment(id.to_string())]).await?;
            app.unreadable.remove(Kind::Environment, id.as_str());
            return Ok(answer::nothing());
        };
        condition.check(Some(&named.etag()))?;
        check_own(&id)?;
        app.keeper.commit(vec![Change::DeleteEnvironment(id.to_string())]).await?;
        app.environments.all().remove(&id);
        Ok(answer::nothing())
    })
    .await
}

pub(crate) async fn list(State(app): State<App>, query: Query<page::Environments>) -> Result {
    let found = app.environments.all().above(query.after.as_ref(), query.size + 1);
    let (page, next_page_token) = page::cut(found, query.size, |named| named.id.to_string());
    let after = query.after.as_ref().map(EnvironmentId::as_str);
    let is_listed = page::holds(after, next_page_token.as_deref());
    let unreadable = app.unreadable.page(Kind::Environment, is_listed);
    let environments = page.iter().map(Named::shown).collect();
    Ok(answer::json(StatusCode::OK, &Page { environments, unreadable, next_page_token }))
}

fn accepts_changes(app: &App) -> Result<(), Failure> {
    if app.fleet.is_draining() { Err(failure::draining()) } else { Ok(()) }
}

/// Nothing goes by this name, or what cannot be read.
fn missing(app: &App, id: &EnvironmentId) -> Failure {
    let unreadable = app.unreadable.failure(Kind::Environment, id.as_str());
    unreadable.unwrap_or_else(|| failure::no_such("environment", id.as_str()))
}

/// Whether the name is for those who put environments.
fn check_own(id: &EnvironmentId) -> Result<(), Failure> {
    if wire::training::built_in(id.as_str()).is_err() {
        return Ok(());
    }
    let message = format!("{id} comes with the server and stays as it is");
    let detail = Detail::new(reason::BUILT_IN, "environment", id.as_str(), "use another name");
    Err(Failure::new(Status::FailedPrecondition, message).with(detail))
}
