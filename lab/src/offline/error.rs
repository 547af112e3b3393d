//! What keeps an offline run from its result.

use std::io;
use umwelt_api::Problems;

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The request makes no sense.
    #[error("that cannot run: {0}")]
    Invalid(#[from] Problems),
    /// It broke off.
    #[error("it broke off: {0}")]
    BrokenOff(String),
    /// It gives no result, and why.
    #[error("it has failed: {0}")]
    Failed(String),
    /// Its result could not be written.
    #[error("{what}: {error}")]
    Unwritten {
        /// What could not be written.
        what: String,
        /// Why.
        error: io::Error,
    },
}
