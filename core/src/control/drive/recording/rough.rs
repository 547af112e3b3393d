//! About how late a robot follows, by least squares over much of a recording at once: where to look closer.
//!
//! A belief that takes in one stretch after another may settle where the first few seem to fit. All together do not.

use super::Recording;
use super::ahead::Followed;
use crate::control::drive::stretch::{APART, GAP, Seen};
use crate::exchange::{Observation, PoseNoise};
use crate::time::RobotTime;

/// Range and step of the sums in s. Below 0 are clocks that differ: they are to be noticed.
const SUMS: (f64, f64, f64) = (-0.6, 1.2, 0.02);

/// Parts of a sum above 0 that are lag.
const SHARES: [f64; 3] = [0.0, 0.5, 1.0];

/// Motions of this length in s are compared.
const SPAN: f64 = 0.3;

/// Most poses that are looked at.
const MOST: usize = 6000;

/// Sums of products of what was commanded and what was seen.
#[derive(Clone, Copy, Default)]
struct Products {
    commanded: f64,
    both: f64,
    seen: f64,
}

impl Products {
    fn add(&mut self, commanded: f64, seen: f64) {
        self.commanded += commanded * commanded;
        self.both += commanded * seen;
        self.seen += seen * seen;
    }

    /// Sum of squares that remains with the best scale.
    fn rest(&self) -> f64 {
        let explained = self.both * self.both / self.commanded;
        self.seen - if explained.is_finite() { explained } else { 0.0 }
    }
}

impl Recording {
    /// About the sum of dead time, lag and offset of the stamps in s by poses until `until`, which are known to `noise`: of
    /// some hypotheses the one that leaves least unexplained. None where nothing moves.
    pub(super) fn rough_sum(&self, until: RobotTime, noise: PoseNoise) -> Option<f64> {
        let (from, _) = self.known()?;
        let thinned = self.thinned(from, until);
        let (first, last, step) = SUMS;
        let sums = (0..).map(|index| first + step * f64::from(index)).take_while(|it| *it <= last);
        let rests = sums.flat_map(|sum| {
            // Nothing follows before it is told: all of that is clocks.
            let shares = if sum > 0.0 { &SHARES[..] } else { &SHARES[..1] };
            let rest = |share: &f64| thinned.unexplained(sum, *share, noise);
            shares.iter().filter_map(rest).map(|rest| (sum, rest)).collect::<Vec<_>>()
        });
        rests.min_by(|one, other| one.1.total_cmp(&other.1)).map(|(sum, _)| sum)
    }

    /// With at most about [`MOST`] poses, all of them from `from` to `until`.
    fn thinned(&self, from: RobotTime, until: RobotTime) -> Self {
        let every = APART.max((until - from) / MOST as f64);
        let mut next = from;
        let kept = self.poses.iter().filter(|pose| {
            let is_next = next <= pose.taken && pose.taken <= until;
            next = if is_next { pose.taken + every } else { next };
            is_next
        });
        Self { poses: kept.copied().collect(), commands: self.commands.clone() }
    }

    /// What a drive whose dead time and lag sum up so leaves unexplained of motions of [`SPAN`], whatever their scale, as
    /// squares of standard deviations of a pose. None where nothing moves.
    fn unexplained(&self, sum: f64, share: f64, noise: PoseNoise) -> Option<f64> {
        let (dead_time, lag) = (sum * (1.0 - share), sum * share);
        let followed = Followed { dead_time, lag, forward: 1.0, turn: 1.0, drift: 0.0 };
        let reckoned = self.reckon(&followed);
        let reckoned = |index: usize| Observation {
            pose: reckoned[index].pose,
            taken: self.poses[index].taken,
        };
        let (mut turns, mut drives, mut then) = (Products::default(), Products::default(), 0);
        for (now, from) in self.poses.iter().enumerate() {
            while self.poses.get(then).is_some_and(|to| to.taken - from.taken < SPAN) {
                then += 1;
            }
            let Some(to) = self.poses.get(then) else { break };
            if to.taken - from.taken < SPAN + GAP {
                let seen = Seen::between(from, to);
                let commanded = Seen::between(&reckoned(now), &reckoned(then));
                turns.add(commanded.turned, seen.turned);
                drives.add(commanded.driven, seen.driven);
            }
        }
        let moves = turns.commanded > 0.0 || drives.commanded > 0.0;
        let rest = turns.rest() / noise.heading.powi(2) + drives.rest() / noise.position.powi(2);
        moves.then_some(rest)
    }
}
