//! `umwelt-server compare`.

mod outcome;
mod text;

use super::{Error, Order, folder, say};
use crate::comparison::{Comparison, ComparisonSettings, Distribution, Stage};
use crate::figures::comparison::svg;
use crate::wire;
use crate::{csv, report};
use outcome::Outcome;
use std::io::Write;
use std::path::Path;
use umwelt_api::comparison::{Figure, Request};
use umwelt_api::prior;

/// Compares methods and writes its result to `output`; progress goes to standard error.
///
/// # Errors
/// Where the request makes no sense, the comparison breaks off or the result cannot be written.
pub fn compare(order: &Order<Request>, output: &mut dyn Write) -> Result<(), Error> {
    let settings = wire::comparison::settings(&order.request, prior::built_in)?;
    let done = super::run::<Comparison, _>(settings, order, |comparison, _| stage(comparison))?;
    let outcome = Outcome::new(&order.request, &done)?;
    if let Some(folder) = &order.folder {
        write(folder, &outcome, done.work.settings(), &done.parts)?;
    }
    say(&if order.json { outcome.json()? } else { text::of(&outcome) }, output)
}

/// What is being done.
fn stage(comparison: &Comparison) -> String {
    match comparison.stage() {
        Stage::Reference => "reference".to_owned(),
        Stage::Trials { done } => {
            format!("{done} of {} trials", comparison.settings().trials)
        }
        Stage::Done => "done".to_owned(),
    }
}

/// Fills the folder.
fn write(
    folder: &Path,
    outcome: &Outcome,
    settings: &ComparisonSettings,
    distributions: &[Distribution],
) -> Result<(), Error> {
    folder::put(folder, "report.json", &outcome.json()?)?;
    let rows = distributions.iter().map(csv::rows);
    let lines: String = std::iter::once(csv::header()).chain(rows).collect();
    folder::put(folder, "trials.csv", &lines)?;
    let prior = outcome.spec.prior.as_deref().unwrap_or_default();
    folder::put(folder, "compare.md", &report::markdown(settings, prior, &outcome.report))?;
    let name = format!("{}-{}", settings.scenario, settings.seed);
    for figure in Figure::ALL {
        folder::put_figure(folder, figure.name(), svg(figure, &name, settings, distributions))?;
    }
    Ok(())
}
