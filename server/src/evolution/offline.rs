//! `umwelt-server evolve`: an evolution from beginning to end, without a server and at normal priority.
//!
//! Invariants: it is what the server runs, so the same request and seed give the same champion; what is wrong with
//! the request is said as the server says it, all of it at once; nothing is written before there is a champion but
//! the folder that it goes to.

mod files;
mod outcome;
mod progress;
mod text;

pub use outcome::Outcome;

use crate::jobs::{Meter, Pool, Priority};
use progress::Progress;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;
use umwelt_api::Problems;
use umwelt_api::evolution::Request;
use umwelt_api::training;
use umwelt_core::evolution::{Evolution, Generation};

/// What is to be evolved, and where the result goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// What a server would be asked for.
    pub request: Request,
    /// Threads to use; all cores where none are said.
    pub threads: Option<usize>,
    /// Whether the output is to be JSON rather than text.
    pub json: bool,
    /// A folder to be filled with the prior, the report, the generations and their figures.
    pub folder: Option<PathBuf>,
}

/// Why there is no champion.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The request makes no sense.
    #[error("the evolution cannot run: {0}")]
    Invalid(#[from] Problems),
    /// It broke off.
    #[error("the evolution broke off: {0}")]
    BrokenOff(String),
    /// Its result could not be written.
    #[error("{what}: {error}")]
    Unwritten {
        /// What could not be written.
        what: String,
        /// Why.
        error: io::Error,
    },
}

/// Evolves a prior and writes what came of it to `output`; progress goes to standard error.
///
/// # Errors
/// Where the request makes no sense, the evolution breaks off or the result cannot be written.
pub fn evolve(order: &Order, output: &mut dyn Write) -> Result<(), Error> {
    let settings = order.request.to_core(training::built_in)?;
    let evolution =
        Evolution::new(settings).map_err(|error| Error::BrokenOff(error.to_string()))?;
    let pool = Pool::new(order.threads, Priority::Normal);
    let pool = pool.map_err(|error| Error::BrokenOff(error.to_string()))?;
    if let Some(folder) = &order.folder {
        // Now rather than after an hour.
        files::prepare(folder)?;
    }
    let begin = Instant::now();
    let (evolution, generations) = run(evolution, &pool)?;
    let wall_time = begin.elapsed();
    let outcome = Outcome::new(&order.request, &evolution, pool.threads(), wall_time)?;
    if let Some(folder) = &order.folder {
        files::write(folder, &outcome, evolution.settings(), &generations)?;
    }
    let text = if order.json { outcome.json()? } else { text::of(&outcome) };
    let unwritten = |error| Error::Unwritten { what: "standard output".to_owned(), error };
    output.write_all(text.as_bytes()).and_then(|()| output.flush()).map_err(unwritten)
}

/// Goes on to the end, and shows how far it has got.
fn run(mut evolution: Evolution, pool: &Pool) -> Result<(Evolution, Vec<Generation>), Error> {
    let meter = Meter::default();
    let progress = Progress::begin(&evolution);
    let mut generations = Vec::new();
    progress.follow(&meter, || -> Result<(), Error> {
        while evolution.report().is_none() {
            let ended = pool.step(&mut evolution, &meter);
            let told = ended.map_err(|halt| Error::BrokenOff(halt.to_string()))?;
            generations.extend(told.parts.into_iter().map(|(_, generation)| generation));
            progress.say(&evolution, generations.last());
        }
        Ok(())
    })?;
    Ok((evolution, generations))
}
