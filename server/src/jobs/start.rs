//! Where a job is taken up when its turn comes.

use super::record::Checkpoint;
use super::work::Work;

/// Where a job is taken up when its turn comes.
#[derive(Debug)]
pub(super) enum Start<W: Work> {
    /// At the beginning.
    Fresh,
    /// Where it was when the server before ended.
    From(Box<Checkpoint<W>>),
    /// Nowhere, and why.
    Broken(String),
}
