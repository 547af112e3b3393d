//! The tests of all kinds and of each.

mod conformance;
mod differential;
mod skid_steer;
