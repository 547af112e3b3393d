//! What drives simulated episodes by the thousand: priors are evolved, and methods are compared.
//!
//! * [`evolution`] searches for priors in simulated environments.
//! * [`comparison`] drives methods over environments and trials on the same seeds.
//! * [`peers`] are the methods of others, each a compensation of the same controller.
//! * [`wire`] is between these and the contract, [`umwelt_api`].
//!
//! Architecture invariant: evolutions, comparisons and methods do no I/O, read no clock, start no thread and own no
//! random number generator. Seeds are arguments; the same settings and seed give the same result, bit for bit.

pub mod comparison;
pub mod evolution;
pub mod peers;
mod seeds;
pub mod wire;
