//! What a check came to: what is wrong, and the numbers.

use super::finding::Findings;
use crate::exchange::PoseNoise;

/// The numbers of a check. Each is none where it could not be measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Numbers {
    /// Poses a second.
    pub poses_per_second: f64,
    /// Noise of the poses at rest.
    pub noise: Option<PoseNoise>,
    /// Time in s from a command to its motion; what is described is `described_delay`.
    pub delay: Option<f64>,
    /// Dead time and lag as described, in s.
    pub described_delay: f64,
    /// Distance driven per metre commanded.
    pub forward: Option<f64>,
    /// Angle turned per radian commanded, to the same side where positive.
    pub turn: Option<f64>,
    /// Time in s that the check took.
    pub span: f64,
}

/// The report of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// What is wrong, the gravest first; nothing where all is well.
    pub findings: Findings,
    /// The numbers.
    pub numbers: Numbers,
}

impl Report {
    /// Whether nothing is wrong.
    pub fn is_well(&self) -> bool {
        self.findings.is_empty()
    }
}
