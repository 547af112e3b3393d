//! The command line of `umwelt-server compare`.

use super::values::threads;
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::path::PathBuf;
use umwelt_api::comparison::{Request, Scenario};
use umwelt_lab::offline::Order;

/// What to compare.
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Compare {
    /// What is driven, and in which environments.
    #[arg(long, value_name = "NAME", default_value = Scenario::Thesis.name(),
        value_parser = PossibleValuesParser::new(Scenario::ALL.map(Scenario::name)))]
    scenario: String,
    /// Who is compared, all where no one is said: a method such as bayesian, or with its slots as bayesian/20.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Option<Vec<String>>,
    /// Trials of each in each environment; 1000 where nothing is said.
    #[arg(long, value_name = "N")]
    trials: Option<u64>,
    /// Seed of everything random: the same one gives the same report.
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Prior of the method bayesian, one that comes with the program; thesis where nothing is said.
    #[arg(long, value_name = "NAME")]
    prior: Option<String>,
    /// Threads; all cores where none are said. The report does not depend on them.
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    /// Write report.json, trials.csv, compare.md and the figures into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

impl Compare {
    /// What that means.
    pub(crate) fn order(self) -> Order<Request> {
        Order {
            request: Request {
                scenario: Scenario::named(&self.scenario),
                methods: self.methods,
                trials: self.trials,
                seed: self.seed,
                prior: self.prior,
            },
            threads: self.threads,
            json: self.json,
            folder: self.out,
        }
    }
}
