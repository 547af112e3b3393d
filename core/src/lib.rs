//! The pure domain of Umwelt.
pub mod geometry;
pub mod kinematics;
