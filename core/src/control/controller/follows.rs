//! What is believed of a drive, and what is gathered to teach more.

use crate::drive::{Commanded, DeadBand, DriveBelief, LONGEST, Stretch, Turning, settles};
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
    /// Whether the dead band is identified, not described.
    pub(super) identifies_band: bool,
    /// At which speeds the wheels turn, as is believed.
    pub(super) turning: Turning,
    /// What was believed of the dead band when the robot was last seen to move as commanded.
    sure: DeadBand,
    /// Until when commands may be those of a ramp; none before one.
    pub(super) ramped: Option<RobotTime>,
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
        Some(Self::of(Arc::new(belief), settings))
    }

    /// What is believed under the settings `now`, where it was this under those `before`.
    pub(super) fn redescribed(
        this: Option<Self>,
        before: &Settings,
        now: &Settings,
    ) -> Option<Self> {
        let mut this = this.filter(|_| asks(before) == asks(now))?;
        this.identifies_band = now.identifies_dead_band;
        let shape = |it: &Settings| (it.drive.wheel_radius, it.drive.track_width);
        let is_other_kind = before.drive.kind != now.drive.kind;
        if shape(before) == shape(now) && !is_other_kind {
            return Some(this);
        }
        let belief = Arc::unwrap_or_clone(this.belief);
        if shape(before) == shape(now) {
            return Some(Self::of(Arc::new(belief.of_another_kind()), now));
        }
        let belief = belief.described_anew(&before.drive, &now.drive);
        let Scale { forward, turn, .. } = belief.scale();
        let is_accepted = forward.abs() < ACCEPTED && turn.abs() < ACCEPTED;
        let track = now.drive.track_width;
        let belief = if is_accepted { belief } else { belief.with_other_wheels(track) };
        Some(Self::of(Arc::new(belief), now))
    }

    /// What is believed already.
    pub(super) fn of(belief: Arc<DriveBelief>, settings: &Settings) -> Self {
        let (turning, sure) = (belief.dead_band().turning(), belief.dead_band().clone());
        Self {
            late: belief.late(),
            late_sd: belief.late_sd(),
            belief,
            stretch: Stretch::default(),
            moved: None,
            identifies_band: settings.identifies_dead_band,
            turning,
            sure,
            ramped: None,
        }
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

    /// After how many s the drive follows a command. Where that is identified and not known yet it may take long.
    pub(super) fn settles(&self, settings: &Settings) -> f64 {
        let Drive { dead_time, lag, .. } = settings.drive;
        let given = (!settings.identifies_lag).then_some((dead_time, lag));
        self.late.or(given).map_or(LONGEST, |(dead_time, lag)| settles(dead_time, lag))
    }

    /// Learns which wheels turned in a stretch; as [`DriveBelief::judge_wheels`] has it.
    pub(super) fn judge(
        &mut self,
        stretch: &Stretch,
        commanded: &Commanded,
        noise: PoseNoise,
        settings: &Settings,
    ) -> Option<bool> {
        let settles = self.settles(settings);
        let belief = Arc::make_mut(&mut self.belief);
        let judged = belief.judge_wheels(stretch, commanded, &settings.drive, settles, noise);
        if judged.is_some() {
            self.turning = belief.dead_band().turning();
        }
        judged
    }

    /// Whether a stretch would judge any.
    pub(super) fn can_judge(
        &self,
        stretch: &Stretch,
        commanded: &Commanded,
        noise: PoseNoise,
        settings: &Settings,
    ) -> bool {
        DriveBelief::can_judge(stretch, commanded, &settings.drive, self.settles(settings), noise)
    }

    /// The robot moves as commanded.
    pub(super) fn keep_band(&mut self) {
        self.sure.clone_from(self.belief.dead_band());
    }

    /// Takes back what was judged since it last did: the robot is blocked, or its poses are not those of it.
    pub(super) fn take_back_band(&mut self) {
        Arc::make_mut(&mut self.belief).restore_dead_band(self.sure.clone());
        self.turning = self.sure.turning();
    }

    /// On another floor.
    pub(super) fn on_another_floor(self, settings: &Settings) -> Self {
        Self::of(Arc::new(Arc::unwrap_or_clone(self.belief).on_another_floor()), settings)
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
