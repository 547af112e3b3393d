//! A kind of job as HTTP has it.

use crate::http::app::App;
use crate::jobs::{Job, Jobs, Shown, Work};
use axum::response::sse;
use serde::Serialize;
use std::str::FromStr;
use umwelt_api::InvalidId;
use umwelt_api::page::Unreadable;

/// A kind of job as the wire has it.
pub(crate) trait Resource: Work {
    /// What names one.
    type Id: FromStr<Err = InvalidId> + AsRef<str> + Send;
    /// A job.
    type Wire: Serialize;

    /// All of the kind.
    fn jobs(app: &App) -> &Jobs<Self>;

    /// As the wire has it.
    fn wire(job: &Job<Self>) -> Self::Wire;

    /// The same in a list.
    fn listed(job: &Job<Self>) -> Self::Wire {
        Self::wire(job)
    }

    /// A page of a list.
    fn page(
        jobs: Vec<Self::Wire>,
        unreadable: Vec<Unreadable>,
        next_page_token: Option<String>,
    ) -> impl Serialize;

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
