//! Evolutions of priors: what they are among the jobs of the server.

mod champion;
mod kept;
mod wire;

pub(crate) use champion::{claim, claimant};

use crate::jobs::{SuccessEffect, Work};
use crate::library::priors::Priors;
use crate::store::document::Form;
use crate::store::{JobId, StoredKind};
use umwelt_api::PriorId;
use umwelt_lab::evolution::{Evolution, EvolutionSettings, Report};

impl Work for Evolution {
    const KIND: StoredKind = StoredKind::Evolution;
    const FORM: &'static Form = &kept::FORM;
    type Spec = kept::Spec;
    /// The name that the champion gets.
    type Own = PriorId;
    type Services = Priors;

    fn spec(settings: &EvolutionSettings) -> kept::Spec {
        settings.into()
    }

    fn settings_of(spec: &kept::Spec) -> Result<EvolutionSettings, String> {
        spec.convert()
    }

    fn success_effect(
        priors: &Priors,
        id: JobId,
        name: &PriorId,
        settings: &EvolutionSettings,
        report: &Report,
    ) -> Option<SuccessEffect> {
        champion::success_effect(priors, id, name, settings, report)
    }
}

#[cfg(test)]
mod tests;
