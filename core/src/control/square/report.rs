//! What a square came to: the return errors, UMBmark's figure, and what explains them.

use super::MOST_RUNS;
use super::angles::Angles;
use super::course::Course;
use crate::geometry::{Angle, Point};
use crate::kinematics::Drive;
use arrayvec::ArrayVec;

/// The heading at the end of a run agrees with what explains its place where they differ by less than this many rad: some
/// times what floors and trackers make of four turns.
const SAME_HEADING: f64 = 0.4;

/// How a square ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All runs were driven.
    Driven,
    /// Too few poses were seen at rest.
    TooFewPoses,
    /// Runs were interrupted or commands were played late, again and again.
    Interrupted,
    /// The robot was seen farther from its start than the square takes it.
    TooFar,
}

/// Where a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Return {
    /// Whether it turned to the left.
    pub is_left: bool,
    /// Return error in m, in the frame of the run's start: where it was seen to end less where it was commanded to.
    pub error: Point,
    /// Error of its heading in rad.
    pub heading: f64,
    /// Mean length in m of its sides from end to end, as seen.
    pub side: f64,
    /// The same as commanded.
    pub commanded: f64,
}

/// What explains the return errors of both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Systematic {
    /// Centre of gravity in m of the return errors of runs to the left.
    pub left: Point,
    /// The same to the right.
    pub right: Point,
    /// UMBmark's figure E_max,syst: the larger of their distances from zero, in m.
    pub figure: f64,
    /// Types A and B.
    pub angles: Angles,
    /// Track width in m by which the turns are explained, with wheels as described.
    pub track_width: f64,
    /// Diameter of the right wheel per that of the left one, E_d.
    pub wheel_ratio: f64,
    /// Length driven per length commanded. The square returns whatever it is: it is the outside pose that shows it.
    pub length_ratio: f64,
    /// Mean radius of the wheels in m by which that is explained.
    pub wheel_radius: f64,
    /// Track width in m that goes with that radius: wheels that are larger turn the robot farther.
    pub track_width_with_radius: f64,
}

/// The report of a square.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// How it ended.
    pub ending: Ending,
    /// Side of the square in m.
    pub side: f64,
    /// The runs that were driven to their end, as they came.
    pub returns: ArrayVec<Return, MOST_RUNS>,
    /// What explains them; none where a direction is missing or the figure driven is no square.
    pub systematic: Option<Systematic>,
    /// The drive as described.
    pub described: Drive,
    /// Time in s that it took.
    pub span: f64,
}

impl Systematic {
    /// What explains `returns` of a robot described by `drive`.
    pub fn of(returns: &[Return], drive: &Drive) -> Option<Self> {
        let (left, right) = (centre(returns, true)?, centre(returns, false)?);
        let count = returns.len() as f64;
        let side = returns.iter().map(|it| it.side).sum::<f64>() / count;
        let commanded = returns.iter().map(|it| it.commanded).sum::<f64>() / count;
        let angles = Angles::of(left, right, side)?;
        // Angles far larger may end in the same places, with other headings.
        let agrees = |it: &Return| {
            let turned = Angle::new(angles.heading_after(it.is_left));
            turned.minus(Angle::new(it.heading)).abs() <= SAME_HEADING
        };
        if !returns.iter().all(agrees) {
            return None;
        }
        let distance = |centre: Point| centre.distance(Point::default());
        let track_width = angles.track_ratio() * drive.track_width;
        let length_ratio = angles.arc_ratio() * side / commanded;
        Some(Self {
            left,
            right,
            figure: distance(left).max(distance(right)),
            angles,
            track_width,
            wheel_ratio: angles.wheel_ratio(side, track_width),
            length_ratio,
            wheel_radius: length_ratio * drive.wheel_radius,
            track_width_with_radius: length_ratio * track_width,
        })
    }
}

/// The centre of gravity of the return errors of one direction.
fn centre(returns: &[Return], is_left: bool) -> Option<Point> {
    let errors = || returns.iter().filter(|it| it.is_left == is_left).map(|it| it.error);
    let count = errors().count();
    let sum = errors().fold((0.0, 0.0), |(x, y), error| (x + error.x, y + error.y));
    (count > 0).then(|| Point::new(sum.0 / count as f64, sum.1 / count as f64))
}

impl Report {
    /// The report of what was seen.
    pub fn of(
        ending: Ending,
        course: &Course,
        returns: &[Return],
        drive: &Drive,
        span: f64,
    ) -> Self {
        let systematic = Systematic::of(returns, drive);
        let returns = returns.iter().copied().take(MOST_RUNS).collect();
        Self { ending, side: course.side(), returns, systematic, described: *drive, span }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn returned(is_left: bool, x: f64, y: f64) -> Return {
        let error = Point::new(x, y);
        let heading = if is_left { -x } else { x };
        Return { is_left, error, heading, side: 1.0, commanded: 1.0 }
    }

    #[test]
    fn the_figure_is_the_larger_distance_of_the_two_centres() {
        let returns = [
            returned(true, 0.01, 0.02),
            returned(false, -0.01, 0.0),
            returned(true, 0.02, 0.0),
            returned(false, -0.03, 0.02),
        ];
        let found = Systematic::of(&returns, &Drive::default()).unwrap();
        assert!(found.left.distance(Point::new(0.015, 0.01)) < 1e-12);
        assert!(found.right.distance(Point::new(-0.02, 0.01)) < 1e-12);
        assert!((found.figure - (0.02_f64 * 0.02 + 0.01 * 0.01).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_direction_alone_explains_nothing() {
        assert_eq!(Systematic::of(&[returned(true, 0.01, 0.0)], &Drive::default()), None);
    }
}
