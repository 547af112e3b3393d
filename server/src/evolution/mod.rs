//! Evolutions of priors: run on threads of their own, offline and in the background of the server.

mod dispatch;
mod job;
pub mod offline;
mod queue;
mod record;
mod run;

pub(crate) use job::{Job, Shown};
pub(crate) use queue::{Evolutions, Submission};
pub(crate) use record::read_generation;
pub(crate) use run::Pool;
pub use run::Priority;

/// Time in s that will still be needed at the pace so far; none where nothing has been done yet.
fn remaining(elapsed: f64, episodes: u64, total: u64) -> Option<f64> {
    (episodes > 0).then(|| elapsed / episodes as f64 * total.saturating_sub(episodes) as f64)
}
