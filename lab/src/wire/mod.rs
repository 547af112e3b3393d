//! Between the wire and lab: what a request means here, and how results are shown. The wire types are
//! [`umwelt_api`]'s, which knows nothing of lab; what a wire type lacks here for want of a method is a function.

pub mod comparison;
pub mod evolution;
mod pace;
pub mod training;
pub(crate) mod verdict;

pub use pace::Pace;

#[cfg(test)]
mod tests;
