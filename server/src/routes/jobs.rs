//! What all kinds of jobs have in common: shown, listed, cancelled, removed, followed.

mod events;

pub(crate) use events::events;

use super::page::{self, Query};
use crate::answer;
use crate::app::App;
use crate::extract::Named;
use crate::failure::{Failure, Result};
use crate::fleet::to_the_end;
use crate::jobs::{Job, Jobs, Shown, State as Stands, Work, read_part};
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{Response, sse};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::str::FromStr;
use std::sync::Arc;
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_api::{IdempotencyKey, InvalidId};

/// A kind of job as the wire has it.
pub(crate) trait Resource: Work {
    /// What names one.
    type Id: FromStr<Err = InvalidId> + AsRef<str> + Send;
    /// A job.
    type Wire: Serialize;
    /// Where one stands.
    type State: From<Stands> + PartialEq + DeserializeOwned + Send;

    /// All of the kind.
    fn jobs(app: &App) -> &Jobs<Self>;

    /// As the wire has it.
    fn wire(job: &Job<Self>) -> Self::Wire;

    /// A page of a list.
    fn page(jobs: Vec<Self::Wire>, next_page_token: Option<String>) -> impl Serialize;

    /// Where it stands, as an event.
    ///
    /// # Errors
    /// Where it cannot be written.
    fn event(job: &Job<Self>, shown: &Shown<Self>) -> Result<sse::Event, axum::Error>;

    /// What is to be told before that to somebody who was told `told`, each with what has been told then; none where it
    /// cannot be had.
    fn news(
        _app: &App,
        _job: &Job<Self>,
        _shown: &Shown<Self>,
        _told: u64,
    ) -> impl Future<Output = Option<Vec<(u64, Result<sse::Event, axum::Error>)>>> + Send {
        std::future::ready(Some(Vec::new()))
    }
}

pub(crate) async fn get<W: Resource>(Named(job): Named<W>) -> Response {
    answer::json(StatusCode::OK, &W::wire(&job))
}

pub(crate) async fn list<W: Resource>(
    State(app): State<App>,
    query: Query<page::Jobs<W>>,
) -> Response {
    let jobs = W::jobs(&app).below(query.after).into_iter();
    let is_listed =
        |job: &Arc<Job<W>>| query.state.as_ref().is_none_or(|state| *state == job.state().into());
    let found = jobs.filter(is_listed).take(query.size + 1).collect();
    let (page, next_page_token) =
        page::cut(found, query.size, |job: &Arc<Job<W>>| job.id().number.to_string());
    let jobs = page.iter().map(|job| W::wire(job)).collect();
    answer::json(StatusCode::OK, &W::page(jobs, next_page_token))
}

pub(crate) async fn cancel<W: Resource>(State(app): State<App>, Named(job): Named<W>) -> Result {
    to_the_end(async move {
        W::jobs(&app).cancel(&job).await?;
        Ok(answer::json(StatusCode::OK, &W::wire(&job)))
    })
    .await
}

pub(crate) async fn delete<W: Resource>(State(app): State<App>, Named(job): Named<W>) -> Result {
    to_the_end(async move {
        W::jobs(&app).delete(&job).await?;
        Ok(answer::nothing())
    })
    .await
}

/// A job that was submitted, now or before.
pub(super) fn submitted<W: Resource>(code: StatusCode, job: &Job<W>) -> Response {
    let mut response = answer::json(code, &W::wire(job));
    if let Ok(location) = HeaderValue::from_str(&format!("/v1/{}s/{}", W::KIND, job.id())) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    response
}

/// Parts that are kept, from index `from` on, at most `limit`.
pub(super) async fn parts<W: Work>(
    app: &App,
    job: &Job<W>,
    from: usize,
    limit: usize,
) -> Result<Vec<W::Part>, Failure> {
    let kept = app.keeper.parts(job.id(), from, limit).await?;
    let read = kept.iter().map(|part| {
        read_part(&part.body).map_err(|error| {
            let message = format!("part {} of {}: {error}", part.index, job.id());
            Failure::new(Status::DataLoss, message)
        })
    });
    read.collect()
}

/// The key under which something is submitted.
pub(super) fn idempotency_key(headers: &HeaderMap) -> Result<Option<IdempotencyKey>, Failure> {
    let mut values = headers.get_all(IdempotencyKey::HEADER).iter();
    let Some(value) = values.next() else { return Ok(None) };
    if values.next().is_some() {
        let detail = Detail::new(reason::MALFORMED, IdempotencyKey::HEADER, (), "send one key");
        return Err(Problems::from(detail).into());
    }
    let key = String::from_utf8_lossy(value.as_bytes()).parse::<IdempotencyKey>();
    Ok(Some(key.map_err(Problems::from)?))
}
