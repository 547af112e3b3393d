//! What tells one kind of job from another.

use super::record::Record;
use crate::store::document::Form;
use crate::store::{Change, JobId, JobKind};
use umwelt_lab::work::Plain;

/// The work of lab as the server keeps it: what it is among jobs, and how its settings are written down.
pub(crate) trait Work: umwelt_lab::work::Work {
    /// Its kind.
    const KIND: JobKind;
    /// How its record is kept: what leads to today's form, and what missing settings mean.
    const FORM: &'static Form;
    /// What it is told as it is kept: specs of the wire, and what names stood for when they were given.
    type Spec: Plain;
    /// What is its own beside that: names that the server gives a meaning.
    type Own: Plain;
    /// The part of the server that gets what a success gives.
    type House: Send + Sync + 'static;

    /// Settings as they are kept.
    fn spec(settings: &Self::Settings) -> Self::Spec;

    /// The settings that are kept.
    ///
    /// # Errors
    /// What in them means nothing.
    fn settings(spec: &Self::Spec) -> Result<Self::Settings, String>;

    /// What a success gives beside its report, which stands in the record.
    fn gift(_house: &Self::House, _id: JobId, _record: &Record<Self>) -> Option<Gift> {
        None
    }
}

/// What a success gives to the rest of the server.
pub(crate) struct Gift {
    /// Kept in the same commit as the success.
    pub(crate) change: Change,
    /// Called once it is kept, before the success shows.
    pub(crate) show: Box<dyn Fn() + Send + Sync>,
}
