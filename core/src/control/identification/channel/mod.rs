//! One channel's belief.

mod stationary;
pub use stationary::Stationary;
