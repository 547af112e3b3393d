//! Things with names, those that come with the program and those that are kept: priors, simulated environments.

mod catalogue;
pub(crate) mod priors;
pub(crate) mod training;
