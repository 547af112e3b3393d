//! Evolutions of priors: what they are among the jobs of the server.

mod champion;
mod kept;
mod wire;

pub(crate) use champion::{claim, claimant};

use crate::jobs::{Gift, Record, Work};
use crate::library::priors::Priors;
use crate::store::document::Form;
use crate::store::{JobId, JobKind};
use umwelt_api::PriorId;
use umwelt_lab::evolution::{Evolution, EvolutionSettings};

impl Work for Evolution {
    const KIND: JobKind = JobKind::Evolution;
    const FORM: &'static Form = &kept::FORM;
    type Spec = kept::Spec;
    /// The name that the champion gets.
    type Own = PriorId;
    type House = Priors;

    fn spec(settings: &EvolutionSettings) -> kept::Spec {
        settings.into()
    }

    fn settings(spec: &kept::Spec) -> Result<EvolutionSettings, String> {
        spec.convert()
    }

    fn gift(priors: &Priors, id: JobId, record: &Record<Self>) -> Option<Gift> {
        champion::gift(priors, id, record)
    }
}

#[cfg(test)]
mod tests;
