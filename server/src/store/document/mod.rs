//! What a body in the store says: a form of our own, with a version, that follows the program upward.
//!
//! A body is `{"version": 2, "program": "0.1.0", ...}` with its content beside the version, or within `content` where it is
//! of a job. Contents are the specs of the wire, with what names stood for when they were given beside them; core is made
//! of them as at PUT, without the ranges of the day. So core's types change freely, and a kept thing never stops being
//! valid.
//!
//! - **A new field**: write what its absence meant into the base of its [`Form`] (`base/*.json`). A kept thing
//!   without the field means that, whatever the default for new ones is.
//! - **Another shape**: one more [`Upgrade`], and the base in the new shape. The golden files of every version
//!   (`golden` here and beside each kind of job) are read by a test; the file of the newest version is what is written today.
//!
//! What cannot be read is [`Unreadable`]: it is of a newer program, or of a broken one. It is no damage, which is what
//! checksums find.

mod base;
pub(crate) mod environment;
mod former;
pub(crate) mod prior;
pub(crate) mod robot;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use former::{job_settings, same};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// The version of this program, which stands in every body that it writes.
const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// Leads content from one version to the next. What is not there stays away: the base fills it in.
pub(crate) type Upgrade = fn(&mut Map<String, Value>);

/// How one kind of thing is kept.
#[derive(Debug)]
pub(crate) struct Form {
    /// Whether the content stands within a field of its own.
    pub(crate) is_within: bool,
    /// What leads from each version to the next, from 1 on.
    pub(crate) upgrades: &'static [Upgrade],
    /// JSON of the newest version: what it means where a field is missing.
    pub(crate) base: &'static str,
}

/// Why a body cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unreadable {
    /// A newer program wrote it.
    #[error("its form is of version {version}, this program reads 1 to {known}")]
    Newer {
        /// Of the body.
        version: u64,
        /// The newest that this program knows.
        known: u64,
        /// The version of the program that wrote it.
        program: Option<String>,
    },
    /// It is not what it should be.
    #[error("{what}")]
    Meaningless {
        /// What is wrong.
        what: String,
        /// The version of the program that wrote it; none before programs said so.
        program: Option<String>,
    },
}

impl Unreadable {
    /// The version of the program that wrote it, as far as that is known.
    pub(crate) fn written_by(&self) -> Option<&str> {
        match self {
            Self::Newer { program, .. } | Self::Meaningless { program, .. } => program.as_deref(),
        }
    }
}

/// Something that would not be read back as it is.
#[derive(Debug, thiserror::Error)]
#[error("{what} cannot be written down exactly")]
pub(crate) struct Unfit {
    what: &'static str,
}

/// A body with its content beside the version.
#[derive(Serialize)]
struct Beside<'a, T> {
    version: u64,
    program: &'a str,
    #[serde(flatten)]
    content: &'a T,
}

/// A body with its content within a field of its own.
#[derive(Serialize)]
struct Within<'a, T> {
    version: u64,
    program: &'a str,
    content: &'a T,
}

impl Form {
    /// The version that this program writes.
    pub(crate) const fn version(&self) -> u64 {
        self.upgrades.len() as u64 + 1
    }

    /// The body of `content`.
    pub(crate) fn write(&self, content: &impl Serialize) -> Result<String, serde_json::Error> {
        let (version, program) = (self.version(), PROGRAM);
        if self.is_within {
            serde_json::to_string(&Within { version, program, content })
        } else {
            serde_json::to_string(&Beside { version, program, content })
        }
    }

    /// What a body of any version up to today's says.
    pub(crate) fn read<T: DeserializeOwned>(&self, body: &str) -> Result<T, Unreadable> {
        self.read_with(body, T::deserialize)
    }

    /// The same, and what `make` makes of it.
    pub(crate) fn read_with<T, E: ToString>(
        &self,
        body: &str,
        make: impl FnOnce(Value) -> Result<T, E>,
    ) -> Result<T, Unreadable> {
        let (program, content) = self.content(body)?;
        make(content).map_err(|error| Unreadable::Meaningless { what: error.to_string(), program })
    }

    /// The content in today's form, and the version of the program that wrote it.
    fn content(&self, body: &str) -> Result<(Option<String>, Value), Unreadable> {
        let no_body = |what: String| Unreadable::Meaningless { what, program: None };
        let mut fields: Map<String, Value> = serde_json::from_str(body)
            .map_err(|error| no_body(format!("it is no body of a thing that is kept: {error}")))?;
        let program = fields.remove("program").and_then(|it| it.as_str().map(str::to_owned));
        let version = fields.remove("version").and_then(|version| version.as_u64());
        let version = version.ok_or_else(|| no_body("it has no version".to_owned()))?;
        let (known, meaningless) = (self.version(), |what: &str| Unreadable::Meaningless {
            what: what.to_owned(),
            program: program.clone(),
        });
        if version > known {
            return Err(Unreadable::Newer { version, known, program });
        }
        let mut content = match fields.remove("content") {
            None if !self.is_within => fields,
            Some(Value::Object(content)) if self.is_within => content,
            _ => return Err(meaningless("its content is not where it should be")),
        };
        let done = version.checked_sub(1).ok_or_else(|| meaningless("its version is 0"))?;
        let done = usize::try_from(done).unwrap_or(usize::MAX);
        self.upgrades[done..].iter().for_each(|upgrade| upgrade(&mut content));
        let mut content = Value::Object(content);
        base::fill(&mut content, self.base).map_err(|what| meaningless(&what))?;
        Ok((program, content))
    }
}
