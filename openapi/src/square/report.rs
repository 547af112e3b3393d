//! What a square came to.

use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// How a square ended. See `docs/calibrate.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = SquareEnding)]
pub enum Ending {
    /// All runs were driven.
    Driven,
    /// Too few poses were seen at rest.
    TooFewPoses,
    /// Runs were interrupted or commands were played late, again and again.
    Interrupted,
    /// The robot was seen farther from its start than the square takes it.
    TooFar,
    /// Something of a later version.
    #[serde(other)]
    Other,
}

impl Ending {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Driven => "driven",
            Self::TooFewPoses => "too-few-poses",
            Self::Interrupted => "interrupted",
            Self::TooFar => "too-far",
            Self::Other => "other",
        }
    }
}

/// Which way a run turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = SquareDirection)]
pub enum Direction {
    /// To the left, counter-clockwise.
    Left,
    /// To the right, clockwise.
    Right,
}

impl Direction {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// Where one or several runs ended, in the frame of their start: x ahead, y to the left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SquareError)]
pub struct Error {
    /// Ahead of the start.
    #[serde(serialize_with = "number::finite")]
    pub x_m: f64,
    /// To the left of it.
    #[serde(serialize_with = "number::finite")]
    pub y_m: f64,
}

/// One run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SquareReturn)]
pub struct Return {
    /// Which way it turned.
    pub direction: Direction,
    /// Where it was seen to end less where it was commanded to.
    pub error: Error,
    /// The same of its heading.
    #[serde(serialize_with = "number::finite")]
    pub heading_rad: f64,
    /// Mean length of its sides from end to end, as seen.
    #[serde(serialize_with = "number::finite")]
    pub side_m: f64,
}

/// What explains the return errors of both directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SquareSystematic)]
pub struct Systematic {
    /// UMBmark's figure: the larger distance of the two centres from zero.
    #[serde(serialize_with = "number::finite")]
    pub figure_m: f64,
    /// Centre of gravity of the errors of runs to the left.
    pub left: Error,
    /// The same to the right.
    pub right: Error,
    /// Type A: a quarter turn falls short by this, to the left and to the right alike.
    #[serde(serialize_with = "number::finite")]
    pub alpha_rad: f64,
    /// Type B: a side bends by this, to the left where positive.
    #[serde(serialize_with = "number::finite")]
    pub beta_rad: f64,
    /// Track width that explains the turns, with wheels as described.
    #[serde(serialize_with = "number::finite")]
    pub track_width_m: f64,
    /// Diameter of the right wheel per that of the left one.
    #[serde(serialize_with = "number::finite")]
    pub wheel_ratio: f64,
    /// Length driven per length commanded, by the poses.
    #[serde(serialize_with = "number::finite")]
    pub length_ratio: f64,
    /// Mean radius of the wheels that explains it.
    #[serde(serialize_with = "number::finite")]
    pub wheel_radius_m: f64,
    /// Track width that goes with that radius: larger wheels turn the robot farther.
    #[serde(serialize_with = "number::finite")]
    pub track_width_with_radius_m: f64,
}

/// The report of a square.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SquareReport)]
pub struct Report {
    /// How it ended.
    pub ending: Ending,
    /// Side of the square, as commanded.
    #[serde(serialize_with = "number::finite")]
    pub side_m: f64,
    /// The runs that were driven to their end, as they came.
    pub returns: Vec<Return>,
    /// What explains them; null where a direction is missing or the figure driven is no square.
    #[serde(default)]
    pub systematic: Option<Systematic>,
    /// Track width as described.
    #[serde(serialize_with = "number::finite")]
    pub described_track_width_m: f64,
    /// Radius of the wheels as described.
    #[serde(serialize_with = "number::finite")]
    pub described_wheel_radius_m: f64,
    /// Time that the square took.
    #[serde(serialize_with = "number::finite")]
    pub span_s: f64,
}
