//! Jobs: submitted, shown, listed, cancelled, removed and followed by the same routes whatever their kind. What a kind alone
//! has stands in [`evolution`] and [`comparison`].

pub(crate) mod comparison;
mod events;
pub(crate) mod evolution;
mod named;
mod resource;

pub(crate) use events::events;
pub(crate) use named::Named;
pub(crate) use resource::{Asked, Resource};

use super::page::{self, Query};
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::documents;
use crate::http::extract::Json;
use crate::jobs::{Job, Jobs, Submission, Work, read_part};
use crate::resource::change::to_the_end;
use crate::resource::etag;
use crate::resource::failure::{self, Failure};
use crate::store::{JobId, Kind, Part};
use axum::extract::{FromRequest, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::Response;
use named::Name;
use std::collections::HashMap;
use std::fmt::Display;
use std::sync::Arc;
use umwelt_api::IdempotencyKey;
use umwelt_api::body::Body;
use umwelt_api::job::{JobKind, JobPage};
use umwelt_api::problem::{Detail, Problems, Status, reason};

/// Submits a job.
pub(crate) async fn submit<W: Resource>(
    State(app): State<App>,
    State(jobs): State<Jobs<W>>,
    request: Request,
) -> Result {
    let key = idempotency_key(request.headers());
    let Json { bytes, .. } = Json::<Asked<W>>::from_request(request, &app).await?;
    let key = key?;
    to_the_end(async move {
        let _names = W::names(&app).await;
        let mut submitting = jobs.submitting().await;
        if let (Some(key), Ok(request)) = (key.as_ref(), Asked::<W>::read(&bytes))
            && let Some(job) = submitting.repeated(key, &etag::of(&request))?
        {
            return Ok(submitted(StatusCode::OK, &job));
        }
        // Names stand for what they stand for now.
        let (request, settings) = W::read(&app, &bytes)?;
        let submission = Submission { settings, key, request: etag::of(&request).to_string() };
        let own = |next| W::own(&app, &jobs, &request, next);
        let job = submitting.submit(submission, own).await?;
        Ok(submitted(StatusCode::CREATED, &job))
    })
    .await
}

/// A job that was submitted, now or before.
fn submitted<W: Resource>(code: StatusCode, job: &Job<W>) -> Response {
    let mut response = answer::json(code, &job.on_wire());
    let location = format!("/v1/{}/{}", W::Kind::LIST, job.id());
    if let Ok(location) = HeaderValue::from_str(&location) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    response
}

pub(crate) async fn get<W: Resource>(Named(job): Named<W>) -> Response {
    answer::json(StatusCode::OK, &job.on_wire())
}

pub(crate) async fn list<W: Resource>(
    State(app): State<App>,
    State(jobs): State<Jobs<W>>,
    query: Query<page::Jobs<W>>,
) -> Response {
    let all = jobs.below(query.after).into_iter();
    let is_listed = |job: &Arc<Job<W>>| query.state.is_none_or(|state| state == job.state().into());
    let found = all.filter(is_listed).take(query.size + 1).collect();
    let (page, next_page_token) =
        page::cut(found, query.size, |job: &Arc<Job<W>>| job.id().number.to_string());
    let last = next_page_token.as_ref().and_then(|last| last.parse::<u64>().ok());
    let is_listed = |name: &str| {
        let number = name.rsplit('-').next().and_then(|number| number.parse::<u64>().ok());
        number.is_none_or(|number| {
            query.after.is_none_or(|before| number < before) && last.is_none_or(|it| number >= it)
        })
    };
    let is_whole = query.state.is_none();
    let unreadable = app.unreadable.page(Kind::Job(W::KIND), |name| is_whole && is_listed(name));
    let jobs = page.iter().map(|job| job.listed()).collect();
    let page = JobPage::<W::Kind> { jobs, unreadable, next_page_token };
    answer::json(StatusCode::OK, &page)
}

pub(crate) async fn cancel<W: Resource>(
    State(jobs): State<Jobs<W>>,
    Named(job): Named<W>,
) -> Result {
    to_the_end(async move {
        jobs.cancel(&job).await?;
        Ok(answer::json(StatusCode::OK, &job.on_wire()))
    })
    .await
}

pub(crate) async fn delete<W: Resource>(
    State(app): State<App>,
    State(jobs): State<Jobs<W>>,
    Name(id): Name<W>,
) -> Result {
    to_the_end(async move {
        let (kind, name) = (Kind::Job(W::KIND), id.as_ref());
        if let Some(job) = jobs.find(name) {
            jobs.delete(&job).await?;
            return Ok(answer::nothing());
        }
        if !app.unreadable.has(kind, name) {
            return Err(failure::no_such(kind.name(), name));
        }
        jobs.give_up(name).await?;
        app.unreadable.remove(kind, name);
        Ok(answer::nothing())
    })
    .await
}

/// What `of` makes of the parts that are kept, from index `from` on, at most `limit`; off the async threads, since there
/// may be some MB of them.
pub(super) async fn parts<W: Work, T: Send + 'static>(
    app: &App,
    job: &Job<W>,
    from: usize,
    limit: usize,
    of: impl Fn(&W::Part) -> T + Send + 'static,
) -> Result<Vec<T>, Failure> {
    let id = job.id();
    let kept = app.keeper.parts(id, from, limit).await?;
    let read = move || kept.iter().map(|part| Ok(of(&read::<W>(id, part)?))).collect();
    tokio::task::spawn_blocking(read).await.map_err(|error| failure::broken(&error))?
}

fn read<W: Work>(id: JobId, part: &Part) -> Result<W::Part, Failure> {
    read_part(&part.body).map_err(|error| {
        Failure::new(Status::DataLoss, format!("part {} of {id}: {error}", part.index))
    })
}

/// What is made of all parts of a job that are kept, and for whom.
pub(super) struct Made<'a, W: Resource> {
    pub(super) app: &'a App,
    pub(super) job: &'a Arc<Job<W>>,
    pub(super) headers: &'a HeaderMap,
    pub(super) media_type: &'static str,
    /// Which document of the job it is.
    pub(super) what: &'static str,
    /// How many parts there are.
    pub(super) state: u64,
}

impl<W: Resource> Made<'_, W> {
    /// A document that `make` makes of the parts, now or before.
    pub(super) async fn of_parts<E: Display>(
        self,
        make: impl FnOnce(&Job<W>, &[W::Part]) -> Result<String, E> + Send + 'static,
    ) -> Result {
        let (keeper, job, id) = (self.app.keeper.clone(), Arc::clone(self.job), self.job.id());
        let kept = async move { keeper.parts(id, 0, usize::MAX).await };
        let make = move |kept: Vec<Part>| {
            let parts: Result<Vec<_>, _> = kept.iter().map(|part| read::<W>(id, part)).collect();
            make(&job, &parts?).map_err(|error| failure::internal(error.to_string()))
        };
        let name = documents::Name { job: id, what: self.what, state: self.state };
        let document = self.app.documents.get(name, self.media_type, kept, make).await?;
        Ok(document.answer(self.headers))
    }
}

/// The figure of a path, one of those that `named` knows.
pub(super) fn figure<F>(
    path: &HashMap<String, String>,
    named: impl Fn(&str) -> Option<F>,
    known: &[&str],
) -> Result<F, Failure> {
    let name = path.get("figure").map(String::as_str).unwrap_or_default();
    named(name).ok_or_else(|| {
        let known = format!("known: {}", known.join(", "));
        let detail = Detail::new(reason::NO_SUCH_RESOURCE, "figure", name, known);
        Failure::new(Status::NotFound, "there is no such figure").with(detail)
    })
}

/// The key under which something is submitted.
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

#[cfg(test)]
mod tests;
