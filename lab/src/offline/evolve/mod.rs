//! `umwelt-server evolve`.

mod files;
mod outcome;
mod text;

use super::{Error, Order, say};
use crate::evolution::{Evolution, Spread, Stage};
use crate::wire;
use outcome::Outcome;
use std::io::Write;
use umwelt_api::evolution::Request;

/// Evolves a prior and writes its result to `output`; progress goes to standard error.
///
/// # Errors
/// Where the request makes no sense, the evolution breaks off or the result cannot be written.
pub fn evolve(order: &Order<Request>, output: &mut dyn Write) -> Result<(), Error> {
    let settings = wire::evolution::settings(&order.request, wire::training::built_in)?;
    let done = super::run::<Evolution, _>(settings, order, stage)?;
    let outcome = Outcome::new(&order.request, &done)?;
    if let Some(folder) = &order.folder {
        files::write(folder, &outcome, done.work.settings(), &done.parts)?;
    }
    say(&if order.json { outcome.json()? } else { text::of(&outcome) }, output)
}

/// What is being done, and how well the last generation did.
fn stage(evolution: &Evolution, fitness: Option<&Spread>) -> String {
    let stage = match evolution.stage() {
        Stage::Reference => "reference".to_owned(),
        Stage::Generations { generation } => {
            format!("generation {} of {}", generation + 1, evolution.settings().generations)
        }
        Stage::Selection => "selection".to_owned(),
        Stage::Report => "report".to_owned(),
        Stage::Done => "done".to_owned(),
    };
    let fitness =
        fitness.map(|it| format!(", last fitness: best {:.3}, mean {:.3}", it.best, it.mean));
    stage + &fitness.unwrap_or_default()
}
