//! Wheels and track with which a robot moves as it does, in words.

use crate::cli::quantity::UNKNOWN;
use std::fmt::Write;
use umwelt_api::environment::{Estimate, Scale};

/// Wheels and track with which it moves as it does, and what of that is the floor's.
pub(super) fn wheels(scale: &Scale) -> String {
    let metres = |it: &Estimate| match (it.mean, it.sd) {
        (Some(mean), Some(sd)) => format!("{mean:.5} +- {sd:.5} m"),
        _ => UNKNOWN.to_owned(),
    };
    let ratio = |it: &Estimate| match (it.mean, it.sd) {
        (Some(mean), Some(sd)) => format!("{:+.2} +- {:.2} %", 1e2 * mean, 1e2 * sd),
        _ => UNKNOWN.to_owned(),
    };
    let (radius, track) = (metres(&scale.wheel_radius_m), metres(&scale.track_width_m));
    let (said, width) = (scale.described_wheel_radius_m, scale.described_track_width_m);
    let use_of_it = if scale.used { "commands are corrected" } else { "not used by this method" };
    let larger = ratio(&scale.right_larger);
    let mut text = format!(
        "wheels   moves as with a wheel radius of {radius}, described {said}; a track of {track}, described {width}; the right wheel \
         larger by {larger}; {use_of_it}\n"
    );
    let [together, robot, floor] =
        [&scale.forward.together, &scale.forward.robot, &scale.forward.floor].map(ratio);
    let _ = writeln!(
        text,
        "         forward {together} in all: robot {robot}, floor {floor}; they part on another floor, which a reset begins"
    );
    text
}
