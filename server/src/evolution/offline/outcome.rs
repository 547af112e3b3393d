//! What an offline evolution says at its end: in the words of the contract, so that both doors say the same.

use super::Error;
use serde::Serialize;
use std::io;
use std::time::Duration;
use umwelt_api::evolution::{Champion, Entry, Estimate, Preset, Request, Spec};
use umwelt_core::evolution::Evolution;

/// What came of an offline evolution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// The preset of which the settings are a change.
    pub preset: Preset,
    /// What it was told, all filled in.
    pub spec: Spec,
    /// The seed, which is in the settings too: it is what one repeats it with.
    pub seed: u64,
    /// What it found: the field `champion` of `GET /v1/evolutions/{evolution}`.
    pub champion: Champion,
    /// The champion's fitness, which is in its entry too.
    pub fitness: Estimate,
    /// Simulated episodes driven.
    pub episodes: u64,
    /// Threads used.
    pub threads: usize,
    /// Time it took.
    pub wall_time_s: f64,
    /// Version of the program: another one may find another champion.
    pub version: &'static str,
}

impl Outcome {
    pub(super) fn new(
        request: &Request,
        evolution: &Evolution,
        threads: usize,
        wall_time: Duration,
    ) -> Result<Self, Error> {
        let missing = || Error::BrokenOff("there is no report".to_owned());
        let champion = Champion::from(evolution.report().ok_or_else(missing)?);
        let fitness = champion.entries.first().ok_or_else(missing)?.fitness;
        let spec = Spec::from_core(evolution.settings(), request.prior.as_deref());
        Ok(Self {
            preset: request.preset.unwrap_or_default(),
            seed: spec.seed,
            spec,
            champion,
            fitness,
            episodes: evolution.episodes(),
            threads,
            wall_time_s: wall_time.as_secs_f64(),
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    /// What the champion has to beat.
    pub fn others(&self) -> &[Entry] {
        self.champion.entries.get(1..).unwrap_or_default()
    }

    /// One JSON object on several lines.
    pub(super) fn json(&self) -> Result<String, Error> {
        pretty("the report", self)
    }
}

/// `content` as JSON for people and programs.
pub(super) fn pretty(what: &str, content: &impl Serialize) -> Result<String, Error> {
    let json = serde_json::to_string_pretty(content).map_err(|error| Error::Unwritten {
        what: what.to_owned(),
        error: io::Error::other(error),
    })?;
    Ok(json + "\n")
}
