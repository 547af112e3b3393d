//! The pure domain of Umwelt.
pub mod actuation;
pub mod commands;
pub mod conjugate;
pub mod controller;
pub mod episode;
pub mod exchange;
pub mod geometry;
pub mod horizon;
pub mod identification;
pub mod kinematics;
pub mod link;
pub mod plant;
pub mod prediction;
pub mod steering;
