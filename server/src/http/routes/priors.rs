//! Named priors: put, shown, listed, removed.

use super::page::{self, Query};
use super::robots::code;
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::extract::{Body, Prior};
use crate::jobs::evolution::claimant;
use crate::library::priors::{MAX_PRIORS, Named};
use crate::resource::change::{Put, to_the_end};
use crate::resource::condition::Condition;
use crate::resource::failure::{self, Failure};
use crate::store::{Change, Kind};
use axum::extract::State;
use axum::http::StatusCode;
use umwelt_api::PriorId;
use umwelt_api::prior::{self, MAX_ROBOTS, Page, Source, Spec};
use umwelt_api::problem::{Detail, Status, reason};

pub(crate) async fn put(
    State(app): State<App>,
    Prior(id): Prior,
    condition: Condition,
    Body(spec): Body<Spec>,
) -> Result {
    let prior = spec.to_core();
    to_the_end(async move {
        accepts_changes(&app)?;
        let _changing = app.priors.changing().await;
        let before = app.priors.all().find(&id);
        condition.check(before.as_ref().map(Named::etag).as_deref())?;
        check_own(&app, &id)?;
        if before.is_none() {
            id.check_new()?;
        }
        // Where the values stay, where they come from stays too.
        let source = match &before {
            Some(before) if before.prior == prior => before.source.clone(),
            Some(_) => {
                check_unused(&app, &id)?;
                Source::Put
            }
            None if app.priors.all().len() >= MAX_PRIORS => {
                return Err(failure::limit_reached("priors", MAX_PRIORS));
            }
            None => Source::Put,
        };
        let named = Named { id, prior, note: spec.into_inner().note, source };
        app.keeper.commit(named.stored().map(Change::PutPrior).into_iter().collect()).await?;
        app.priors.all().insert(named.clone());
        app.unreadable.remove(Kind::Prior, named.id.as_str());
        let put = if before.is_some() { Put::Replaced } else { Put::Created };
        Ok(show(&app, code(put), &named))
    })
    .await
}

pub(crate) async fn get(State(app): State<App>, Prior(id): Prior) -> Result {
    let named = app.priors.all().find(&id).ok_or_else(|| missing(&app, &id))?;
    Ok(show(&app, StatusCode::OK, &named))
}

pub(crate) async fn delete(
    State(app): State<App>,
    Prior(id): Prior,
    condition: Condition,
) -> Result {
    to_the_end(async move {
        accepts_changes(&app)?;
        let _changing = app.priors.changing().await;
        let Some(named) = app.priors.all().find(&id) else {
            if !app.unreadable.has(Kind::Prior, id.as_str()) {
                return Err(missing(&app, &id));
            }
            condition.check(None)?;
            app.keeper.commit(vec![Change::DeletePrior(id.to_string())]).await?;
            app.unreadable.remove(Kind::Prior, id.as_str());
            return Ok(answer::nothing());
        };
        condition.check(Some(&named.etag()))?;
        check_own(&app, &id)?;
        check_unused(&app, &id)?;
        app.keeper.commit(vec![Change::DeletePrior(id.to_string())]).await?;
        app.priors.all().remove(&id);
        Ok(answer::nothing())
    })
    .await
}

pub(crate) async fn list(State(app): State<App>, query: Query<page::Priors>) -> Result {
    let found = app.priors.all().above(query.after.as_ref(), query.size + 1);
    let (page, next_page_token) = page::cut(found, query.size, |named| named.id.to_string());
    let after = query.after.as_ref().map(PriorId::as_str);
    let is_listed = page::holds(after, next_page_token.as_deref());
    let unreadable = app.unreadable.page(Kind::Prior, is_listed);
    let users = app.fleet.users();
    let priors = page.iter().map(|named| named.shown(&users)).collect();
    Ok(answer::json(StatusCode::OK, &Page { priors, unreadable, next_page_token }))
}

fn show(app: &App, code: StatusCode, named: &Named) -> axum::response::Response {
    answer::versioned(code, &named.etag(), &named.shown(&app.fleet.users()))
}

/// Nothing goes by this name, or what cannot be read.
fn missing(app: &App, id: &PriorId) -> Failure {
    let unreadable = app.unreadable.failure(Kind::Prior, id.as_str());
    unreadable.unwrap_or_else(|| failure::no_such("prior", id.as_str()))
}

fn accepts_changes(app: &App) -> Result<(), Failure> {
    if app.fleet.is_draining() { Err(failure::draining()) } else { Ok(()) }
}

/// Whether the name is for those who put priors: not of one of the program, nor of a champion to come.
fn check_own(app: &App, id: &PriorId) -> Result<(), Failure> {
    if prior::built_in(id.as_str()).is_ok() {
        let message = format!("{id} comes with the server and stays as it is");
        let detail = Detail::new(reason::BUILT_IN, "prior", id.as_str(), "use another name");
        return Err(Failure::new(Status::FailedPrecondition, message).with(detail));
    }
    if let Some(evolution) = claimant(&app.evolutions, id) {
        let message = format!("{evolution} will give its champion the name {id}");
        let remedy = "use another name, or cancel that evolution";
        let detail = Detail::new(reason::NAME_TAKEN, "prior", id.as_str(), remedy);
        return Err(Failure::new(Status::AlreadyExists, message).with(detail));
    }
    Ok(())
}

/// Whether no robot uses it; the failure names those that do.
fn check_unused(app: &App, id: &PriorId) -> Result<(), Failure> {
    let users = app.fleet.users();
    let robots = users.of(id);
    if robots.is_empty() {
        return Ok(());
    }
    let mut message = match robots.len() {
        1 => format!("a robot uses the prior {id}"),
        count => format!("{count} robots use the prior {id}"),
    };
    if let Some(more) = robots.len().checked_sub(MAX_ROBOTS).filter(|more| *more > 0) {
        message += &format!(": the first {MAX_ROBOTS} of them are named, {more} more are not");
    }
    let remedy = "describe it with another prior, or remove it";
    let failure = Failure::new(Status::FailedPrecondition, message);
    let named = robots.iter().take(MAX_ROBOTS);
    let named =
        named.map(|robot| Detail::new(reason::PRIOR_IN_USE, "robots", robot.as_str(), remedy));
    Err(named.fold(failure, Failure::with))
}
