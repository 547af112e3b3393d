//! The watch over robots of which next to nothing is described: what is identified must not hide what is wrong.

use umwelt_core::settings::Method;

/// What the robots are controlled by.
const METHOD: Method = Method::Adaptive;

#[path = "../watch/suite.rs"]
mod suite;
