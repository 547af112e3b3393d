//! The watch over robots that are controlled as in the thesis.

use umwelt_core::settings::Method;

/// What the robots are controlled by.
const METHOD: Method = Method::Bayesian;

#[path = "suite.rs"]
mod suite;
