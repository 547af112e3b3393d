//! `umwelt evolution plot`.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::wait;
use crate::client::Client;
use clap::Args;
use serde_json::json;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use umwelt_api::EvolutionId;
use umwelt_api::evolution::Figure;

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
    /// Directory for the files
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Replace files that are there already
    #[arg(long)]
    force: bool,
}

impl Plot {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let files = self.files()?;
        let mut written = Vec::new();
        for (figure, path) in files {
            let svg = wait(client.figure(&self.evolution, figure)).await?;
            write(&path, &svg, self.force)?;
            written.push(path.display().to_string());
        }
        let answer = json!({ "evolution": self.evolution, "files": written });
        output.result(&answer, |_| written.join("\n"))
    }

    /// The figures and their files; none is drawn where one of them could not be written.
    fn files(&self) -> Result<Vec<(Figure, PathBuf)>, Failure> {
        std::fs::create_dir_all(&self.out).map_err(|error| {
            Failure::Wrong(format!("{} cannot be made: {error}", self.out.display()))
        })?;
        let file = |figure: Figure| {
            (figure, self.out.join(format!("{}-{}.svg", self.evolution, figure.name())))
        };
        let files: Vec<_> = Figure::ALL.into_iter().map(file).collect();
        let taken =
            files.iter().find(|(_, path)| !self.force && fs::symlink_metadata(path).is_ok());
        match taken {
            Some((_, path)) => Err(is_there(path)),
            None => Ok(files),
        }
    }
}

fn is_there(path: &Path) -> Failure {
    Failure::Wrong(format!("{} is there already: --force replaces it", path.display()))
}

fn write(path: &Path, svg: &str, force: bool) -> Result<(), Failure> {
    let mut options = OpenOptions::new();
    if force {
        options.write(true).create(true).truncate(true);
    } else {
        // Somebody else may have made it since we looked.
        options.write(true).create_new(true);
    }
    let written = options.open(path).and_then(|mut file| file.write_all(svg.as_bytes()));
    written.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => is_there(path),
        _ => Failure::Failed(format!("cannot write {}: {error}", path.display())),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_server::{Server, answer};
    use hyper::StatusCode;

    fn plot(out: &Path, force: bool) -> Plot {
        Plot { evolution: "evolution-12".parse().unwrap(), out: out.to_owned(), force }
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
        let path = directory.path().join("evolution-12-time.svg");
        assert!(matches!(write(&path, "x", false), Err(Failure::Wrong(_))));
    }

    #[test]
    fn a_directory_that_cannot_be_made_is_a_wrong_call() {
        assert!(matches!(plot(Path::new("/dev/null/plots"), true).files(), Err(Failure::Wrong(_))));
    }
}
