//! The folder that a result goes to.

use super::Error;
use std::fmt::Display;
use std::io;
use std::path::Path;

/// Makes the folder where it is not there yet.
pub(super) fn prepare(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::Unwritten { what: folder.display().to_string(), error })
}

/// Puts a file into the folder.
pub(super) fn put(folder: &Path, name: &str, text: &str) -> Result<(), Error> {
    let path = folder.join(name);
    std::fs::write(&path, text)
        .map_err(|error| Error::Unwritten { what: path.display().to_string(), error })
}

/// Puts a figure into the folder.
pub(super) fn put_figure(
    folder: &Path,
    name: &str,
    drawn: Result<String, impl Display>,
) -> Result<(), Error> {
    let file = format!("{name}.svg");
    let drawn = drawn.map_err(|error| Error::Unwritten {
        what: file.clone(),
        error: io::Error::other(error.to_string()),
    })?;
    put(folder, &file, &drawn)
}
