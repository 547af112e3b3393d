//! The robot's side: what is sent to the server and when, and what is played of the answers.

pub mod actuation;
pub mod exchange;
pub mod geometry;
pub mod horizon;
pub mod kinematics;
pub mod local;
pub mod time;
mod trip;
