//! What the server does in the background, whatever it is: queued, run a batch of simulated episodes at a time, kept
//! after each, taken up after a restart, cancelled, forgotten.
//!
//! What one kind of job does is [`Work`]; its life is the same for all kinds. Each kind has a queue and a dispatcher of
//! its own ([`Jobs`]), all share the threads ([`Pool`]).

pub(crate) mod comparison;
mod dispatch;
pub(crate) mod evolution;
mod job;
mod pool;
mod queue;
mod record;
#[cfg(test)]
mod toy;
mod work;

pub(crate) use job::{Job, Pace, Shown};
pub use pool::Priority;
pub(crate) use pool::{Meter, Pool};
pub(crate) use queue::{Jobs, Limits, Submission, Submitting};
#[cfg(test)]
pub(crate) use record::{CHECKPOINT, Checkpoint, PART, Unusable, part_body};
pub(crate) use record::{Record, State, UPGRADES, read_part};
pub(crate) use work::{Gift, Told, Work};

/// Time in s that will still be needed at the pace so far; none where nothing has been done yet.
pub(crate) fn remaining(elapsed: f64, episodes: u64, total: u64) -> Option<f64> {
    (episodes > 0).then(|| elapsed / episodes as f64 * total.saturating_sub(episodes) as f64)
}
