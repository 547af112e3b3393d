//! What drives simulated episodes by the thousand: priors are evolved, methods are compared, and it is shown what came of it.
//!
//! * [`evolution`] searches for priors in simulated environments.
//! * [`comparison`] drives methods over environments and trials on the same seeds.
//! * [`peers`] are the methods of others, in the same controller.
//! * [`wire`] is between these and the contract, [`umwelt_api`].
//! * [`work`] is what all kinds of jobs have in common; an [`evaluator`] drives its episodes, the [`pool`] on threads.
//! * [`figures`], [`report`] and [`csv`] show what came of it; [`offline`] is both from beginning to end without a server.
//!
//! Architecture invariants: evolutions, comparisons, methods, figures and reports do no I/O, read no clock, start no
//! thread and own no random number generator. Seeds are arguments; the same settings and seed give the same result, bit
//! for bit. Only the pool has threads, and only the offline runs read clocks and write files.

pub mod comparison;
pub mod csv;
pub mod evaluator;
pub mod evolution;
#[cfg(any(test, feature = "fake-work"))]
pub mod fake_work;
pub mod figures;
pub mod offline;
pub mod peers;
pub mod pool;
pub mod report;
mod seeds;
pub mod wire;
pub mod work;
