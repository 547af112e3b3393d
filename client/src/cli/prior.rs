//! `umwelt prior`.

use super::evolution::report::channels;
use super::failure::Failure;
use super::input;
use super::output::Output;
use super::progress::wait;
use super::quantity::{UNKNOWN, or_unknown};
use super::table::{Column, Table};
use super::unreadable::with;
use clap::Subcommand;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use umwelt_api::Checked;
use umwelt_api::PriorId;
use umwelt_api::prior::{Page, Prior, Source, Spec};
use umwelt_client::Client;

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List priors: those that come with the server, those that were put, those that evolutions found
    List,
    /// Show a prior, where it comes from and which robots use it
    #[command(after_help = "\
  MU, K   expected ratio of the error to the commanded motion, and the samples that it is worth
  R, S    degrees of freedom and sum of squares of its variance
  SD      the standard deviation that they expect

Example:
  umwelt prior show thesis")]
    Show {
        /// The prior
        #[arg(value_name = "NAME")]
        prior: PriorId,
    },
    /// Name a prior, for the first time or anew
    #[command(after_help = "\
The file is what `show --json` prints, or a part of it: a channel that it leaves out has the weak default.

Examples:
  umwelt --json prior show thesis | jq '.note = \"for the wet hall\"' | umwelt prior put wet-hall --file -
  echo '{\"forward\": {\"mu\": -0.1, \"k\": 5, \"r\": 8, \"s\": 0.1}}' | umwelt prior put oily --file -")]
    Put {
        /// The prior: 1 to 63 of A-Z, a-z, 0-9, -, _ and .
        #[arg(value_name = "NAME")]
        prior: PriorId,
        /// The prior in JSON, - for standard input
        #[arg(long, value_name = "FILE")]
        file: PathBuf,
    },
    /// Remove a prior that no robot uses
    Remove {
        /// The prior
        #[arg(value_name = "NAME")]
        prior: PriorId,
    },
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::List => output.result(&wait(client.whole::<Page>(None)).await?, list),
            Self::Show { prior } => output.result(&wait(client.get_prior(&prior)).await?, show),
            Self::Put { prior, file } => {
                let spec = spec(&file)?;
                let prior = wait(client.put_prior(&prior, &spec)).await?;
                output.result(&prior, |it| {
                    format!("{0} is put; use it: umwelt robot set ID --prior {0}", it.prior)
                })
            }
            Self::Remove { prior } => {
                wait(client.delete_prior(&prior)).await?;
                let answer = json!({ "prior": prior, "removed": true });
                output.result(&answer, |_| format!("{prior} is removed"))
            }
        }
    }
}

fn spec(file: &Path) -> Result<Spec, Failure> {
    let json = input::without(input::read(file)?, &Prior::GIVEN_BY_SERVER);
    let read = Spec::read(&json).map(Checked::into_inner);
    read.map_err(|problems| Failure::wrong_body(&input::name(file), &problems))
}

fn origin(source: &Source) -> String {
    match source {
        Source::BuiltIn => "comes with the server".to_owned(),
        Source::Put => "put".to_owned(),
        Source::Evolution { evolution, seed, optimizer, fitness } => {
            let fitness = fitness.map(|it| format!(", fitness {it:.3}")).unwrap_or_default();
            format!("{evolution} ({}, seed {seed}{fitness})", optimizer.name())
        }
        Source::Inline => UNKNOWN.to_owned(),
    }
}

fn list(page: &Page) -> String {
    let mut table = Table::new([
        Column::Text("PRIOR"),
        Column::Text("FROM"),
        Column::Number("ROBOTS"),
        Column::Text("NOTE"),
    ]);
    for prior in &page.priors {
        table.row([
            prior.prior.to_string(),
            origin(&prior.source),
            prior.robot_count.to_string(),
            or_unknown(prior.note.as_ref(), |note| {
                note.lines().next().unwrap_or_default().to_owned()
            }),
        ]);
    }
    with(table.to_string(), &page.unreadable)
}

fn show(prior: &Prior) -> String {
    let mut text = format!("{}: {}\n", prior.prior, origin(&prior.source));
    // Writing to a String cannot fail.
    if let Some(note) = &prior.note {
        let _ = writeln!(text, "{note}");
    }
    let (forward, lateral, turn, drift) = (prior.forward, prior.lateral, prior.turn, prior.drift);
    let table =
        channels([("forward", forward), ("lateral", lateral), ("turn", turn), ("drift", drift)]);
    let _ = writeln!(text, "\n{table}\n{}", users(prior));
    text
}

fn users(prior: &Prior) -> String {
    let names: Vec<_> = prior.robots.iter().map(AsRef::as_ref).collect();
    let more = prior.robot_count.saturating_sub(names.len() as u64);
    match (names.len(), more) {
        (0, 0) => "no robot uses it".to_owned(),
        (_, 0) => format!("used by {}", names.join(", ")),
        (_, more) => format!("used by {} and {more} more", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prior(source: Source) -> Prior {
        let note = Some("for the wet hall".to_owned());
        let spec = Spec { note, ..Spec::default() };
        Prior::new("wet-hall".parse().unwrap(), spec, source, "\"1\"")
    }

    fn evolved() -> Source {
        Source::Evolution {
            evolution: "evolution-12".parse().unwrap(),
            seed: 7,
            optimizer: umwelt_api::evolution::Optimizer::Genetic,
            fitness: Some(1.25),
        }
    }

    #[test]
    fn a_prior_is_shown_with_where_it_comes_from_and_who_uses_it() {
        let robots = ["a", "b"].map(|id| id.parse().unwrap());
        assert_eq!(
            show(&prior(evolved()).used_by(robots)),
            "\
wet-hall: evolution-12 (genetic, seed 7, fitness 1.250)
for the wet hall

CHANNEL      MU      K      R         S      SD
forward  0.0000  1.000  4.000  4.500e-2  0.1500
lateral  0.0000  1.000  4.000  5.000e-3  0.0500
turn     0.0000  1.000  4.000  4.500e-2  0.1500
drift    0.0000  1.000  4.000  5.000e-3  0.0500

used by a, b
"
        );
        assert!(show(&prior(Source::Put)).ends_with("\nno robot uses it\n"));
        let many = (0..250).map(|it| format!("r{it}").parse().unwrap());
        assert!(users(&prior(Source::Put).used_by(many)).ends_with(" and 150 more"));
    }

    #[test]
    fn priors_are_a_table() {
        let page =
            Page { priors: vec![prior(evolved()), prior(Source::BuiltIn)], ..Page::default() };
        assert_eq!(
            list(&page),
            "\
PRIOR     FROM                                           ROBOTS  NOTE
wet-hall  evolution-12 (genetic, seed 7, fitness 1.250)       0  for the wet hall
wet-hall  comes with the server                               0  for the wet hall
"
        );
    }

    #[test]
    fn what_is_shown_can_be_put_again() {
        let shown = prior(evolved()).used_by(["a".parse().unwrap()]);
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("prior.json");
        std::fs::write(&file, serde_json::to_vec_pretty(&shown).unwrap()).unwrap();
        assert_eq!(spec(&file).unwrap(), shown.to_spec());
        std::fs::write(&file, r#"{"forward": {"mu": 0, "k": 0, "r": 4, "s": 1}, "not": 1}"#)
            .unwrap();
        let Err(Failure::Wrong(text)) = spec(&file) else { panic!("it is a wrong call") };
        assert!(text.contains("wrong in 2 places") && text.contains("forward.k is 0"), "{text}");
    }
}
