//! A directory for what outlives a server.

use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A data directory of a test; it goes when this is dropped.
#[derive(Debug)]
pub struct Data(TempDir);

impl Data {
    /// An empty one.
    ///
    /// # Panics
    /// Where none can be made.
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary directory"))
    }

    /// A copy of all the files in it as they are now.
    ///
    /// # Panics
    /// Where they cannot be copied.
    pub fn copy(&self) -> Self {
        let copy = Self::new();
        for entry in fs::read_dir(self.path()).expect("it is there") {
            let entry = entry.expect("it can be read");
            fs::copy(entry.path(), copy.path().join(entry.file_name())).expect("it can be copied");
        }
        copy
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The file `name` in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Its path as an argument.
    ///
    /// # Panics
    /// Never, unless the system's temporary directory has no name in UTF-8.
    pub fn text(&self) -> &str {
        self.path().to_str().expect("a path of text")
    }
}

impl Default for Data {
    fn default() -> Self {
        Self::new()
    }
}
