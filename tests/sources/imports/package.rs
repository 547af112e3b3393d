//! A package as it stands on the disk: its files, its targets, and what one names of the other.

use crate::graph::Graph;
use crate::metadata::{list, metadata, text};
use crate::names::Target;
use crate::tree::{Files, Tree};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A package of the workspace.
#[derive(Debug, Default)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// All files below its `src`.
    pub files: Files,
    /// The files of production code.
    pub production: BTreeSet<String>,
    /// What they name of each other.
    pub graph: Graph,
}

impl Package {
    /// The package `name` of these files. `library` and `programs` are the files that are roots of its targets.
    pub fn new(name: &str, files: Files, library: Option<&str>, programs: &[&str]) -> Self {
        let in_paths = name.replace('-', "_");
        let library = library.map(|root| Tree::read(&files, root));
        let library = library.as_ref().map(|tree| Target { tree, library: None });
        let programs: Vec<Tree> = programs.iter().map(|root| Tree::read(&files, root)).collect();
        let mut package = Self { name: name.to_owned(), ..Self::default() };
        let beside = library.as_ref().map(|target| (in_paths.as_str(), target));
        let programs = programs.iter().map(|tree| Target { tree, library: beside });
        let programs: Vec<Target> = programs.collect();
        let mut reached = BTreeSet::new();
        for target in library.iter().chain(&programs) {
            package.graph.merge(target.graph());
            package.production.extend(target.tree.production().into_iter().map(str::to_owned));
            reached.extend(target.tree.tests.iter().cloned());
        }
        reached.extend(package.production.iter().cloned());
        let left: Vec<&String> = files.keys().filter(|file| !reached.contains(*file)).collect();
        assert!(left.is_empty(), "{name}: no module declares {left:?}");
        package.files = files;
        package
    }

    /// The code of a file, without the tests at its end and without comments.
    pub fn code(&self, file: &str) -> String {
        let text = self.files[file].split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        text.lines().filter(|line| !line.trim_start().starts_with("//")).collect()
    }

    /// The lines of a file.
    pub fn lines(&self, file: &str) -> usize {
        self.files[file].lines().count()
    }
}

/// Every package of the workspace.
pub fn all() -> Vec<Package> {
    let metadata = metadata();
    let packages = list(&metadata["packages"]).iter();
    // A package of tests alone has no `src`.
    packages.filter(|package| source(package).is_dir()).map(read).collect()
}

/// The folder of a package's production code.
fn source(package: &Value) -> PathBuf {
    Path::new(text(&package["manifest_path"])).with_file_name("src")
}

fn read(package: &Value) -> Package {
    let source = source(package);
    let roots = |kind: &str| -> Vec<String> {
        let targets = list(&package["targets"]).iter();
        let of_kind = targets.filter(|target| list(&target["kind"]).iter().any(|it| it == kind));
        of_kind.map(|target| below(&source, Path::new(text(&target["src_path"])))).collect()
    };
    let (mut library, programs) = (roots("lib"), roots("bin"));
    library.extend(roots("proc-macro"));
    let programs: Vec<&str> = programs.iter().map(String::as_str).collect();
    let mut files = Files::new();
    collect(&source, &source, &mut files);
    Package::new(text(&package["name"]), files, library.first().map(String::as_str), &programs)
}

/// Reads every source file in `folder` and below.
fn collect(source: &Path, folder: &Path, files: &mut Files) {
    let entries = fs::read_dir(folder).expect("a folder");
    let paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    for path in paths {
        if path.is_dir() {
            collect(source, &path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.insert(below(source, &path), fs::read_to_string(&path).expect("a text"));
        }
    }
}

/// The path of a file below `source`, with `/` on every system.
fn below(source: &Path, path: &Path) -> String {
    let path = path.strip_prefix(source).expect("a target's root is in src");
    let parts: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    parts.join("/")
}
