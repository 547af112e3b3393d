//! How poses and commands are gathered into stretches of motion that teach how late the drive follows.

use super::Controller;
use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::plan::Phase;
use crate::actuation::Slew;
use crate::drive::{APART, Commanded, DriveEstimate, GAP, LONGEST, MAX_SPAN, Stretch};
use crate::exchange::Observation;
use crate::geometry::WheelSpeeds;
use crate::kinematics;
use crate::settings::Attribution;

/// Longest time in s without a report of what is played: what may have been played meanwhile is nearly the same.
const HOLE: f64 = 0.25;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// What is believed of how late the drive follows; none where that is described.
    pub fn drive_estimate(&self) -> Option<DriveEstimate> {
        Some(self.follows.as_ref()?.belief().estimate())
    }

    /// Poses begin anew.
    pub(super) fn forget_gathered(&mut self) {
        if let Some(follows) = &mut self.follows {
            follows.forget();
        }
    }

    /// Takes in an accepted pose.
    pub(super) fn gather(&mut self, observation: Observation) {
        let Some(follows) = &mut self.follows else { return };
        let taken = observation.taken;
        if let Some((_, last)) = follows.stretch.ends() {
            let interval = taken - last.taken;
            if interval < APART {
                return;
            }
            if interval > GAP {
                follows.forget();
            }
        }
        let drive = &self.settings.drive;
        if self.commands.at(Attribution::Played, drive, taken) != WheelSpeeds::ZERO {
            follows.moved = Some(taken);
        }
        let has_room = follows.stretch.push(observation);
        if matches!(self.phase, Phase::Ramping { .. }) {
            follows.ramped = Some(taken + self.acting.loop_delay + LONGEST);
        }
        let Some((first, _)) = follows.stretch.ends() else { return };
        if follows.ramped.is_some_and(|until| taken <= until) {
            match self.shows_wheels() {
                Some(true) => {
                    self.learn_drive();
                    return self.begin_stretch(observation);
                }
                None => return self.begin_stretch(observation),
                Some(false) => {}
            }
        }
        let Some(follows) = &mut self.follows else { return };
        let is_quiet = follows.moved.is_none_or(|moved| taken - moved > LONGEST);
        let has_moved = follows.moved.is_some_and(|moved| moved > first.taken - LONGEST);
        if !has_room || taken - first.taken >= MAX_SPAN || (is_quiet && has_moved) {
            self.learn_drive();
            self.begin_stretch(observation);
        } else if is_quiet {
            self.begin_stretch(observation);
        }
    }

    fn begin_stretch(&mut self, observation: Observation) {
        if let Some(follows) = &mut self.follows {
            follows.stretch = Stretch::default();
            let _ = follows.stretch.push(observation);
        }
    }

    /// Whether the stretch shows already whether a wheel turns; none where it cannot.
    fn shows_wheels(&self) -> Option<bool> {
        let follows = self.follows.as_ref()?;
        let noise = self.watch.noise(self.pose_noise());
        let commanded = self.played(&follows.stretch)?;
        Some(follows.can_judge(&follows.stretch, &commanded, noise, &self.settings))
    }

    /// Learns from the stretch gathered so far, where it is known what was played in it.
    fn learn_drive(&mut self) {
        let Some(follows) = &mut self.follows else { return };
        let stretch = std::mem::take(&mut follows.stretch);
        let Some(commanded) = self.played(&stretch).filter(Commanded::moves) else { return };
        let noise = self.watch.noise(self.pose_noise());
        let floors = self.floors(&self.settings.drive);
        let Some(follows) = &mut self.follows else { return };
        let all_turn = follows.judge(&stretch, &commanded, noise, &self.settings) != Some(false);
        // Whether a ramp is followed is not known before it is judged, and wheels that stand say nothing of how.
        let is_ramp = stretch
            .ends()
            .is_some_and(|(first, _)| follows.ramped.is_some_and(|until| first.taken <= until));
        let commanded = commanded.made(|twist| floors.moving(twist));
        if !all_turn || is_ramp || stretch.is_still() || !commanded.moves() {
            return;
        }
        if follows.learn(&stretch, &commanded, noise, self.settings.drive.track_width) {
            self.act();
        }
    }

    /// What the robot played from [`LONGEST`] before a stretch to its end, as it spreads it; none where that is not known, or
    /// it went its own way.
    fn played(&self, stretch: &Stretch) -> Option<Commanded> {
        let (first, last) = stretch.ends()?;
        let (from, until) = (first.taken - LONGEST, last.taken);
        let is_its_own = self.watch.rests() || self.heard.was_away(from, until);
        if is_its_own || !self.commands.is_followed(from, until, HOLE) {
            return None;
        }
        let drive = &self.settings.drive;
        let (mut commanded, mut slew) = (Commanded::new(from), None);
        self.commands.walk(Attribution::Played, drive, from, until, |speeds, duration| {
            let twist = kinematics::forward(drive, speeds);
            let slew = slew.get_or_insert_with(|| Slew::new(twist));
            slew.hold(drive, twist, duration, |twist, duration| commanded.add(twist, duration));
        });
        Some(commanded)
    }
}
