//! What the server does in the background, whatever its kind: queued, run a batch of simulated episodes at a time, kept
//! after each, taken up after a restart, cancelled, forgotten.
//!
//! What one kind of job does is [`Work`]; its life is the same for all kinds. Each kind has a queue and a dispatcher of
//! its own ([`Jobs`]), all share the threads ([`umwelt_lab::pool`]).

pub(crate) mod comparison;
mod dispatch;
pub(crate) mod evolution;
#[cfg(test)]
pub(crate) mod fake_work;
mod inner;
mod job;
mod on_wire;
mod queue;
mod record;
mod start;
mod work;

pub(crate) use inner::Limits;
pub(crate) use job::{Job, Shown};
pub(crate) use on_wire::OnWire;
pub(crate) use queue::{Jobs, Submission};
#[cfg(test)]
pub(crate) use record::{CHECKPOINT, Checkpoint, PART, Unusable, part_body};
pub(crate) use record::{Reached, Record, State, UPGRADES, read_part};
pub(crate) use work::{SuccessEffect, Work};
