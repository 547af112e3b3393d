//! What tells one kind of job from another.

use crate::store::document::Form;
use crate::store::{Change, JobId, StoredKind};
use umwelt_lab::work::Plain;

/// The work of lab as the server keeps it: what it is among jobs, and how its settings are written down.
pub(crate) trait Work: umwelt_lab::work::Work {
    /// Its kind.
    const KIND: StoredKind;
    /// How its record is kept: what leads to today's form, and what missing settings mean.
    const FORM: &'static Form;
    /// Its settings as they are kept: specs of the wire, and what names stood for when they were given.
    type Spec: Plain;
    /// What is its own beside that: names that the server gives a meaning.
    type Own: Plain;
    /// What the effect of a success needs of the rest of the server.
    type Services: Send + Sync + 'static;

    /// Settings as they are kept.
    fn spec(settings: &Self::Settings) -> Self::Spec;

    /// The settings that are kept.
    ///
    /// # Errors
    /// What in them means nothing.
    fn settings_of(spec: &Self::Spec) -> Result<Self::Settings, String>;

    /// What a success changes beside the record of the job.
    fn success_effect(
        _services: &Self::Services,
        _id: JobId,
        _own: &Self::Own,
        _settings: &Self::Settings,
        _report: &Self::Report,
    ) -> Option<SuccessEffect> {
        None
    }
}

/// What a success changes in the rest of the server.
pub(crate) struct SuccessEffect {
    /// Kept in the same commit as the success.
    pub(crate) change: Change,
    /// Called once that is kept, before the success shows.
    pub(crate) publish: Box<dyn Fn() + Send + Sync>,
}
