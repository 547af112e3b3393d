//! `umwelt comparison`.

mod fetch;
mod report;

use super::failure::Failure;
use super::input;
use super::job::{Noun, STATES, described, episodes, noun, time_left};
use super::output::Output;
use super::quantity::{or_unknown, span};
use super::table::{Column, Table};
use clap::Subcommand;
use std::fmt::Write;
use umwelt_api::ComparisonId;
use umwelt_api::comparison::{Comparison, ComparisonKind, Progress, Stage, State};
use umwelt_client::Client;

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List comparisons, the newest first
    List {
        /// Only comparisons in this state
        #[arg(long, value_parser = input::named::<State>(STATES))]
        state: Option<State>,
    },
    /// Show a comparison: what was asked for, how far it has got, its report
    #[command(after_help = report::ABOUT)]
    Show {
        /// The comparison
        #[arg(value_name = "ID")]
        comparison: ComparisonId,
    },
    /// Show progress until it has ended, then its report; Ctrl-C ends the watching alone
    #[command(after_help = "Example:\n  umwelt comparison watch comparison-12")]
    Watch {
        /// The comparison
        #[arg(value_name = "ID")]
        comparison: ComparisonId,
    },
    /// Write its figures as SVG: deviation, time, and one against the other
    #[command(after_help = fetch::ABOUT_PLOT)]
    Plot(fetch::Plot),
    /// Write its report as Markdown
    #[command(after_help = fetch::ABOUT_REPORT)]
    Report(fetch::Fetch),
    /// Write every trial as CSV
    #[command(after_help = fetch::ABOUT_TRIALS)]
    Trials(fetch::Fetch),
    /// Cancel a comparison
    Cancel {
        /// The comparison
        #[arg(value_name = "ID")]
        comparison: ComparisonId,
    },
    /// Remove a comparison that has ended, with its trials
    Remove {
        /// The comparison
        #[arg(value_name = "ID")]
        comparison: ComparisonId,
    },
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::List { state } => noun::list::<ComparisonKind>(client, output, state).await,
            Self::Show { comparison } => {
                noun::show::<ComparisonKind>(client, output, &comparison).await
            }
            Self::Watch { comparison } => {
                noun::watch::<ComparisonKind>(client, output, &comparison).await
            }
            Self::Plot(plot) => plot.run(client, output).await,
            Self::Report(fetch) => fetch.report(client, output).await,
            Self::Trials(fetch) => fetch.trials(client, output).await,
            Self::Cancel { comparison } => {
                noun::cancel::<ComparisonKind>(client, output, &comparison).await
            }
            Self::Remove { comparison } => {
                noun::remove::<ComparisonKind>(client, output, &comparison).await
            }
        }
    }
}

impl Noun for ComparisonKind {
    const VERB: &'static str = "compare";

    /// How far a comparison has got, as `trial 5/1000, 12.0 s left`.
    fn words(progress: &Progress) -> String {
        let Progress { trials_done, trials, remaining_s, .. } = *progress;
        let left = time_left(remaining_s);
        match progress.stage {
            Stage::Queued => format!("waiting for its turn{left}"),
            Stage::Reference => {
                format!("measuring how each environment shows in the samples{left}")
            }
            Stage::Trials => format!("trial {trials_done}/{trials}{left}"),
            Stage::Done => format!("{trials} trials"),
        }
    }

    fn table(comparisons: &[Comparison]) -> String {
        let mut table = Table::new([
            Column::Text("COMPARISON"),
            Column::Text("STATE"),
            Column::Number("TRIAL"),
            Column::Number("RAN FOR"),
            Column::Text("SCENARIO"),
            Column::Number("METHODS"),
            Column::Number("SEED"),
            Column::Text("PRIOR"),
        ]);
        for comparison in comparisons {
            let Comparison { progress, spec, .. } = comparison;
            table.row([
                comparison.id.to_string(),
                comparison.state.name().to_owned(),
                format!("{}/{}", progress.trials_done, progress.trials),
                span(progress.elapsed_s),
                spec.scenario.clone(),
                spec.methods.len().to_string(),
                spec.seed.to_string(),
                or_unknown(spec.prior.clone(), |prior| prior),
            ]);
        }
        table.to_string()
    }

    fn show(comparison: &Comparison) -> String {
        let Comparison { spec, progress, .. } = comparison;
        let mut lines = vec![
            ("scenario", format!("{}: {}", spec.scenario, spec.environments.join(", "))),
            ("methods", spec.methods.join(", ")),
            (
                "trials",
                format!(
                    "{} of each in each environment, seed {}; not arrived after {:.0} s",
                    spec.trials, spec.seed, spec.time_limit_s
                ),
            ),
            ("episodes", episodes(comparison, progress.elapsed_s)),
        ];
        lines.extend(spec.prior.as_ref().map(|prior| ("prior", format!("{prior}, of bayesian"))));
        let mut text = described(comparison, &lines);
        if let Some(report) = &comparison.outcome.report {
            let _ = write!(text, "\n{}", report::text(report));
        }
        text
    }
}

#[cfg(test)]
mod tests;
