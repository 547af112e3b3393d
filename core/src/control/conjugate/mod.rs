//! Conjugate beliefs: a normal quantity of unknown mean and variance, and an event of unknown probability.
//!
//! Beliefs are values: each update returns the next belief. All logs are natural; nothing here allocates.

mod beta_bernoulli;
mod error;
mod mixture;
mod noisy;
mod normal_inverse_chi_squared;
mod special;
mod statistics;

pub use beta_bernoulli::BetaBernoulli;
pub use error::ConjugateError;
pub use mixture::{COMPONENTS, Mixture, StudentT, Weighted, mass_below};
pub use normal_inverse_chi_squared::NormalInverseChiSquared;
pub use special::student_t_half_width;
pub use statistics::SampleStatistics;
