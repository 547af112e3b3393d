//! What an offline comparison says at its end: in the words of the contract, so that both ways say the same.

use super::Error;
use crate::comparison::Comparison;
use crate::offline::{Done, pretty};
use crate::wire;
use serde::Serialize;
use umwelt_api::comparison::{Report, Request, Spec};

/// The result of an offline comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Outcome {
    /// What was asked for, all filled in.
    pub(super) spec: Spec,
    /// Its result: the field `report` of `GET /v1/comparisons/{comparison}`.
    pub(super) report: Report,
    /// Simulated episodes driven.
    pub(super) episodes: u64,
    /// Threads used.
    pub(super) threads: usize,
    /// Time it took.
    pub(super) wall_time_s: f64,
    /// Version of the program: another one may find other numbers.
    pub(super) version: &'static str,
}

impl Outcome {
    pub(super) fn new(request: &Request, done: &Done<Comparison>) -> Result<Self, Error> {
        let missing = || Error::BrokenOff("there is no report".to_owned());
        Ok(Self {
            spec: wire::comparison::spec(done.work.settings(), request.prior_name()),
            report: Report::from(done.work.report().ok_or_else(missing)?),
            episodes: done.work.episodes(),
            threads: done.threads,
            wall_time_s: done.wall_time.as_secs_f64(),
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    /// One JSON object on several lines.
    pub(super) fn json(&self) -> Result<String, Error> {
        pretty("the report", self)
    }
}
