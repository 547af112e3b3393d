//! How much robots and floors differ.

use super::parts::Parts;

/// Standard deviations of the scale of forward motion and of turns before any sample, of robots and of floors: wheels told
/// wrong by 2 to 20 % are common, floors make -5 to -30 % of them (field facts). Wheels told wrong by a factor of two are not
/// rare, and a second of motion outweighs this.
const SCALE_SPREAD: (f64, f64) = (0.10, 0.07);

/// The same of the drift times the track: of wheels that are unequal by 5 %, and of floors that slip under one of them.
const DRIFT_SPREAD: (f64, f64) = (0.05, 0.01);

/// Drift of a floor in rad for each metre and metre of track, where its turn ratio varies by one: what presets of floors and
/// one wheel's slip have in common.
pub const DRIFT: f64 = 0.12;

/// Chance that the spread of the slip is the next larger one in the next stretch, or the next smaller.
pub const OTHER_FLOOR: f64 = 0.02;

/// What of forward motion, turns and drift belongs to a robot with this track in m, and what to a floor, before any sample.
pub fn parts(track_width: f64) -> [Parts; 3] {
    let scale = Parts::new(SCALE_SPREAD.0, SCALE_SPREAD.1);
    let drift = Parts::new(DRIFT_SPREAD.0 / track_width, DRIFT_SPREAD.1 / track_width);
    [scale, scale, drift]
}
