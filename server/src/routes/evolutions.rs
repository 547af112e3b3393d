//! Evolutions: submitted, shown, listed, cancelled, removed, followed.

mod events;

pub(crate) use events::events;

use super::page::{self, Query};
use crate::answer;
use crate::app::App;
use crate::etag;
use crate::evolution::{Job, Submission, read_generation};
use crate::extract::{Body, Evolution};
use crate::failure::{self, Failure, Result};
use crate::figures::evolution::{Figure, svg};
use crate::fleet::to_the_end;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::collections::HashMap;
use std::sync::Arc;
use umwelt_api::IdempotencyKey;
use umwelt_api::evolution::{self, Generation, GenerationsPage, Page, Request};
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_core::evolution::Generation as Bred;

pub(crate) async fn submit(
    State(app): State<App>,
    headers: HeaderMap,
    Body(body): Body<{ evolution::MAX_BODY }>,
) -> Result {
    let key = idempotency_key(&headers)?;
    to_the_end(async move {
        // Until it is queued, nobody takes the name that its champion is to have.
        let _changing = app.priors.changing().await;
        let mut submitting = app.evolutions.submitting().await;
        if let (Some(key), Ok(request)) = (&key, Request::read(&body))
            && let Some(job) = submitting.repeated(key, &etag::of(&request))?
        {
            return Ok(created(StatusCode::OK, &job));
        }
        let known = |name: &str| app.environments.known(name);
        let (request, settings) = Request::read_known(&body, known)?;
        let prior = request.prior.as_deref().map(str::parse).transpose()?;
        let request = etag::of(&request).to_string();
        let job = submitting.submit(Submission { settings, prior, key, request }).await?;
        Ok(created(StatusCode::CREATED, &job))
    })
    .await
}

pub(crate) async fn get(Evolution(job): Evolution) -> Response {
    answer::json(StatusCode::OK, &job.evolution())
}

pub(crate) async fn list(State(app): State<App>, query: Query<page::Evolutions>) -> Response {
    let jobs = app.evolutions.below(query.after).into_iter();
    let is_listed = |job: &Arc<Job>| query.state.is_none_or(|state| state == job.state().into());
    let found = jobs.filter(is_listed).take(query.size + 1).collect();
    let (page, next_page_token) =
        page::cut(found, query.size, |job: &Arc<Job>| job.number().to_string());
    let evolutions = page.iter().map(|job| job.evolution()).collect();
    answer::json(StatusCode::OK, &Page { evolutions, next_page_token })
}

pub(crate) async fn cancel(State(app): State<App>, Evolution(job): Evolution) -> Result {
    to_the_end(async move {
        app.evolutions.cancel(&job).await?;
        Ok(answer::json(StatusCode::OK, &job.evolution()))
    })
    .await
}

pub(crate) async fn delete(State(app): State<App>, Evolution(job): Evolution) -> Result {
    to_the_end(async move {
        app.evolutions.delete(&job).await?;
        Ok(answer::nothing())
    })
    .await
}

pub(crate) async fn generations(
    State(app): State<App>,
    Evolution(job): Evolution,
    query: Query<page::Generations>,
) -> Result {
    let from = query.after.map_or(0, |after| after.saturating_add(1));
    let bred = kept(&app, &job, from, query.size + 1).await?;
    let shown: Vec<_> = bred.iter().map(Generation::from).collect();
    let (generations, next_page_token) =
        page::cut(shown, query.size, |generation| generation.index.to_string());
    Ok(answer::json(StatusCode::OK, &GenerationsPage { generations, next_page_token }))
}

pub(crate) async fn figure(
    State(app): State<App>,
    Evolution(job): Evolution,
    Path(path): Path<HashMap<String, String>>,
) -> Result {
    let name = path.get("figure").map(String::as_str).unwrap_or_default();
    let Some(figure) = Figure::named(name) else {
        let known = Figure::ALL.map(Figure::name).join(", ");
        let detail =
            Detail::new(reason::NO_SUCH_RESOURCE, "figure", name, format!("known: {known}"));
        return Err(Failure::new(Status::NotFound, "there is no such figure").with(detail));
    };
    let generations = kept(&app, &job, 0, usize::MAX).await?;
    if generations.is_empty() {
        let message = format!("no generation of {} has ended yet", job.id());
        let detail = Detail::new(reason::NOTHING_YET, "figure", name, "ask again later");
        return Err(Failure::new(Status::FailedPrecondition, message).with(detail));
    }
    let drawing =
        move || svg(figure, job.id().as_str(), &job.shown().record.settings, &generations);
    let drawn = tokio::task::spawn_blocking(drawing).await;
    let drawn = drawn.map_err(|error| failure::broken(&error))?;
    let drawn = drawn.map_err(|error| failure::internal(error.to_string()))?;
    Ok(([(header::CONTENT_TYPE, evolution::Figure::MEDIA_TYPE)], drawn).into_response())
}

/// Generations that are kept, from index `from` on, at most `limit`.
async fn kept(app: &App, job: &Job, from: usize, limit: usize) -> Result<Vec<Bred>, Failure> {
    let kept = app.keeper.generations(job.id().as_str(), from, limit).await?;
    let read = kept.iter().map(|generation| {
        read_generation(&generation.body).map_err(|error| {
            let message = format!("generation {} of {}: {error}", generation.index, job.id());
            Failure::new(Status::DataLoss, message)
        })
    });
    read.collect()
}

fn created(code: StatusCode, job: &Job) -> Response {
    let mut response = answer::json(code, &job.evolution());
    if let Ok(location) = HeaderValue::from_str(&format!("/v1/evolutions/{}", job.id())) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    response
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<IdempotencyKey>, Failure> {
    let mut values = headers.get_all(IdempotencyKey::HEADER).iter();
    let Some(value) = values.next() else { return Ok(None) };
    if values.next().is_some() {
        let detail = Detail::new(reason::MALFORMED, IdempotencyKey::HEADER, (), "send one key");
        return Err(Problems::from(detail).into());
    }
    let key = String::from_utf8_lossy(value.as_bytes()).parse::<IdempotencyKey>();
    Ok(Some(key.map_err(Problems::from)?))
}
