//! Files that commands write: none is replaced without --force.

use super::super::failure::Failure;
use super::super::output::Output;
use clap::Args;
use serde_json::json;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The directory of some files.
#[derive(Debug, Args)]
pub(in super::super) struct Directory {
    /// Directory for the files
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub(in super::super) out: PathBuf,
    /// Replace files that are there already
    #[arg(long)]
    pub(in super::super) force: bool,
}

impl Directory {
    /// Each of `figures` with the file that it is to have; none where one of them could not be written.
    pub(in super::super) fn files<F: Copy>(
        &self,
        id: &str,
        figures: &[F],
        name: fn(F) -> &'static str,
    ) -> Result<Vec<(F, PathBuf)>, Failure> {
        fs::create_dir_all(&self.out).map_err(|error| {
            Failure::Wrong(format!("{} cannot be made: {error}", self.out.display()))
        })?;
        let file = |&figure: &F| (figure, self.out.join(format!("{id}-{}.svg", name(figure))));
        let files: Vec<_> = figures.iter().map(file).collect();
        files.iter().try_for_each(|(_, path)| is_free(path, self.force))?;
        Ok(files)
    }

    /// Writes `figures`, as `noun` of `id` has them, and says where they are.
    pub(in super::super) fn write(
        &self,
        output: &mut Output,
        (noun, id): (&str, &str),
        figures: &[(PathBuf, String)],
    ) -> Result<(), Failure> {
        let mut written = Vec::new();
        for (path, svg) in figures {
            write(path, svg, self.force)?;
            written.push(path.display().to_string());
        }
        output.result(&json!({ noun: id, "files": written }), |_| written.join("\n"))
    }
}

/// A file, or standard output.
#[derive(Debug, Args)]
pub(in super::super) struct Destination {
    /// File to write; standard output otherwise
    #[arg(long, value_name = "FILE")]
    pub(in super::super) out: Option<PathBuf>,
    /// Replace a file that is there already
    #[arg(long, requires = "out")]
    pub(in super::super) force: bool,
}

impl Destination {
    /// Whether there is anything against writing there.
    pub(in super::super) fn check(&self) -> Result<(), Failure> {
        self.out.as_deref().map_or(Ok(()), |path| is_free(path, self.force))
    }

    /// Writes `text`, what `noun` of `id` has as `content`, and says where it is.
    pub(in super::super) fn write(
        &self,
        output: &mut Output,
        (noun, id): (&str, &str),
        content: &str,
        text: &str,
    ) -> Result<(), Failure> {
        let Some(path) = &self.out else {
            return output.result(&json!({ noun: id, content: text }), |_| text.to_owned());
        };
        write(path, text, self.force)?;
        let written = path.display().to_string();
        output.result(&json!({ noun: id, "files": [written] }), |_| written.clone())
    }
}

fn is_free(path: &Path, force: bool) -> Result<(), Failure> {
    if !force && fs::symlink_metadata(path).is_ok() { Err(is_there(path)) } else { Ok(()) }
}

fn is_there(path: &Path) -> Failure {
    Failure::Wrong(format!("{} is there already: --force replaces it", path.display()))
}

fn write(path: &Path, text: &str, force: bool) -> Result<(), Failure> {
    let mut options = OpenOptions::new();
    if force {
        options.write(true).create(true).truncate(true);
    } else {
        // Another program may have made it since we looked.
        options.write(true).create_new(true);
    }
    let written = options.open(path).and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => is_there(path),
        _ => Failure::Failed(format!("cannot write {}: {error}", path.display())),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_only_with_force() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("report.md");
        let to = |force| Destination { out: Some(path.clone()), force };
        let write = |force, text: &str| {
            let of = ("comparison", "comparison-12");
            to(force).write(&mut Output::nowhere(), of, "report", text)
        };
        assert!(to(false).check().is_ok());
        write(false, "first").unwrap();
        assert!(matches!(to(false).check(), Err(Failure::Wrong(_))));
        // Made by another program since the check.
        let Err(Failure::Wrong(text)) = write(false, "second") else { panic!("it is wrong") };
        assert!(text.contains("report.md is there already: --force"), "{text}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        assert!(to(true).check().is_ok());
        write(true, "3").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "3");
    }

    #[test]
    fn a_directory_that_cannot_be_made_is_a_wrong_call() {
        let nowhere = Directory { out: "/dev/null/plots".into(), force: true };
        assert!(matches!(nowhere.files("a", &["b"], |it| it), Err(Failure::Wrong(_))));
    }
}
