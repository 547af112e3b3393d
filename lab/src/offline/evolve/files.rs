//! The files of an offline evolution: what `umwelt prior put` takes, the report, the generations and their figures.

use super::{Error, Outcome};
use crate::evolution::{EvolutionSettings, Generation};
use crate::figures::evolution::{Figure, svg};
use crate::offline::folder::{put, put_figure};
use crate::offline::pretty;
use std::fmt::Write;
use std::path::Path;
use umwelt_api::evolution::Generation as Shown;
use umwelt_api::prior;

/// Fills the folder.
pub(super) fn write(
    folder: &Path,
    outcome: &Outcome,
    settings: &EvolutionSettings,
    generations: &[Generation],
) -> Result<(), Error> {
    put(folder, "prior.json", &pretty("prior.json", &champion(outcome))?)?;
    put(folder, "report.json", &outcome.json()?)?;
    put(folder, "generations.csv", &csv(generations))?;
    let name = format!("{}-{}", outcome.preset.name(), outcome.seed);
    for figure in Figure::ALL {
        put_figure(folder, figure.name(), svg(figure, &name, settings, generations))?;
    }
    Ok(())
}

/// The champion as it is put to a server.
fn champion(outcome: &Outcome) -> prior::Spec {
    let (preset, seed, mean) = (outcome.preset.name(), outcome.seed, outcome.fitness.mean);
    let optimizer = outcome.spec.optimizer.name();
    let note = format!(
        "umwelt-server {} evolve: preset {preset}, {optimizer}, seed {seed}; fitness {mean:.3}",
        outcome.version
    );
    prior::Spec { note: Some(note), ..outcome.champion.prior.into() }
}

/// One line per generation; the columns are those of the contract, by environment.
fn csv(generations: &[Generation]) -> String {
    let generations: Vec<Shown> = generations.iter().map(Shown::from).collect();
    let mut text = "generation,best_fitness,mean_fitness".to_owned();
    let environments = generations.first().map(|it| &it.environments[..]).unwrap_or_default();
    for environment in environments {
        for column in
            ["best_deviation_m", "mean_deviation_m", "best_time_s", "mean_time_s", "arrived"]
        {
            // Writing to a String cannot fail.
            let _ = write!(text, ",{}_{column}", environment.environment);
        }
    }
    text.push('\n');
    for Shown { index, best_fitness, mean_fitness, environments, .. } in &generations {
        let _ = write!(text, "{index},{best_fitness},{mean_fitness}");
        for it in environments {
            let (deviation, mean_deviation) = (it.best_deviation_m, it.mean_deviation_m);
            let (time, mean_time, arrived) = (it.best_time_s, it.mean_time_s, it.arrived);
            let _ = write!(text, ",{deviation},{mean_deviation},{time},{mean_time},{arrived}");
        }
        text.push('\n');
    }
    text
}
