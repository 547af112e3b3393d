//! `umwelt evolution`.

mod plot;
pub(super) mod report;

use super::failure::Failure;
use super::input;
use super::job::{Noun, STATES, described, episodes, noun, time_left};
use super::output::Output;
use super::progress::{say, wait};
use super::quantity::{UNKNOWN, millimetres, of_arrivals, or_unknown, percent, span};
use super::table::{Column, Table};
use clap::Subcommand;
use futures_util::TryStreamExt;
use std::fmt::Write;
use umwelt_api::EvolutionId;
use umwelt_api::evolution::{
    Evolution, EvolutionKind, GenerationsPage, Progress, Spec, Stage, State,
};
use umwelt_client::Client;

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List evolutions, the newest first
    List {
        /// Only evolutions in this state
        #[arg(long, value_parser = input::named::<State>(STATES))]
        state: Option<State>,
    },
    /// Show an evolution: what was asked for, how far it has got, what it found
    #[command(after_help = report::ABOUT)]
    Show {
        /// The evolution
        #[arg(value_name = "ID")]
        evolution: EvolutionId,
    },
    /// Show progress until it has ended, then what it found; Ctrl-C ends the watching alone
    #[command(after_help = "Example:\n  umwelt evolution watch evolution-12")]
    Watch {
        /// The evolution
        #[arg(value_name = "ID")]
        evolution: EvolutionId,
    },
    /// List the generations of an evolution, environment by environment
    #[command(after_help = "\
Example:
  umwelt --json evolution generations evolution-12 | jq -r '.generations[] | [.index, .best_fitness] | @csv'")]
    Generations {
        /// The evolution
        #[arg(value_name = "ID")]
        evolution: EvolutionId,
    },
    /// Write its figures as SVG: deviation and time, best and mean of each generation
    #[command(after_help = plot::ABOUT)]
    Plot(plot::Plot),
    /// Cancel an evolution; its generations stay
    Cancel {
        /// The evolution
        #[arg(value_name = "ID")]
        evolution: EvolutionId,
    },
    /// Remove an evolution that has ended, with its generations; a prior that it found stays
    Remove {
        /// The evolution
        #[arg(value_name = "ID")]
        evolution: EvolutionId,
    },
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::List { state } => noun::list::<EvolutionKind>(client, output, state).await,
            Self::Show { evolution } => {
                noun::show::<EvolutionKind>(client, output, &evolution).await
            }
            Self::Watch { evolution } => {
                noun::watch::<EvolutionKind>(client, output, &evolution).await
            }
            Self::Generations { evolution } => {
                let generations = wait(client.generations(&evolution).try_collect()).await?;
                let page = GenerationsPage { generations, next_page_token: None };
                if page.generations.is_empty() {
                    say(&format!("no generation of {evolution} has ended yet"));
                }
                output.result(&page, generations_table)
            }
            Self::Plot(plot) => plot.run(client, output).await,
            Self::Cancel { evolution } => {
                noun::cancel::<EvolutionKind>(client, output, &evolution).await
            }
            Self::Remove { evolution } => {
                noun::remove::<EvolutionKind>(client, output, &evolution).await
            }
        }
    }
}

impl Noun for EvolutionKind {
    const VERB: &'static str = "evolve";

    /// How far an evolution has got, as `generation 5/30, best 1.320, mean 1.104, 12.0 s left`.
    fn words(progress: &Progress) -> String {
        let Progress { generation, generations, .. } = progress;
        let mut text = match progress.stage {
            Stage::Queued => "waiting for its turn".to_owned(),
            Stage::Reference => "driving the fixed model that sets the unit of fitness".to_owned(),
            Stage::Generations => format!("generation {generation}/{generations}"),
            Stage::Selection => "choosing the champion on fresh seeds".to_owned(),
            Stage::Report => "measuring the champion on third seeds".to_owned(),
            Stage::Done => format!("{generations} generations"),
        };
        if let (Some(best), Some(mean)) = (progress.best_fitness, progress.mean_fitness) {
            let _ = write!(text, ", best {best:.3}, mean {mean:.3}");
        }
        if progress.stage != Stage::Done {
            text += &time_left(progress.remaining_s);
        }
        text
    }

    fn table(evolutions: &[Evolution]) -> String {
        let mut table = Table::new([
            Column::Text("EVOLUTION"),
            Column::Text("STATE"),
            Column::Number("GENERATION"),
            Column::Number("BEST"),
            Column::Number("MEAN"),
            Column::Number("RAN FOR"),
            Column::Text("OPTIMIZER"),
            Column::Number("SEED"),
            Column::Text("PRIOR"),
        ]);
        for evolution in evolutions {
            let Evolution { progress, spec, .. } = evolution;
            let fitness = |value| or_unknown(value, |value: f64| format!("{value:.3}"));
            table.row([
                evolution.id.to_string(),
                evolution.state.name().to_owned(),
                format!("{}/{}", progress.generation, progress.generations),
                fitness(progress.best_fitness),
                fitness(progress.mean_fitness),
                span(progress.elapsed_s),
                spec.optimizer.name().to_owned(),
                spec.seed.to_string(),
                or_unknown(evolution.outcome.prior.as_ref(), ToString::to_string),
            ]);
        }
        table.to_string()
    }

    fn show(evolution: &Evolution) -> String {
        let Evolution { spec, progress, .. } = evolution;
        let lines = [
            ("environments", spec.environments.join(", ")),
            ("search", search(spec)),
            ("episodes", episodes(evolution, progress.elapsed_s)),
            ("prior", kept(evolution)),
        ];
        let mut text = described(evolution, &lines);
        if let Some(champion) = &evolution.outcome.champion {
            let _ = write!(text, "\n{}", report::text(champion));
        }
        text
    }
}

fn search(spec: &Spec) -> String {
    let Spec { population, generations, trials, seed, horizon_slots, .. } = spec;
    format!(
        "{}, {generations} generations of {population}, {trials} trials each, seed {seed}, {horizon_slots} slots",
        spec.optimizer.name()
    )
}

/// Under what name the champion is kept.
fn kept(evolution: &Evolution) -> String {
    match (&evolution.outcome.prior, &evolution.spec.prior) {
        (Some(name), _) => format!("{name}; use it: umwelt robot set ID --prior {name}"),
        (None, Some(name)) if !evolution.state.has_ended() => {
            format!("{name}, once there is a champion")
        }
        (None, Some(name)) => format!("none; it was to be {name}"),
        (None, None) => UNKNOWN.to_owned(),
    }
}

fn generations_table(page: &GenerationsPage) -> String {
    if page.generations.is_empty() {
        return String::new();
    }
    let mut table = Table::new([
        Column::Number("GENERATION"),
        Column::Number("BEST"),
        Column::Number("MEAN"),
        Column::Text("ENVIRONMENT"),
        Column::Number("BEST DEVIATION"),
        Column::Number("MEAN DEVIATION"),
        Column::Number("BEST TIME"),
        Column::Number("MEAN TIME"),
        Column::Number("ARRIVED"),
    ]);
    for generation in &page.generations {
        for (index, environment) in generation.environments.iter().enumerate() {
            let known = |text| of_arrivals(environment.arrived, text);
            let once = |text: String| if index == 0 { text } else { String::new() };
            table.row([
                once(generation.index.to_string()),
                once(format!("{:.3}", generation.best_fitness)),
                once(format!("{:.3}", generation.mean_fitness)),
                environment.environment.clone(),
                known(millimetres(environment.best_deviation_m)),
                known(millimetres(environment.mean_deviation_m)),
                known(format!("{:.1} s", environment.best_time_s)),
                known(format!("{:.1} s", environment.mean_time_s)),
                percent(environment.arrived),
            ]);
        }
    }
    table.to_string()
}

#[cfg(test)]
mod tests;
