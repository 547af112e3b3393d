//! What an offline evolution says at its end: in the words of the contract, so that both ways say the same.

use super::Error;
use crate::evolution::Evolution;
use crate::offline::{Done, pretty};
use crate::wire;
use serde::Serialize;
use umwelt_api::evolution::{Champion, Entry, Estimate, Preset, Request, Spec};

/// The result of an offline evolution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Outcome {
    /// The preset of which the settings are a change.
    pub(super) preset: Preset,
    /// What was asked for, all filled in.
    pub(super) spec: Spec,
    /// The seed, which is in the settings too: it is what one repeats it with.
    pub(super) seed: u64,
    /// What it found: the field `champion` of `GET /v1/evolutions/{evolution}`.
    pub(super) champion: Champion,
    /// The champion's fitness, which is in its entry too.
    pub(super) fitness: Estimate,
    /// Simulated episodes driven.
    pub(super) episodes: u64,
    /// Threads used.
    pub(super) threads: usize,
    /// Time it took.
    pub(super) wall_time_s: f64,
    /// Version of the program: another one may find another champion.
    pub(super) version: &'static str,
}

impl Outcome {
    pub(super) fn new(request: &Request, done: &Done<Evolution>) -> Result<Self, Error> {
        let evolution = &done.work;
        let missing = || Error::BrokenOff("there is no report".to_owned());
        let champion = Champion::from(evolution.report().ok_or_else(missing)?);
        let fitness = champion.entries.first().ok_or_else(missing)?.fitness;
        let spec = wire::evolution::spec(evolution.settings(), request.prior.as_deref());
        Ok(Self {
            preset: request.preset.unwrap_or_default(),
            seed: spec.seed,
            spec,
            champion,
            fitness,
            episodes: evolution.episodes(),
            threads: done.threads,
            wall_time_s: done.wall_time.as_secs_f64(),
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    /// What the champion has to beat.
    pub(super) fn others(&self) -> &[Entry] {
        self.champion.entries.get(1..).unwrap_or_default()
    }

    /// One JSON object on several lines.
    pub(super) fn json(&self) -> Result<String, Error> {
        pretty("the report", self)
    }
}
