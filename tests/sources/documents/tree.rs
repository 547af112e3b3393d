//! The files of the repository.

use std::path::{Component, Path, PathBuf};

/// Folders that hold nothing of ours: what builds, and what tools keep.
const SKIPPED: [&str; 2] = ["target", "node_modules"];

/// The root of the repository.
pub fn root() -> PathBuf {
    normal_path(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
}

/// The text of the file at `path`, from the root.
pub fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The files whose names end with `extension`, as paths from the root, in order.
pub fn files(extension: &str) -> Vec<String> {
    let mut found = Vec::new();
    walk(&root(), extension, &mut found);
    found.sort();
    found
}

fn walk(directory: &Path, extension: &str, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(directory).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() {
            if !name.starts_with('.') && !SKIPPED.contains(&name.as_str()) {
                walk(&path, extension, found);
            }
        } else if path.extension().is_some_and(|it| it == extension) {
            found.push(normal(path.strip_prefix(root()).expect("below the root")));
        }
    }
}

/// `path` without `.` and `..`, with slashes.
pub fn normal(path: &Path) -> String {
    normal_path(path).to_string_lossy().replace('\\', "/")
}

fn normal_path(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}
