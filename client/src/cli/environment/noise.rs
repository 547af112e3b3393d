//! How noisy a robot's poses are, in a line.

use crate::cli::quantity::or_unknown;
use std::fmt::Write;
use umwelt_api::environment::Noise;

/// How noisy its poses are, and how far that estimate has got.
pub(super) fn noise(noise: &Noise, level: &str, status: &str) -> String {
    let millimetres = |metres: f64| format!("{:.2} mm", 1e3 * metres);
    let degrees = |radians: f64| format!("{:.2} deg", radians.to_degrees());
    let mut text = format!(
        "poses    off by {} and {} each (standard deviations)",
        or_unknown(noise.position_m.mean, millimetres),
        or_unknown(noise.heading_rad.mean, degrees)
    );
    if let (Some(position), Some(heading)) = (noise.position_m.interval, noise.heading_rad.interval)
    {
        let _ = write!(
            text,
            ", with {level} within {} .. {} and {} .. {}",
            millimetres(position.low),
            millimetres(position.high),
            degrees(heading.low),
            degrees(heading.high)
        );
    }
    let _ = write!(text, "; {status}");
    if let Some(poses) = noise.poses {
        let _ = write!(text, " from {poses:.0} poses in motion");
    }
    text
}
