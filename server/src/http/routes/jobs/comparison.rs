//! What comparisons alone have: figures, trials and a report for people.

use super::{Made, Named, Resource, figure as figure_of};
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::documents::Name;
use crate::jobs::{Job, Jobs};
use crate::resource::failure::{self, Failure};
use axum::extract::{Path, State};
use axum::http::HeaderMap;
use std::collections::HashMap;
use std::convert::Infallible;
use std::sync::Arc;
use umwelt_api::comparison::{self, Figure, Request};
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_api::{Checked, PriorId};
use umwelt_lab::comparison::{Comparison, ComparisonSettings, Distribution};
use umwelt_lab::figures::comparison::svg;
use umwelt_lab::wire;
use umwelt_lab::{csv, report};

pub(crate) async fn figure(
    State(app): State<App>,
    Named(job): Named<Comparison>,
    Path(path): Path<HashMap<String, String>>,
    headers: HeaderMap,
) -> Result {
    let figure = figure_of(&path, Figure::named, &Figure::ALL.map(Figure::name))?;
    let made = of_trials(&app, &job, &headers, figure.name(), Figure::MEDIA_TYPE)?;
    let draw = move |job: &Job<Comparison>, distributions: &[Distribution]| {
        svg(figure, &job.id().to_string(), &job.shown().record.settings, distributions)
    };
    made.of_parts(draw).await
}

/// Every trial, a contender in an environment at a time.
pub(crate) async fn trials(
    State(app): State<App>,
    Named(job): Named<Comparison>,
    headers: HeaderMap,
) -> Result {
    let made = of_trials(&app, &job, &headers, "trials.csv", comparison::TRIALS_MEDIA_TYPE)?;
    let write = |_: &Job<Comparison>, distributions: &[Distribution]| {
        let rows = distributions.iter().map(csv::rows);
        Ok::<_, Infallible>(std::iter::once(csv::header()).chain(rows).collect())
    };
    made.of_parts(write).await
}

/// What is made of the trials of a comparison that has succeeded.
fn of_trials<'a>(
    app: &'a App,
    job: &'a Arc<Job<Comparison>>,
    headers: &'a HeaderMap,
    what: &'static str,
    media_type: &'static str,
) -> Result<Made<'a, Comparison>, Failure> {
    succeeded(job)?;
    Ok(Made { app, job, headers, media_type, what, state: 0 })
}

/// The report for people.
pub(crate) async fn report(
    State(app): State<App>,
    Named(job): Named<Comparison>,
    headers: HeaderMap,
) -> Result {
    succeeded(&job)?;
    let name = Name { job: job.id(), what: "report.md", state: 0 };
    let write = move |()| {
        let record = Arc::clone(&job.shown().record);
        let Some(found) = &record.report else {
            return Err(failure::internal(format!("{} has no report", job.id())));
        };
        let found = comparison::Report::from(found);
        Ok(report::markdown(&record.settings, record.own.as_str(), &found))
    };
    let ready = std::future::ready(Ok(()));
    let report = app.documents.get(name, comparison::REPORT_MEDIA_TYPE, ready, write).await?;
    Ok(report.answer(&headers))
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
    fn read(app: &App, body: &[u8]) -> Result<(Checked<Request>, ComparisonSettings), Problems> {
        wire::comparison::read(body, |name| app.priors.known(name))
    }

    fn own(
        _: &App,
        _: &Jobs<Self>,
        request: &Request,
        next: u64,
    ) -> Result<(u64, PriorId), Failure> {
        Ok((next, request.prior_name().parse()?))
    }
}
