//! What evolutions alone have: generations and their figures, and names for champions.

use super::{Made, Named, Resource, figure as figure_of, parts};
use crate::http::answer;
use crate::http::answer::Result;
use crate::http::app::App;
use crate::http::routes::page::{self, Query};
use crate::jobs::evolution::claim;
use crate::jobs::{Job, Jobs, Shown};
use crate::resource::failure::Failure;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use std::collections::HashMap;
use tokio::sync::OwnedRwLockWriteGuard;
use umwelt_api::Checked;
use umwelt_api::evolution::{self, Event, Generation, GenerationsPage, Request};
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_api::{EvolutionId, PriorId};
use umwelt_lab::evolution::{Evolution, EvolutionSettings};
use umwelt_lab::figures::evolution::{Figure, svg};
use umwelt_lab::wire;

/// Generations that are read for a stream at a time.
const AT_A_TIME: usize = 50;

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
    /// It would count generations as sent.
    const STATES_HAVE_IDS: bool = false;

    /// Until it is queued, nothing else takes the name that its champion is to have.
    async fn names(app: &App) -> Option<OwnedRwLockWriteGuard<()>> {
        Some(app.priors.changing().await)
    }

    fn read(app: &App, body: &[u8]) -> Result<(Checked<Request>, EvolutionSettings), Problems> {
        wire::evolution::read(body, |name| app.environments.known(name))
    }

    fn own(
        app: &App,
        jobs: &Jobs<Self>,
        request: &Request,
        next: u64,
    ) -> Result<(u64, PriorId), Failure> {
        let prior = request.prior.as_deref().map(str::parse).transpose()?;
        claim(jobs, &app.priors, prior, next)
    }

    /// Every generation once, in order. The id of an event is the number of generations that have ended.
    async fn events_after(
        app: &App,
        job: &Job<Self>,
        shown: &Shown<Self>,
        last: u64,
    ) -> Option<Vec<Event>> {
        if shown.generations() <= last {
            return Some(Vec::new());
        }
        let from = usize::try_from(last).ok()?;
        let generations = match parts(app, job, from, AT_A_TIME, |it| Generation::from(it)).await {
            Ok(generations) if !generations.is_empty() => generations,
            // Forgotten meanwhile.
            Ok(_) => return None,
            Err(failure) => {
                let error = failure.message();
                tracing::error!(job = %job.id(), kind = "evolution", error, "cannot read job events");
                return None;
            }
        };
        let evolution = EvolutionId::numbered(job.id().number);
        let event = |generation| Event::generation(evolution.clone(), generation);
        Some(generations.into_iter().map(event).collect())
    }
}
