//! The simulation: robot, floor and link in simulated time, driven by the very controller and actuation.

pub mod draws;
pub mod episode;
pub mod fixed_models;
pub mod link;
pub mod plant;
