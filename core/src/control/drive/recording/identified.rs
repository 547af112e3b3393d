//! What a recording says of a drive, and what that is worth.

use super::Recording;
use super::ahead::{ErrorsAhead, Followed};
use crate::control::drive::DriveBelief;
use crate::exchange::PoseNoise;

/// What a recording says of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// The belief after the whole recording.
    pub belief: DriveBelief,
    /// About the sum of dead time, lag and offset of the stamps in s by the first half, where it is looked for closer; less
    /// than 0 where poses are stamped by a clock that is behind. None where nothing moves.
    pub rough: Option<f64>,
    /// What the first half is worth for the second; none where the first half says nothing, or nothing moves in the second.
    pub comparison: Option<Comparison>,
}

/// Errors of poses predicted in the second half of a recording, by what its first half says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// With dead time and lag as identified.
    pub identified: ErrorsAhead,
    /// As if the drive followed at once.
    pub at_once: ErrorsAhead,
}

impl Recording {
    /// What it says of a drive with this track in m, whose poses are known to `noise`; and how well the first half predicts
    /// the second `ahead` s ahead. Calls `progress` with the part of the recording that is done.
    pub fn identify(
        &self,
        noise: PoseNoise,
        track_width: f64,
        ahead: f64,
        mut progress: impl FnMut(f64),
    ) -> Identified {
        let Some((from, until)) = self.known() else {
            let belief = DriveBelief::new(track_width);
            return Identified { belief, rough: None, comparison: None };
        };
        let middle = from + (until - from) / 2.0;
        let rough = self.rough_sum(middle, noise);
        let near = |rough: f64| DriveBelief::near(rough, track_width);
        let mut belief = rough.map_or_else(|| DriveBelief::new(track_width), near);
        let mut half = None;
        for (stretch, commanded) in self.stretches() {
            let Some((_, last)) = stretch.ends() else { continue };
            if half.is_none() && last.taken > middle {
                half = Some(belief.clone());
            }
            belief.update(&stretch, &commanded, noise, track_width);
            progress((last.taken - from) / (until - from));
        }
        let half = half.filter(|half| half.estimate().stretches > 0);
        let comparison = half.and_then(|half| {
            let identified = half.followed();
            let at_once = Followed { dead_time: 0.0, lag: 0.0, ..identified };
            Some(Comparison {
                identified: self.errors_ahead(&identified, middle, ahead)?,
                at_once: self.errors_ahead(&at_once, middle, ahead)?,
            })
        });
        Identified { belief, rough, comparison }
    }
}
