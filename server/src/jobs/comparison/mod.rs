//! Comparisons of methods: what they are among the jobs of the server.

mod kept;
mod wire;

use crate::jobs::Work;
use crate::store::StoredKind;
use crate::store::document::Form;
use umwelt_api::PriorId;
use umwelt_lab::comparison::{Comparison, ComparisonSettings};

impl Work for Comparison {
    const KIND: StoredKind = StoredKind::Comparison;
    const FORM: &'static Form = &kept::FORM;
    type Spec = kept::Spec;
    /// The name of the prior of the contender `bayesian`, whose values the settings hold.
    type Own = PriorId;
    type Services = ();

    fn spec(settings: &ComparisonSettings) -> kept::Spec {
        settings.into()
    }

    fn settings_of(spec: &kept::Spec) -> Result<ComparisonSettings, String> {
        spec.convert()
    }
}

#[cfg(test)]
mod tests;
