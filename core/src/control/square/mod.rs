//! UMBmark: a square driven both ways, whose return errors show how wheels and track differ from the description.
//!
//! J. Borenstein, L. Feng: Measurement and correction of systematic odometry errors in mobile robots, IEEE Transactions on
//! Robotics and Automation 12(6), 1996.
//!
//! The motion is open loop: four sides and four quarter turns to the left, then the same to the right ([`Course`]), with a
//! rest after each. What is commanded is exactly the side and the quarter turn, by the drive as described ([`pace`]); where
//! the robot is seen to end is its error ([`Runs`]). A single direction hides one kind of error behind the other; both
//! together tell them apart ([`Angles`]), and name track width and ratio of the wheels ([`Report`]).
//!
//! Poses are judged, learned from and watched as on any way. All storage has a fixed size.

mod angles;
mod course;
mod pace;
mod report;
mod runs;

pub use angles::Angles;
pub use course::{Course, MOTIONS, Part};
pub use pace::{Limits, pace};
pub use report::{Ending, Report, Return, Systematic};
pub use runs::{Runs, Seen};

use crate::task::MAX_RUNS;

/// Most runs of a square: so many each way.
pub const MOST_RUNS: usize = 2 * MAX_RUNS as usize;

#[cfg(test)]
mod tests;
