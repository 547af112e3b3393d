//! `umwelt comparison`.

mod fetch;
mod report;

use super::failure::Failure;
use super::input;
use super::job::watch::{Told, watch};
use super::job::{At, Job, News, STATES, described, episodes, time_left};
use super::output::Output;
use super::progress::{say, wait};
use super::quantity::{or_unknown, span};
use super::table::{Column, Table};
use super::unreadable::{unreadable, with};
use crate::client::Client;
use crate::error::Error;
use crate::events::ComparisonEvents;
use clap::Subcommand;
use futures_util::TryStreamExt;
use serde_json::json;
use std::fmt::Write;
use umwelt_api::ComparisonId;
use umwelt_api::comparison::{Comparison, Event, Kind, Page, Progress, Stage, State};

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List comparisons, the newest first
    List {
        /// Only comparisons in this state
        #[arg(long, value_parser = input::named::<State>(STATES))]
        state: Option<State>,
    },
    /// Show a comparison: what was asked for, how far it has got, what came of it
    #[command(after_help = report::ABOUT)]
    Show {
        /// The comparison
        #[arg(value_name = "ID")]
        comparison: ComparisonId,
    },
    /// Show progress until it has ended, then what came of it; Ctrl-C ends the watching alone
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
            Self::List { state } => {
                let comparisons: Vec<_> = wait(client.comparisons(state).try_collect()).await?;
                if comparisons.is_empty() {
                    say("no comparisons; submit one: umwelt compare");
                }
                let unreadable = unreadable(client, "comparisons", state.is_none()).await?;
                output.result(&Page { comparisons, unreadable, next_page_token: None }, list)
            }
            Self::Show { comparison } => {
                output.result(&wait(client.get_comparison(&comparison)).await?, show)
            }
            Self::Watch { comparison } => {
                let comparison = wait(client.get_comparison(&comparison)).await?;
                watch(client, output, &comparison, Told::Everything).await
            }
            Self::Plot(plot) => plot.run(client, output).await,
            Self::Report(fetch) => fetch.report(client, output).await,
            Self::Trials(fetch) => fetch.trials(client, output).await,
            Self::Cancel { comparison } => {
                let cancelled = wait(client.cancel_comparison(&comparison)).await?;
                output.result(&cancelled, |it| format!("{} is cancelled", it.comparison))
            }
            Self::Remove { comparison } => {
                wait(client.delete_comparison(&comparison)).await?;
                let answer = json!({ "comparison": comparison, "removed": true });
                output.result(&answer, |_| format!("{comparison} is removed"))
            }
        }
    }
}

impl Job for Comparison {
    const NOUN: &str = "comparison";
    type Event = Event;

    fn id(&self) -> &str {
        self.comparison.as_str()
    }

    fn state(&self) -> State {
        self.state
    }

    fn at(&self) -> At {
        at(&self.progress)
    }

    fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    fn shown(&self) -> String {
        show(self)
    }

    async fn newest(&self, client: &Client) -> Result<Self, Error> {
        client.get_comparison(&self.comparison).await
    }

    async fn events(&self, client: &Client) -> Result<ComparisonEvents, Error> {
        client.comparison_events(&self.comparison).await
    }

    fn news(event: &Event) -> News {
        match &event.kind {
            Kind::State { state, progress, .. } => News::State(*state, at(progress)),
            Kind::Other => News::Unknown,
        }
    }
}

fn at(progress: &Progress) -> At {
    let Progress { episodes, total_episodes, .. } = *progress;
    At { episodes, total_episodes, words: words(progress) }
}

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

fn list(page: &Page) -> String {
    if page.comparisons.is_empty() {
        return with(String::new(), &page.unreadable);
    }
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
    for comparison in &page.comparisons {
        let Comparison { progress, spec, .. } = comparison;
        table.row([
            comparison.comparison.to_string(),
            comparison.state.name().to_owned(),
            format!("{}/{}", progress.trials_done, progress.trials),
            span(progress.elapsed_s),
            spec.scenario.clone(),
            spec.methods.len().to_string(),
            spec.seed.to_string(),
            or_unknown(spec.prior.clone(), |prior| prior),
        ]);
    }
    with(table.to_string(), &page.unreadable)
}

fn show(comparison: &Comparison) -> String {
    let Comparison { spec, progress, interrupted, .. } = comparison;
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
        ("episodes", episodes(&at(progress), progress.elapsed_s, *interrupted)),
    ];
    lines.extend(spec.prior.as_ref().map(|prior| ("prior", format!("{prior}, of bayesian"))));
    let mut text = described(comparison, &lines);
    if let Some(report) = &comparison.report {
        let _ = write!(text, "\n{}", report::text(report));
    }
    text
}

#[cfg(test)]
mod tests;
