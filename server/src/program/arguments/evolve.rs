//! The command line of `umwelt-server evolve`.

use super::values::threads;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use umwelt_api::evolution::{self, Request};
use umwelt_lab::offline::Order;

/// What to evolve. What is left out comes from the preset.
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Evolve {
    /// Where the rest comes from.
    #[arg(long, value_enum, default_value = "default")]
    preset: Preset,
    /// Simulated environments, by name.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    environments: Option<Vec<String>>,
    /// Individuals of a generation.
    #[arg(long, value_name = "N")]
    population: Option<u64>,
    /// Generations.
    #[arg(long, value_name = "N")]
    generations: Option<u64>,
    /// Trials of each individual in each environment.
    #[arg(long, value_name = "N")]
    trials: Option<u64>,
    /// Fresh trials in each environment of each of those from whom the champion is chosen.
    #[arg(long, value_name = "N")]
    selection_trials: Option<u64>,
    /// Fresh trials in each environment on which the champion is reported.
    #[arg(long, value_name = "N")]
    report_trials: Option<u64>,
    /// Seed of everything random: the same one gives the same champion.
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// How the prior is searched for.
    #[arg(long, value_enum)]
    optimizer: Option<Optimizer>,
    /// The fittest that go on as they are.
    #[arg(long, value_name = "N")]
    elites: Option<u64>,
    /// Slots of 30 ms per horizon; 1 is the thesis.
    #[arg(long, value_name = "N")]
    slots: Option<u64>,
    /// Threads; all cores where none are said. The champion does not depend on them.
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    /// Write prior.json, report.json, generations.csv and the figures into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Preset {
    /// Six environments, horizons of twenty slots: for use.
    Default,
    /// The thesis's two environments and tables, one command per reply.
    Thesis,
    /// The thesis's, small enough to watch.
    Quick,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Optimizer {
    /// The thesis's genetic algorithm.
    Genetic,
    /// Covariance matrix adaptation.
    CmaEs,
    /// The prior under which samples of the same environments are likeliest.
    EmpiricalBayes,
}

impl Evolve {
    /// What that means.
    pub(crate) fn order(self) -> Order<Request> {
        let preset = match self.preset {
            Preset::Default => evolution::Preset::Default,
            Preset::Thesis => evolution::Preset::Thesis,
            Preset::Quick => evolution::Preset::Quick,
        };
        let optimizer = self.optimizer.map(|optimizer| match optimizer {
            Optimizer::Genetic => evolution::Optimizer::Genetic,
            Optimizer::CmaEs => evolution::Optimizer::CmaEs,
            Optimizer::EmpiricalBayes => evolution::Optimizer::EmpiricalBayes,
        });
        Order {
            request: Request {
                preset: Some(preset),
                environments: self.environments,
                optimizer,
                population: self.population,
                generations: self.generations,
                trials: self.trials,
                selection_trials: self.selection_trials,
                report_trials: self.report_trials,
                seed: self.seed,
                elites: self.elites,
                horizon_slots: self.slots,
                ..Request::default()
            },
            threads: self.threads,
            json: self.json,
            folder: self.out,
        }
    }
}
