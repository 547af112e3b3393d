//! How the poses' frame lies to the motion: which turn or mirror takes the heading to the direction of driving.

use super::levels::Change;

/// Headings of two drives that are so far apart in rad, or half a turn less, tell a turn from a mirror.
const APART: f64 = 0.4;

/// How drives in the world lie to their headings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Whether the direction of driving turns one way where the heading turns the other.
    pub mirrored: bool,
    /// Direction of driving less heading in rad; their sum where they are mirrored.
    pub angle: f64,
    /// Distance driven per metre commanded.
    pub scale: f64,
    /// How well all drives fit, 0..=1.
    pub fit: f64,
}

impl Frame {
    /// The frame of some drives, whose headings in rad are `heading(change)`; none where they come to nothing.
    pub fn of<'a>(
        drives: impl Iterator<Item = &'a Change> + Clone,
        heading: impl Fn(&Change) -> f64,
    ) -> Option<Self> {
        // As complex numbers: sum of drive times e^(-i heading), and of drive times e^(i heading).
        let sum = |sign: f64| {
            drives.clone().fold((0.0, 0.0), |(real, imaginary), drive| {
                let (sin, cos) = (sign * heading(drive)).sin_cos();
                let [x, y, _] = drive.moved.map(|it| it / drive.commanded);
                (real + x * cos - y * sin, imaginary + x * sin + y * cos)
            })
        };
        let count = drives.clone().count() as f64;
        let squares: f64 = drives
            .clone()
            .map(|drive| {
                (drive.moved[0].powi(2) + drive.moved[1].powi(2)) / drive.commanded.powi(2)
            })
            .sum();
        let all = (squares / count).sqrt();
        if all == 0.0 || !all.is_finite() {
            return None;
        }
        let of = |mirrored: bool| {
            let (real, imaginary) = sum(if mirrored { 1.0 } else { -1.0 });
            let scale = real.hypot(imaginary) / count;
            Self { mirrored, angle: imaginary.atan2(real), scale, fit: scale / all }
        };
        let (turned, mirrored) = (of(false), of(true));
        let headings = drives.map(heading);
        let (low, high) = headings.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
            (low.min(it), high.max(it))
        });
        // Half a turn apart both say the same.
        let tells = (high - low).sin().abs() > APART.sin();
        Some(if tells && mirrored.scale > turned.scale { mirrored } else { turned })
    }
}
