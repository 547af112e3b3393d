//! Comparisons: submitted, their trials, and what is theirs alone of what all jobs have.

use super::jobs::{
    Resource, drawn, figure as figure_of, idempotency_key, parts, repeated, submitted,
};
use crate::app::App;
use crate::comparison::{csv, report};
use crate::etag;
use crate::extract::{Body, Named};
use crate::failure::{self, Failure, Result};
use crate::figures::comparison::svg;
use crate::fleet::to_the_end;
use crate::jobs::{Job, Jobs, Shown, Submission};
use axum::body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, sse};
use futures_util::{StreamExt, stream};
use serde::Serialize;
use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use umwelt_api::ComparisonId;
use umwelt_api::comparison::{self, Figure, Page, Request};
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_core::comparison::Comparison;

pub(crate) async fn submit(
    State(app): State<App>,
    headers: HeaderMap,
    Body(body): Body<{ comparison::MAX_BODY }>,
) -> Result {
    let key = idempotency_key(&headers)?;
    to_the_end(async move {
        let mut submitting = app.comparisons.submitting().await;
        if let Some(answer) = repeated(&submitting, key.as_ref(), Request::read(&body))? {
            return Ok(answer);
        }
        // It takes the prior as it is now.
        let (request, settings) = Request::read_known(&body, |name| app.priors.known(name))?;
        let prior = request.prior_name().parse()?;
        let submission = Submission { settings, key, request: etag::of(&request).to_string() };
        let job = submitting.submit(submission, |number| Ok((number, prior))).await?;
        Ok(submitted(StatusCode::CREATED, &job))
    })
    .await
}

pub(crate) async fn figure(
    State(app): State<App>,
    Named(job): Named<Comparison>,
    Path(path): Path<HashMap<String, String>>,
) -> Result {
    let figure = figure_of(&path, Figure::named, &Figure::ALL.map(Figure::name))?;
    succeeded(&job)?;
    let distributions = parts(&app, &job, 0, usize::MAX, Clone::clone).await?;
    let name = job.id().to_string();
    drawn(Figure::MEDIA_TYPE, move || {
        svg(figure, &name, &job.shown().record.settings, &distributions)
    })
    .await
}

/// Every trial, a contender in an environment at a time.
pub(crate) async fn trials(State(app): State<App>, Named(job): Named<Comparison>) -> Result {
    succeeded(&job)?;
    let settings = &job.shown().record.settings;
    let count = settings.environments.len() * settings.contenders.len();
    let rows = stream::iter(0..count).then(move |index| rows(app.clone(), Arc::clone(&job), index));
    let lines = stream::iter([Ok(csv::header())]).chain(rows);
    let content_type = [(header::CONTENT_TYPE, comparison::TRIALS_MEDIA_TYPE)];
    Ok((content_type, body::Body::from_stream(lines)).into_response())
}

/// The lines of one contender in one environment. An error cuts the answer off where it is.
async fn rows(app: App, job: Arc<Job<Comparison>>, index: usize) -> io::Result<String> {
    let rows = parts(&app, &job, index, 1, csv::rows).await;
    let rows = rows.map_err(|failure| io::Error::other(failure.message().to_owned()))?;
    let gone = || io::Error::other(format!("{} was removed meanwhile", job.id()));
    rows.into_iter().next().ok_or_else(gone)
}

/// The report for people.
pub(crate) async fn report(Named(job): Named<Comparison>) -> Result {
    succeeded(&job)?;
    let record = Arc::clone(&job.shown().record);
    let Some(found) = &record.report else {
        return Err(failure::internal(format!("{} has no report", job.id())));
    };
    let found = comparison::Report::from(found);
    let text = report::markdown(&record.settings, record.own.as_str(), &found);
    Ok(([(header::CONTENT_TYPE, comparison::REPORT_MEDIA_TYPE)], text).into_response())
}

/// Whether there is something to show: before its end, and after another one, nothing is.
fn succeeded(job: &Job<Comparison>) -> Result<(), Failure> {
    if job.shown().record.report.is_some() {
        return Ok(());
    }
    let id = job.id().to_string();
    let message = format!("{id} has not succeeded");
    let detail = Detail::new(reason::NOTHING_YET, "comparison", id, "ask again once it has");
    Err(Failure::new(Status::FailedPrecondition, message).with(detail))
}

impl Resource for Comparison {
    type Id = ComparisonId;
    type Wire = comparison::Comparison;

    fn jobs(app: &App) -> &Jobs<Self> {
        &app.comparisons
    }

    fn wire(job: &Job<Self>) -> comparison::Comparison {
        job.comparison()
    }

    /// A list of reports would have some MB.
    fn listed(job: &Job<Self>) -> comparison::Comparison {
        comparison::Comparison { report: None, ..job.comparison() }
    }

    fn page(
        comparisons: Vec<comparison::Comparison>,
        next_page_token: Option<String>,
    ) -> impl Serialize {
        Page { comparisons, next_page_token }
    }

    /// The id of an event is the number of trials that every contender has driven.
    fn event(job: &Job<Self>, shown: &Shown<Self>) -> Result<sse::Event, axum::Error> {
        let event = job.event(shown);
        let written = sse::Event::default().event(event.kind.name()).id(event.id.to_string());
        written.json_data(&event)
    }
}
