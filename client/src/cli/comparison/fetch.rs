//! `umwelt comparison plot`, `report` and `trials`: what the server writes, into files.

use super::super::failure::Failure;
use super::super::job::files::{Destination, Directory};
use super::super::output::Output;
use super::super::progress::wait;
use clap::Args;
use std::time::Duration;
use umwelt_api::ComparisonId;
use umwelt_api::comparison::Figure;
use umwelt_client::Client;

pub(super) const ABOUT_PLOT: &str = "\
Writes, once it has succeeded,
  ID-deviation.svg  share of the trials that deviate by more, environment by environment
  ID-time.svg       share of the trials that take longer (both: the thesis's figures 8 to 11)
  ID-pareto.svg     time against deviation: who is beaten in both

Example:
  umwelt comparison plot comparison-12 --out figures";

pub(super) const ABOUT_REPORT: &str = "\
Example:
  umwelt comparison report comparison-12 --out report.md";

pub(super) const ABOUT_TRIALS: &str = "\
One row for each trial of each method in each environment, below a header.

Example:
  umwelt comparison trials comparison-12 --out trials.csv";

/// Time for every trial of the largest comparison, 20 MB, over a slow link.
const TRIALS_DEADLINE: Duration = Duration::from_secs(120);

/// Where to draw what.
#[derive(Debug, Args)]
pub(in super::super) struct Plot {
    /// The comparison
    #[arg(value_name = "ID")]
    comparison: ComparisonId,
    #[command(flatten)]
    to: Directory,
}

impl Plot {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let id = self.comparison.as_str();
        let mut figures = Vec::new();
        for (figure, path) in self.to.files(id, &Figure::ALL, Figure::name)? {
            let svg = wait(client.comparison_figure(&self.comparison, figure)).await?;
            figures.push((path, svg));
        }
        self.to.write(output, ("comparison", id), &figures)
    }
}

/// Where to write what.
#[derive(Debug, Args)]
pub(in super::super) struct Fetch {
    /// The comparison
    #[arg(value_name = "ID")]
    comparison: ComparisonId,
    #[command(flatten)]
    to: Destination,
}

impl Fetch {
    pub(super) async fn report(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        self.to.check()?;
        let text = wait(client.comparison_report(&self.comparison)).await?;
        self.to.write(output, ("comparison", self.comparison.as_str()), "report", &text)
    }

    pub(super) async fn trials(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        self.to.check()?;
        let client = client.within(TRIALS_DEADLINE);
        let text = wait(client.comparison_trials(&self.comparison)).await?;
        self.to.write(output, ("comparison", self.comparison.as_str()), "trials", &text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_server::{Server, answer};
    use hyper::StatusCode;
    use std::fs;
    use std::path::Path;
    use umwelt_api::comparison::TRIALS_COLUMNS;

    /// A server that answers each path with itself, as the kind of text that is asked for there.
    async fn server() -> Server {
        Server::start(|request| async move {
            let path = request.uri().path();
            let text = match path.rsplit('/').next() {
                Some("trials.csv") => format!("{}\n{path}\n", TRIALS_COLUMNS.join(",")),
                Some("report.md") => format!("# {path}\n"),
                _ => format!("<svg>{path}</svg>"),
            };
            answer(StatusCode::OK, "text/plain", &text)
        })
        .await
    }

    fn fetch(out: Option<&Path>) -> Fetch {
        let to = Destination { out: out.map(Path::to_owned), force: false };
        Fetch { comparison: "comparison-12".parse().unwrap(), to }
    }

    #[tokio::test]
    async fn every_figure_becomes_a_file() {
        let server = server().await;
        let client = Client::new(&server.url).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let to = Directory { out: directory.path().to_owned(), force: false };
        let plot = Plot { comparison: "comparison-12".parse().unwrap(), to };
        plot.run(&client, &mut Output::nowhere()).await.unwrap();
        for name in ["deviation", "time", "pareto"] {
            let path = directory.path().join(format!("comparison-12-{name}.svg"));
            let svg = format!("<svg>/v1/comparisons/comparison-12/figures/{name}</svg>");
            assert_eq!(fs::read_to_string(path).unwrap(), svg);
        }
    }

    #[tokio::test]
    async fn report_and_trials_go_to_a_file_or_to_standard_output() {
        let server = server().await;
        let client = Client::new(&server.url).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("trials.csv");
        fetch(Some(&path)).trials(&client, &mut Output::nowhere()).await.unwrap();
        let csv = fs::read_to_string(&path).unwrap();
        assert!(csv.starts_with("environment,contender,trial,"), "{csv}");
        assert!(csv.ends_with("/v1/comparisons/comparison-12/trials.csv\n"), "{csv}");
        let asked = server.requests();
        let taken = fetch(Some(&path)).trials(&client, &mut Output::nowhere()).await;
        assert!(matches!(taken, Err(Failure::Wrong(_))));
        assert_eq!(server.requests(), asked, "nothing is fetched that cannot be written");

        let (mut output, written) = Output::kept(false);
        fetch(None).report(&client, &mut output).await.unwrap();
        let text = String::from_utf8(written.lock().unwrap().clone()).unwrap();
        assert_eq!(text, "# /v1/comparisons/comparison-12/report.md\n");
    }
}
