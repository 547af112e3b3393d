//! What is believed of a drive, and what is gathered to teach more.

use crate::drive::{Commanded, DriveBelief, Stretch};
use crate::exchange::PoseNoise;
use crate::kinematics::Drive;
use crate::prediction::Scale;
use crate::settings::{Method, Settings};
use crate::time::RobotTime;
use std::sync::Arc;

/// A new description that differs from what is identified by less than this part is that; another one is of other wheels.
const ACCEPTED: f64 = 0.05;

/// What is believed of how late the drive follows, and what is gathered to teach more.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Follows {
    /// Shared with what is shown of it.
    belief: Arc<DriveBelief>,
    /// The dead time and the lag in s that it expects, which it takes a while to say and is asked for at every step; none
    /// before any motion.
    late: Option<(f64, f64)>,
    /// Standard deviation in s of their sum.
    late_sd: f64,
    pub(super) stretch: Stretch,
    /// When the robot was last commanded to move; none before.
    pub(super) moved: Option<RobotTime>,
}

impl Follows {
    /// What is believed at first, where the settings ask for that.
    pub(super) fn new(settings: &Settings) -> Option<Self> {
        let drive = &settings.drive;
        let belief = if settings.identifies_lag {
            DriveBelief::new(drive.track_width)
        } else if settings.method == Method::Adaptive {
            DriveBelief::of_known_lag(drive)
        } else {
            return None;
        };
        Some(Self::of(Arc::new(belief)))
    }

    /// What is believed under the settings `now`, where it was this under those `before`.
    pub(super) fn redescribed(
        this: Option<Self>,
        before: &Settings,
        now: &Settings,
    ) -> Option<Self> {
        let this = this.filter(|_| asks(before) == asks(now))?;
        let shape = |it: &Settings| (it.drive.wheel_radius, it.drive.track_width);
        let is_other_kind = before.drive.kind != now.drive.kind;
        if shape(before) == shape(now) && !is_other_kind {
            return Some(this);
        }
        let belief = Arc::unwrap_or_clone(this.belief);
        if shape(before) == shape(now) {
            return Some(Self::of(Arc::new(belief.of_another_kind())));
        }
        let belief = belief.described_anew(&before.drive, &now.drive);
        let Scale { forward, turn, .. } = belief.scale();
        let is_accepted = forward.abs() < ACCEPTED && turn.abs() < ACCEPTED;
        let track = now.drive.track_width;
        Some(Self::of(Arc::new(if is_accepted { belief } else { belief.with_other_wheels(track) })))
    }

    /// What is believed already.
    pub(super) fn of(belief: Arc<DriveBelief>) -> Self {
        let (late, late_sd) = (belief.late(), belief.late_sd());
        Self { late, late_sd, belief, stretch: Stretch::default(), moved: None }
    }

    /// What is believed.
    pub(super) fn belief(&self) -> &Arc<DriveBelief> {
        &self.belief
    }

    /// `described` as late as it is expected to be.
    pub(super) fn late(&self, described: &Drive) -> Drive {
        self.late.map_or(*described, |(dead_time, lag)| Drive { lag, dead_time, ..*described })
    }

    /// Standard deviation in s of how late it is expected to be.
    pub(super) fn late_sd(&self) -> f64 {
        self.late_sd
    }

    /// Learns from a stretch of motion; whether it was understood.
    pub(super) fn learn(
        &mut self,
        stretch: &Stretch,
        commanded: &Commanded,
        noise: PoseNoise,
        track_width: f64,
    ) -> bool {
        let belief = Arc::make_mut(&mut self.belief);
        let is_understood = belief.update(stretch, commanded, noise, track_width);
        (self.late, self.late_sd) = (belief.late(), belief.late_sd());
        is_understood
    }

    /// On another floor.
    pub(super) fn on_another_floor(self) -> Self {
        Self::of(Arc::new(Arc::unwrap_or_clone(self.belief).on_another_floor()))
    }

    /// Begins anew: what was gathered so far does not go on.
    pub(super) fn forget(&mut self) {
        (self.stretch, self.moved) = (Stretch::default(), None);
    }
}

/// What settings ask of a drive: whether its scale is identified, and how late it is where that is known.
fn asks(settings: &Settings) -> (bool, Option<(f64, f64)>) {
    let Drive { lag, dead_time, .. } = settings.drive;
    let given = (!settings.identifies_lag).then_some((lag, dead_time));
    (settings.method == Method::Adaptive, given)
}
