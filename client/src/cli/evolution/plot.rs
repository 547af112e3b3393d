//! `umwelt evolution plot`.

use super::super::failure::Failure;
use super::super::job::files::Directory;
use super::super::output::Output;
use super::super::progress::wait;
use clap::Args;
use umwelt_api::EvolutionId;
use umwelt_api::evolution::Figure;
use umwelt_client::Client;

pub(super) const ABOUT: &str = "\
Writes ID-deviation.svg (the thesis's figure 6) and ID-time.svg (its figure 7), as far as the generations have ended.

Example:
  umwelt evolution plot evolution-12 --out figures";

/// Where to draw what.
#[derive(Debug, Args)]
pub(in super::super) struct Plot {
    /// The evolution
    #[arg(value_name = "ID")]
    evolution: EvolutionId,
    #[command(flatten)]
    to: Directory,
}

impl Plot {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let id = self.evolution.as_str();
        let mut figures = Vec::new();
        for (figure, path) in self.to.files(id, &Figure::ALL, Figure::name)? {
            figures.push((path, wait(client.figure(&self.evolution, figure)).await?));
        }
        self.to.write(output, ("evolution", id), &figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_server::{Server, answer};
    use hyper::StatusCode;
    use std::fs;
    use std::path::Path;

    fn plot(out: &Path, force: bool) -> Plot {
        let to = Directory { out: out.to_owned(), force };
        Plot { evolution: "evolution-12".parse().unwrap(), to }
    }

    #[tokio::test]
    async fn figures_become_files_and_files_are_not_overwritten() {
        let server = Server::start(|request| async move {
            let svg = format!("<svg>{}</svg>", request.uri().path());
            answer(StatusCode::OK, "image/svg+xml", &svg)
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let run =
            async |force| plot(directory.path(), force).run(&client, &mut Output::nowhere()).await;
        let content = |name: &str| fs::read_to_string(directory.path().join(name)).unwrap();
        run(false).await.unwrap();
        let svg = "<svg>/v1/evolutions/evolution-12/figures/deviation</svg>";
        assert_eq!(content("evolution-12-deviation.svg"), svg);
        assert!(content("evolution-12-time.svg").contains("figures/time"));

        fs::remove_file(directory.path().join("evolution-12-deviation.svg")).unwrap();
        fs::write(directory.path().join("evolution-12-time.svg"), "mine").unwrap();
        let asked = server.requests();
        let Err(Failure::Wrong(text)) = run(false).await else { panic!("it is a wrong call") };
        assert!(text.contains("evolution-12-time.svg is there already: --force"), "{text}");
        assert_eq!((server.requests(), content("evolution-12-time.svg").as_str()), (asked, "mine"));
        assert!(!directory.path().join("evolution-12-deviation.svg").exists());
        run(true).await.unwrap();
        assert!(content("evolution-12-time.svg").contains("figures/time"));
    }
}
