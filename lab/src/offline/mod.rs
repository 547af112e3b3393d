//! `umwelt-server evolve` and `compare`: jobs from beginning to end, without a server and at normal priority.
//!
//! Invariants: it is what the server runs, so the same request and seed give the same result; what is wrong with the
//! request is said as the server says it, all of it at once; nothing is written before there is a result but the folder
//! that it goes to.

mod compare;
mod error;
mod evolve;
mod folder;
mod progress;

pub use compare::compare;
pub use error::Error;
pub use evolve::evolve;

use crate::evaluator::Meter;
use crate::pool::{Pool, Priority};
use crate::work::Work;
use progress::Progress;
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What is to be done, and where the result goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order<R> {
    /// What a server would be asked for.
    pub request: R,
    /// Threads to use; all cores where none are said.
    pub threads: Option<usize>,
    /// Whether the output is to be JSON rather than text.
    pub json: bool,
    /// A folder to be filled with the result and its figures.
    pub folder: Option<PathBuf>,
}

/// What was done.
struct Done<W: Work> {
    work: W,
    /// What it has left, in its order.
    parts: Vec<W::Part>,
    threads: usize,
    wall_time: Duration,
}

/// Does what `order` says to the end, and shows how far it has got; `stage` says what is being done.
fn run<W: Work, R>(
    settings: W::Settings,
    order: &Order<R>,
    stage: impl Fn(&W, Option<&W::Latest>) -> String,
) -> Result<Done<W>, Error> {
    let mut work = W::new(settings).map_err(Error::BrokenOff)?;
    let pool = Pool::new(order.threads, Priority::Normal);
    let pool = pool.map_err(|error| Error::BrokenOff(error.to_string()))?;
    if let Some(folder) = &order.folder {
        // Now rather than after an hour.
        folder::prepare(folder)?;
    }
    let begin = Instant::now();
    let (meter, mut parts) = (Meter::default(), Vec::new());
    let progress = Progress::begin(stage(&work, None), work.total_episodes());
    progress.follow(&meter, || -> Result<(), Error> {
        let mut latest = None;
        while work.report().is_none() {
            if let Some(reason) = work.failure() {
                return Err(Error::Failed(reason));
            }
            let outcome = pool.step("offline", &mut work, &pool, &meter);
            let outcome = outcome.map_err(|halt| Error::BrokenOff(halt.to_string()))?;
            parts.extend(outcome.parts.into_iter().map(|(_, part)| part));
            latest = outcome.latest.or(latest);
            progress.say(stage(&work, latest.as_ref()), work.total_episodes());
        }
        Ok(())
    })?;
    Ok(Done { work, parts, threads: pool.threads(), wall_time: begin.elapsed() })
}

/// Writes a result to `output`.
fn say(text: &str, output: &mut dyn Write) -> Result<(), Error> {
    let unwritten = |error| Error::Unwritten { what: "standard output".to_owned(), error };
    output.write_all(text.as_bytes()).and_then(|()| output.flush()).map_err(unwritten)
}

/// `content` as JSON for people and programs, on several lines.
fn pretty(what: &str, content: &impl Serialize) -> Result<String, Error> {
    let json = serde_json::to_string_pretty(content).map_err(|error| Error::Unwritten {
        what: what.to_owned(),
        error: io::Error::other(error),
    })?;
    Ok(json + "\n")
}
