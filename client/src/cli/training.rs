//! `umwelt environment list|describe|put|remove`: the simulated environments, by name.

use super::failure::Failure;
use super::input;
use super::output::Output;
use super::progress::wait;
use super::quantity::or_unknown;
use super::table::{Column, Table};
use super::unreadable::with;
use clap::Subcommand;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use umwelt_api::Checked;
use umwelt_api::EnvironmentId;
use umwelt_api::training::{Environment, Fitness, Floor, Link, Page, Rtt, Spec};
use umwelt_client::Client;

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List the simulated environments in which priors are evolved
    List,
    /// Describe a simulated environment: its floor, its link, what counts as fit there
    #[command(after_help = "Example:\n  umwelt environment describe bursty-link")]
    Describe {
        /// The environment
        #[arg(value_name = "NAME")]
        environment: EnvironmentId,
    },
    /// Name a simulated environment, for the first time or anew
    #[command(after_help = "\
The file is what `describe --json` prints. Slip and link are names of presets (slip: none, hard, dusty, slippery, oily,
loaded, ramp; link: clean, normal, bad, wifi-bursty) or their numbers.

Examples:
  echo '{\"slip\": \"oily\", \"link\": \"bad\", \"fitness\": \"bad\"}' | umwelt environment put oily --file -
  umwelt --json environment describe oily | jq '.weight = 2' | umwelt environment put oily-twice --file -")]
    Put {
        /// The environment: 1 to 63 of A-Z, a-z, 0-9, -, _ and .
        #[arg(value_name = "NAME")]
        environment: EnvironmentId,
        /// The environment in JSON, - for standard input
        #[arg(long, value_name = "FILE")]
        file: PathBuf,
    },
    /// Remove a simulated environment; evolutions that were submitted keep it
    Remove {
        /// The environment
        #[arg(value_name = "NAME")]
        environment: EnvironmentId,
    },
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::List => output.result(&wait(client.whole::<Page>(None)).await?, list),
            Self::Describe { environment } => {
                output.result(&wait(client.get_training_environment(&environment)).await?, describe)
            }
            Self::Put { environment, file } => {
                let spec = spec(&file)?;
                let put = wait(client.put_training_environment(&environment, &spec)).await?;
                output.result(&put, |it| {
                    format!("{0} is put; use it: umwelt evolve --environments {0}", it.environment)
                })
            }
            Self::Remove { environment } => {
                wait(client.delete_training_environment(&environment)).await?;
                let answer = json!({ "environment": environment, "removed": true });
                output.result(&answer, |_| format!("{environment} is removed"))
            }
        }
    }
}

fn spec(file: &Path) -> Result<Spec, Failure> {
    let json = input::without(input::read(file)?, &Environment::GIVEN_BY_SERVER);
    let read = Spec::read(&json).map(Checked::into_inner);
    read.map_err(|problems| Failure::wrong_body(&input::name(file), &problems))
}

fn floor(floor: &Floor) -> String {
    match floor {
        Floor::Preset(name) => name.clone(),
        Floor::Slip(slip) => {
            format!("forward {} +- {}, ...", slip.forward.mean, slip.forward.sd)
        }
    }
}

fn link(link: &Link) -> String {
    let model = match link {
        Link::Preset(name) => return name.clone(),
        Link::Model(model) => model,
    };
    let rtt = match &model.rtt {
        Rtt::Constant { rtt_s } => format!("RTT {rtt_s} s"),
        Rtt::Lognormal { median_s, p99_s } => format!("RTT {median_s} s, 99 % {p99_s} s"),
        Rtt::Trace { rows } => format!("RTT recorded in {} rows", rows.len()),
    };
    format!("{rtt}, {:.1} % late, ...", 1e2 * model.late.probability)
}

fn fitness(fitness: Fitness) -> &'static str {
    match fitness {
        Fitness::Normal => "normal: speed, within the largest deviation",
        Fitness::Bad => "bad: accuracy, within the longest time",
    }
}

fn list(page: &Page) -> String {
    let mut table = Table::new([
        Column::Text("ENVIRONMENT"),
        Column::Text("FLOOR"),
        Column::Text("LINK"),
        Column::Text("FITNESS"),
        Column::Number("WEIGHT"),
        Column::Text("FROM"),
    ]);
    for it in &page.environments {
        table.row([
            it.environment.to_string(),
            floor(&it.slip),
            link(&it.link),
            fitness(it.fitness).to_owned(),
            it.weight.to_string(),
            if it.built_in { "the server" } else { "put" }.to_owned(),
        ]);
    }
    with(table.to_string(), &page.unreadable)
}

fn describe(it: &Environment) -> String {
    let from = if it.built_in { "comes with the server" } else { "put" };
    let mut text = format!("{}: {from}\n", it.environment);
    let numbers = |value: serde_json::Result<Value>| match value {
        Ok(Value::String(name)) => name,
        Ok(value) => value.to_string(),
        Err(error) => error.to_string(),
    };
    let lines = [
        ("floor", numbers(serde_json::to_value(&it.slip))),
        ("link", numbers(serde_json::to_value(&it.link))),
        ("fitness", fitness(it.fitness).to_owned()),
        ("weight", it.weight.to_string()),
        ("note", or_unknown(it.note.clone(), |note| note)),
        ("etag", it.etag.clone()),
    ];
    for (name, value) in lines {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {name:<8} {value}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(body: &str) -> Environment {
        let spec = Spec::read(body.as_bytes()).unwrap().into_inner();
        Environment::new("oily".parse().unwrap(), spec, false, "\"1\"")
    }

    const NUMBERS: &str = r#"{"slip": {"forward": {"mean": -0.2, "sd": 0.05}}, "weight": 2, "fitness": "bad",
        "link": {"rtt": {"kind": "lognormal", "median_s": 0.04, "p99_s": 0.1}, "late": {"probability": 0.05}}}"#;

    #[test]
    fn simulated_environments_are_a_table() {
        let presets = environment(r#"{"slip": "oily", "link": "bad"}"#);
        let presets = Environment { built_in: true, ..presets };
        let page = Page { environments: vec![presets, environment(NUMBERS)], ..Page::default() };
        assert_eq!(list(&page), "\
ENVIRONMENT  FLOOR                      LINK                                     FITNESS                                      WEIGHT  FROM
oily         oily                       bad                                      normal: speed, within the largest deviation       1  the server
oily         forward -0.2 +- 0.05, ...  RTT 0.04 s, 99 % 0.1 s, 5.0 % late, ...  bad: accuracy, within the longest time            2  put
");
    }

    #[test]
    fn an_environment_is_described_in_full() {
        let text = describe(&environment(NUMBERS));
        assert!(text.contains(r#""forward":{"mean":-0.2,"sd":0.05}"#), "{text}");
        assert!(text.contains(r#""p99_s":0.1"#), "{text}");
        assert!(
            describe(&environment(r#"{"slip": "oily", "link": "bad"}"#)).contains("floor    oily")
        );
    }

    #[test]
    fn what_is_described_can_be_put_again() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("environment.json");
        for body in [NUMBERS, r#"{"slip": "oily", "link": "bad", "note": "x"}"#] {
            let shown = environment(body);
            std::fs::write(&file, serde_json::to_vec_pretty(&shown).unwrap()).unwrap();
            assert_eq!(spec(&file).unwrap(), shown.to_spec());
        }
        std::fs::write(&file, r#"{"slip": "lava", "link": "bad", "weight": -1}"#).unwrap();
        let Err(Failure::Wrong(text)) = spec(&file) else { panic!("it is a wrong call") };
        assert!(text.contains("wrong in 2 places") && text.contains("known: none, hard"), "{text}");
    }
}
