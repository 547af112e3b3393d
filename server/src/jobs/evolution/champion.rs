//! The champion of an evolution: the name that it will have, and the prior that it becomes.
//!
//! Invariant: no two evolutions that have not ended give their champions the same name, and none that of a prior.

use crate::jobs::{Jobs, SuccessEffect};
use crate::library::priors::{Named, Priors};
use crate::resource::failure::{self, Failure};
use crate::store::{Change, JobId};
use umwelt_api::prior::Source;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::{EvolutionId, PriorId};
use umwelt_lab::evolution::{Evolution, EvolutionSettings, Report};

/// The evolution that has not ended and will give its champion this name.
pub(crate) fn claimant(evolutions: &Jobs<Evolution>, name: &PriorId) -> Option<JobId> {
    let claims = evolutions.below(None).into_iter().find(|job| {
        let record = job.shown().record;
        !record.state.has_ended() && record.own == *name
    });
    claims.map(|job| job.id())
}

/// A number from `next` on for a new evolution and the name for its champion: the one that was asked for, or that of
/// the evolution. The caller holds the names of priors.
pub(crate) fn claim(
    evolutions: &Jobs<Evolution>,
    priors: &Priors,
    asked: Option<PriorId>,
    next: u64,
) -> Result<(u64, PriorId), Failure> {
    if let Some(name) = asked {
        check_free(evolutions, priors, &name)?;
        return Ok((next, name));
    }
    let mut own = (next..).filter_map(|number| {
        let name = EvolutionId::numbered(number).as_str().parse().ok()?;
        check_free(evolutions, priors, &name).is_ok().then_some((number, name))
    });
    own.next().ok_or_else(|| failure::internal("there are no more numbers"))
}

/// Whether a champion can have this name.
fn check_free(
    evolutions: &Jobs<Evolution>,
    priors: &Priors,
    name: &PriorId,
) -> Result<(), Failure> {
    let taken = if priors.has(name) {
        format!("there is a prior {name} already")
    } else if let Some(evolution) = claimant(evolutions, name) {
        format!("{evolution} will give its champion the name {name}")
    } else {
        return Ok(());
    };
    let detail = Detail::new(reason::NAME_TAKEN, "prior", name.as_str(), "choose another name");
    Err(Failure::new(Status::AlreadyExists, taken).with(detail))
}

/// The prior that the champion becomes.
pub(super) fn success_effect(
    priors: &Priors,
    id: JobId,
    name: &PriorId,
    settings: &EvolutionSettings,
    report: &Report,
) -> Option<SuccessEffect> {
    let source = Source::Evolution {
        evolution: EvolutionId::numbered(id.number),
        seed: settings.seed,
        optimizer: settings.optimizer.into(),
        fitness: report.entries.first().map(|champion| champion.fitness.mean),
    };
    let named = Named { id: name.clone(), prior: report.champion, note: None, source };
    let change = Change::PutPrior(named.stored()?);
    let priors = priors.clone();
    Some(SuccessEffect { change, publish: Box::new(move || priors.all().insert(named.clone())) })
}
