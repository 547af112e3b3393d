//! What is in the bodies that the store understands: JSON with a version, apart from the wire's and from core's own.
//!
//! Core's forms of settings, task, prior and saved state are taken as they are within; a test holds a file of version 1,
//! so that a change of them is seen and gets a version of its own.

use crate::store::{PriorSource, Record, StoredPrior};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use umwelt_core::controller::Saved;
use umwelt_core::settings::{Prior, Settings};
use umwelt_core::task::Task;

/// Version of the documents of robots and of priors.
const VERSION: u32 = 1;

/// Something that would not be read back as it is.
#[derive(Debug, thiserror::Error)]
#[error("{what} cannot be written down exactly")]
pub(super) struct Unfit {
    what: &'static str,
}

/// Why a document cannot be read.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unreadable {
    /// It is of a newer program.
    #[error("it is of version {0}, this program knows up to {VERSION}")]
    Newer(u32),
    /// It is no such document.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
}

#[derive(Deserialize)]
struct Version {
    version: u32,
}

#[derive(Serialize, Deserialize)]
struct Robot {
    version: u32,
    settings: Settings,
    prior: Option<String>,
    task: Option<Task>,
    stopped: bool,
}

#[derive(Serialize, Deserialize)]
struct NamedPrior {
    version: u32,
    prior: Prior,
    note: Option<String>,
    source: Source,
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Source {
    Put,
    Evolution { evolution: String, seed: u64, optimizer: String, fitness: f64 },
}

pub(super) fn of_record(record: &Record) -> Result<String, Unfit> {
    let Record { settings, prior, task, stopped, .. } = record.clone();
    let text = written("a robot", &Robot { version: VERSION, settings, prior, task, stopped })?;
    let is_exact = self::record(&text, record.revision).is_ok_and(|read| read == *record);
    if is_exact { Ok(text) } else { Err(Unfit { what: "a robot" }) }
}

pub(super) fn record(text: &str, revision: u64) -> Result<Record, Unreadable> {
    let Robot { settings, prior, task, stopped, .. } = read(text)?;
    Ok(Record { settings, prior, task, stopped, revision })
}

pub(super) fn of_prior(prior: &StoredPrior) -> Result<String, Unfit> {
    let StoredPrior { name, prior: values, note, source } = prior.clone();
    let source = match source {
        PriorSource::Put => Source::Put,
        PriorSource::Evolution { evolution, seed, optimizer, fitness } => {
            Source::Evolution { evolution, seed, optimizer, fitness }
        }
    };
    let document = NamedPrior { version: VERSION, prior: values, note, source };
    let text = written("a prior", &document)?;
    let is_exact = self::prior(name, &text).is_ok_and(|read| read == *prior);
    if is_exact { Ok(text) } else { Err(Unfit { what: "a prior" }) }
}

pub(super) fn prior(name: String, text: &str) -> Result<StoredPrior, Unreadable> {
    let NamedPrior { prior, note, source, .. } = read(text)?;
    let source = match source {
        Source::Put => PriorSource::Put,
        Source::Evolution { evolution, seed, optimizer, fitness } => {
            PriorSource::Evolution { evolution, seed, optimizer, fitness }
        }
    };
    Ok(StoredPrior { name, prior, note, source })
}

/// What a robot has learned; its version stands beside it.
pub(super) fn of_saved(saved: &Saved) -> Result<String, Unfit> {
    written("what a robot has learned", saved)
}

pub(super) fn saved(text: &str) -> Result<Saved, Unreadable> {
    Ok(serde_json::from_str(text)?)
}

fn written(what: &'static str, document: &impl Serialize) -> Result<String, Unfit> {
    serde_json::to_string(document).map_err(|_| Unfit { what })
}

fn read<T: DeserializeOwned>(text: &str) -> Result<T, Unreadable> {
    let Version { version } = serde_json::from_str(text)?;
    if version > VERSION {
        return Err(Unreadable::Newer(version));
    }
    Ok(serde_json::from_str(text)?)
}
