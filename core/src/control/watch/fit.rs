//! Which mistake of frame or wheels explains best what was seen.

use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// What was seen per unit commanded: forward, to the left, and turned times half the track. A robot as described answers
/// a drive with (1, 0, 0) and a turn in place with (0, 0, 1).
pub type Response = [f64; 3];

/// Directions that differ by less than this many rad are the same mistake: half of what lies between a quarter of a turn
/// and an eighth.
const SAME_DIRECTION: f64 = 0.4;

/// A component of a response above this is there, below the rest of it is not.
const THERE: f64 = 0.5;

/// A mistake of frame or wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// The heading is half a turn off, or the robot drives backward.
    HalfTurn,
    /// The heading is a quarter of a turn too far to the left.
    QuarterLeft,
    /// The heading is a quarter of a turn too far to the right.
    QuarterRight,
    /// It turns the other way.
    TurnsReversed,
    /// It drives and turns the other way.
    BothReversed,
    /// A wheel is inverted.
    OneInverted,
    /// The positions are mirrored in y, their heading is not.
    PositionMirroredY,
    /// The positions are mirrored in x, their heading is not.
    PositionMirroredX,
    /// The positions have x and y exchanged, their heading not.
    PositionSwapped,
    /// The heading is off by something else.
    Rotated,
}

impl Fit {
    /// What explains the response to driving at world heading `heading`, that to turning, or both; where both are known
    /// the one that was wrong decides.
    pub fn of(drive: Option<Response>, turn: Option<Response>, heading: f64) -> Self {
        let spins = drive.is_some_and(|it| it[2].abs() > THERE && it[0].abs() < THERE);
        let runs = turn.is_some_and(|it| it[0].abs() > THERE && it[2].abs() < THERE);
        if spins || runs {
            return Self::OneInverted;
        }
        let turns_back = turn.is_some_and(|it| it[2] < 0.0);
        let Some([forward, left, _]) = drive else {
            return if turns_back { Self::TurnsReversed } else { Self::Rotated };
        };
        if turns_back {
            return if forward < 0.0 { Self::BothReversed } else { Self::TurnsReversed };
        }
        // Where the motion points, seen from the heading.
        let seen = left.atan2(forward);
        let is_at = |direction: f64| apart(seen, direction) < SAME_DIRECTION;
        let mistakes = [
            (Self::HalfTurn, PI),
            (Self::QuarterLeft, -FRAC_PI_2),
            (Self::QuarterRight, FRAC_PI_2),
            (Self::PositionMirroredY, -2.0 * heading),
            (Self::PositionMirroredX, PI - 2.0 * heading),
            (Self::PositionSwapped, FRAC_PI_2 - 2.0 * heading),
        ];
        let nearest = mistakes
            .into_iter()
            .filter(|(_, direction)| is_at(*direction))
            .min_by(|(_, one), (_, other)| apart(seen, *one).total_cmp(&apart(seen, *other)));
        nearest.map_or(Self::Rotated, |(fit, _)| fit)
    }

    /// What it is.
    pub fn words(self) -> &'static str {
        match self {
            Self::HalfTurn => "the heading is half a turn off, or forward is backward",
            Self::QuarterLeft => "the heading is a quarter of a turn off, too far to the left",
            Self::QuarterRight => "the heading is a quarter of a turn off, too far to the right",
            Self::TurnsReversed => {
                "it turns the other way: left and right wheel are swapped, or an axis is mirrored"
            }
            Self::BothReversed => {
                "it drives and turns the other way: both wheels are inverted, or the heading is half a turn off and an axis mirrored"
            }
            Self::OneInverted => "it spins where it should drive: one wheel is inverted",
            Self::PositionMirroredY => "the positions look mirrored in y, the heading does not",
            Self::PositionMirroredX => "the positions look mirrored in x, the heading does not",
            Self::PositionSwapped => {
                "the positions look as if x and y were swapped, the heading does not"
            }
            Self::Rotated => "it does not move where its heading points",
        }
    }

    /// What to do about it.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::HalfTurn => {
                "add pi to the heading that the tracker sends (or swap and invert the motors), then resume"
            }
            Self::QuarterLeft => {
                "subtract pi/2 from the heading that the tracker sends, then resume"
            }
            Self::QuarterRight => "add pi/2 to the heading that the tracker sends, then resume",
            Self::TurnsReversed => {
                "swap the plugs of the motors, or make the tracker's frame right-handed (x forward, y left, heading counter-clockwise); then resume"
            }
            Self::BothReversed => {
                "invert both motors, or check the tracker's axes and heading; then resume"
            }
            Self::OneInverted => "invert the motor that runs backward, then resume",
            Self::PositionMirroredY | Self::PositionMirroredX | Self::PositionSwapped => {
                "correct the axes of the tracker's positions, or turn its heading with them; then resume"
            }
            Self::Rotated => "check the tracker's axes and the zero of its heading, then resume",
        }
    }
}

/// How far two directions lie apart in rad, 0..=pi.
fn apart(one: f64, other: f64) -> f64 {
    let difference = (one - other).rem_euclid(2.0 * PI);
    difference.min(2.0 * PI - difference)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Displacement seen of one forward where positions go through `mirror` and the heading stays `heading`.
    fn seen(heading: f64, mirror: impl Fn(f64, f64) -> (f64, f64)) -> Option<Response> {
        let (sin, cos) = heading.sin_cos();
        let (x, y) = mirror(cos, sin);
        Some([x * cos + y * sin, y * cos - x * sin, 0.0])
    }

    #[test]
    fn each_mistake_is_told_from_the_others() {
        let turns = Some([0.0, 0.0, 1.0]);
        assert_eq!(Fit::of(Some([-1.0, 0.1, 0.0]), turns, 0.3), Fit::HalfTurn);
        assert_eq!(Fit::of(Some([0.0, -0.9, 0.0]), turns, 0.3), Fit::QuarterLeft);
        assert_eq!(Fit::of(Some([0.1, 0.9, 0.0]), None, 0.3), Fit::QuarterRight);
        assert_eq!(Fit::of(None, Some([0.0, 0.0, -1.0]), 0.0), Fit::TurnsReversed);
        assert_eq!(Fit::of(Some([-1.0, 0.0, 0.0]), Some([0.0, 0.0, -0.9]), 0.0), Fit::BothReversed);
        assert_eq!(Fit::of(None, Some([-0.9, 0.0, 0.1]), 0.0), Fit::OneInverted);
        assert_eq!(Fit::of(Some([0.1, 0.0, 0.9]), None, 0.0), Fit::OneInverted);
        for heading in [0.5, 1.1, -0.6] {
            assert_eq!(
                Fit::of(seen(heading, |x, y| (x, -y)), turns, heading),
                Fit::PositionMirroredY
            );
        }
        assert_eq!(Fit::of(seen(2.4, |x, y| (y, x)), turns, 2.4), Fit::PositionSwapped);
        assert_eq!(Fit::of(seen(0.6, |x, y| (-x, y)), turns, 0.6), Fit::PositionMirroredX);
    }
}
