//! Between the wire and lab: what a request means here, and how what came of it is told. The wire types are
//! [`umwelt_api`]'s, which knows nothing of lab; what a wire type lacks here for want of a method is a function.

pub mod comparison;
pub mod evolution;
pub mod training;
pub(crate) mod verdict;

#[cfg(test)]
mod tests;
