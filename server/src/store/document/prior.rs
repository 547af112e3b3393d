//! A named prior as it is kept.

use super::{Form, Unfit, Unreadable, former};
use crate::store::StoredPrior;
use serde::{Deserialize, Serialize};
use umwelt_api::prior::{Source, Spec};

/// How priors are kept. Version 1 had the note beside the values.
pub(crate) const FORM: Form =
    Form { is_within: false, upgrades: &[former::prior], base: include_str!("base/prior.json") };

#[derive(Serialize, Deserialize)]
struct Content {
    prior: Spec,
    source: Source,
}

/// The body of a prior.
pub(crate) fn of_prior(prior: &StoredPrior) -> Result<String, Unfit> {
    let unfit = Unfit { what: "a prior" };
    let StoredPrior { name, prior: values, note, source } = prior.clone();
    let spec = Spec { note, ..umwelt_api::robot::Prior::from(values).into() };
    let Ok(body) = FORM.write(&Content { prior: spec, source }) else { return Err(unfit) };
    let is_exact = self::prior(name, &body).is_ok_and(|read| read == *prior);
    if is_exact { Ok(body) } else { Err(unfit) }
}

/// The prior of a body.
pub(crate) fn prior(name: String, body: &str) -> Result<StoredPrior, Unreadable> {
    FORM.read_with(body, |content| {
        let content: Content = serde_json::from_value(content).map_err(|it| it.to_string())?;
        let Content { prior, source } = content;
        let values = prior.values().convert().map_err(|error| error.to_string())?;
        Ok::<_, String>(StoredPrior { name, prior: values, note: prior.note, source })
    })
}
