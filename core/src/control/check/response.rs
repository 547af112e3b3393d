//! What the motions came to, per unit commanded, in units that are right.

use super::frame::Frame;
use super::levels::{Change, Levels};
use crate::kinematics::Drive;

/// Times the commanded turn from which on the heading is in degrees: 57 of them make a radian.
const DEGREES: f64 = 12.0;

/// Spread in rad of the heading at rest from which on it is in degrees: no tracker is so poor, and a degree of noise is more.
const SPREAD: f64 = 0.3;

/// Degrees of a radian.
const PER_RADIAN: f64 = 57.295_779_513_082_32;

/// Times the commanded drive from which on positions are in centimetres.
const CENTIMETRES: f64 = 30.0;

/// The same for millimetres.
const MILLIMETRES: f64 = 316.0;

/// Least turn, as a part of what is commanded, to which distances are compared.
const LEAST_TURN: f64 = 0.2;

/// What the motions of a check came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Turned per rad commanded to turn in place, in what the heading is in.
    pub turn: f64,
    /// Turned per rad by which one wheel alone would turn the robot over a drive, twice; 0 where it drives straight.
    pub spin: f64,
    /// Distance driven per metre commanded, whichever way, in what positions are in.
    pub drive: f64,
    /// Distance moved per half track and rad commanded to turn in place, likewise.
    pub shift: f64,
    /// What of the heading makes a radian: 1, or 57 where it is in degrees.
    pub radian: f64,
    /// What of the positions makes a metre: 1, 100 or 1000.
    pub metre: f64,
    /// How the frame lies; none where nothing is driven.
    pub frame: Option<Frame>,
}

impl Response {
    /// What was seen between the rests of a check that began at `heading` rad, whose spread at rest is `spread` rad.
    pub fn of(levels: &Levels, heading: f64, spread: f64, drive: &Drive) -> Self {
        let half = drive.track_width / 2.0;
        let turns = || levels.changes.iter().filter(|change| change.is_turn);
        let drives = || levels.changes.iter().filter(|change| !change.is_turn);
        let (turn, spin) = (slope(turns(), 2), slope(drives(), 2) * half);
        let (driven, shift) = (distance(drives()), distance(turns()) / half);
        let most = (turn - spin).abs().max((turn + spin).abs());
        let radian = if most > DEGREES || spread > SPREAD { PER_RADIAN } else { 1.0 };
        let ratio = driven.max(shift) / (most / radian).max(LEAST_TURN);
        let metre = match ratio {
            ratio if ratio > MILLIMETRES => 1000.0,
            ratio if ratio > CENTIMETRES => 100.0,
            _ => 1.0,
        };
        // Of degrees taken for radians only the changes mean something.
        let start = if radian == 1.0 { heading } else { 0.0 };
        let frame = Frame::of(drives(), |change| start + change.heading / radian);
        let frame = frame.map(|frame| Frame { scale: frame.scale / metre, ..frame });
        let (turn, spin) = (turn / radian, spin / radian);
        let (driven, shift) = (driven / metre, shift / metre);
        Self { turn, spin, drive: driven, shift, radian, metre, frame }
    }

    /// What each wheel turns the robot by, as a part of what it should: left and right.
    ///
    /// A wheel that makes k of its command turns the robot by half of that, left the other way: a turn comes to
    /// (k_r + k_l)/2, a drive to (k_r - k_l)/2.
    pub fn wheels(&self) -> (f64, f64) {
        (self.turn - self.spin, self.turn + self.spin)
    }
}

/// Change of a coordinate per unit commanded: least squares.
fn slope<'a>(changes: impl Iterator<Item = &'a Change>, coordinate: usize) -> f64 {
    let (moved, commanded) = changes.fold((0.0, 0.0), |(moved, commanded), change| {
        let weight = change.commanded;
        (moved + weight * change.moved[coordinate], commanded + weight * weight)
    });
    moved / commanded
}

/// Distance per unit commanded, whichever way.
fn distance<'a>(changes: impl Iterator<Item = &'a Change>) -> f64 {
    let (moved, commanded) = changes.fold((0.0, 0.0), |(moved, commanded), change| {
        let [x, y, _] = change.moved;
        (moved + x * x + y * y, commanded + change.commanded * change.commanded)
    });
    (moved / commanded).sqrt()
}
