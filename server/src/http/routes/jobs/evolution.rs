//! Evolutions: submitted, their generations and figures, and what is theirs alone of what all jobs have.

use super::jobs::{
    Made, Named, Resource, figure as figure_of, idempotency_key, parts, repeated, submitted,
};
use super::page::{self, Query};
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::extract::Body;
use crate::jobs::evolution::claim;
use crate::jobs::{Job, Jobs, Shown, Submission};
use crate::resource::change::to_the_end;
use crate::resource::etag;
use crate::resource::failure::Failure;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse;
use serde::Serialize;
use std::collections::HashMap;
use umwelt_api::EvolutionId;
use umwelt_api::evolution::{self, Event, Generation, GenerationsPage, Kind, Page, Request};
use umwelt_api::page::Unreadable;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_lab::evolution::Evolution;
use umwelt_lab::figures::evolution::{Figure, svg};
use umwelt_lab::wire;

/// Generations that are read for a stream at a time.
const AT_A_TIME: usize = 50;

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
        if let Some(answer) = repeated(&submitting, key.as_ref(), Request::read(&body))? {
            return Ok(answer);
        }
        let known = |name: &str| app.environments.known(name);
        let (request, settings) = wire::evolution::read(&body, known)?;
        let prior = request.prior.as_deref().map(str::parse).transpose()?;
        let submission = Submission { settings, key, request: etag::of(&request).to_string() };
        let claim = |next| claim(&app.evolutions, &app.priors, prior, next);
        let job = submitting.submit(submission, claim).await?;
        Ok(submitted(StatusCode::CREATED, &job))
    })
    .await
}

pub(crate) async fn generations(
    State(app): State<App>,
    Named(job): Named<Evolution>,
    query: Query<page::Generations>,
) -> Result {
    let from = query.after.map_or(0, |after| after.saturating_add(1));
    let shown = parts(&app, &job, from, query.size + 1, |bred| Generation::from(bred)).await?;
    let (generations, next_page_token) =
        page::cut(shown, query.size, |generation| generation.index.to_string());
    Ok(answer::json(StatusCode::OK, &GenerationsPage { generations, next_page_token }))
}

pub(crate) async fn figure(
    State(app): State<App>,
    Named(job): Named<Evolution>,
    Path(path): Path<HashMap<String, String>>,
    headers: HeaderMap,
) -> Result {
    let figure = figure_of(&path, Figure::named, &Figure::ALL.map(Figure::name))?;
    let state = job.shown().generations();
    if state == 0 {
        let message = format!("no generation of {} has ended yet", job.id());
        let detail = Detail::new(reason::NOTHING_YET, "figure", figure.name(), "ask again later");
        return Err(Failure::new(Status::FailedPrecondition, message).with(detail));
    }
    let (what, media_type) = (figure.name(), evolution::Figure::MEDIA_TYPE);
    let made = Made { app: &app, job: &job, headers: &headers, media_type, what, state };
    let draw = move |job: &Job<Evolution>, generations: &[umwelt_lab::evolution::Generation]| {
        svg(figure, &job.id().to_string(), &job.shown().record.settings, generations)
    };
    made.of_parts(draw).await
}

impl Resource for Evolution {
    type Id = EvolutionId;
    type Wire = evolution::Evolution;

    fn jobs(app: &App) -> &Jobs<Self> {
        &app.evolutions
    }

    fn wire(job: &Job<Self>) -> evolution::Evolution {
        job.evolution()
    }

    fn page(
        evolutions: Vec<evolution::Evolution>,
        unreadable: Vec<Unreadable>,
        next_page_token: Option<String>,
    ) -> impl Serialize {
        Page { evolutions, unreadable, next_page_token }
    }

    fn event(job: &Job<Self>, shown: &Shown<Self>) -> Result<sse::Event, axum::Error> {
        written(&job.event(shown))
    }

    /// Every generation is told once, in order. The id of an event is the number of generations that have ended.
    async fn news(
        app: &App,
        job: &Job<Self>,
        shown: &Shown<Self>,
        told: u64,
    ) -> Option<Vec<(u64, Result<sse::Event, axum::Error>)>> {
        if shown.generations() <= told {
            return Some(Vec::new());
        }
        let from = usize::try_from(told).ok()?;
        let bred = match parts(app, job, from, AT_A_TIME, |bred| Generation::from(bred)).await {
            Ok(bred) if !bred.is_empty() => bred,
            // Forgotten meanwhile.
            Ok(_) => return None,
            Err(failure) => {
                tracing::error!(job = %job.id(), error = failure.message(), "a stream ends");
                return None;
            }
        };
        let evolution = EvolutionId::numbered(job.id().number);
        let news = bred.into_iter().map(|generation| {
            let event = Event::generation(evolution.clone(), generation);
            (event.id, written(&event))
        });
        Some(news.collect())
    }
}

/// An event as the stream has it. A state has no id there: it would count generations as told.
fn written(event: &Event) -> Result<sse::Event, axum::Error> {
    let mut written = sse::Event::default().event(event.kind.name());
    if matches!(event.kind, Kind::Generation { .. }) {
        written = written.id(event.id.to_string());
    }
    written.json_data(event)
}
