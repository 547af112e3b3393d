//! How poses and commands are gathered into stretches of motion that teach how late the drive follows.

use super::Controller;
use super::compensation::{DelayModel, PathFollower, PoseEstimator};
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
        let Some((first, _)) = follows.stretch.ends() else { return };
        let is_quiet = follows.moved.is_none_or(|moved| taken - moved > LONGEST);
        let has_moved = follows.moved.is_some_and(|moved| moved > first.taken - LONGEST);
        if !has_room || taken - first.taken >= MAX_SPAN || (is_quiet && has_moved) {
            let stretch = std::mem::take(&mut follows.stretch);
            self.learn_drive(&stretch);
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

    /// Learns from a stretch, where it is known what was played in it.
    fn learn_drive(&mut self, stretch: &Stretch) {
        let Some((first, last)) = stretch.ends() else { return };
        let (from, until) = (first.taken - LONGEST, last.taken);
        let drive = self.settings.drive;
        let is_its_own = self.watch.rests() || self.heard.was_away(from, until);
        if is_its_own || !self.commands.is_followed(from, until, HOLE) {
            return;
        }
        let (mut commanded, floors) = (Commanded::new(from), self.watch.floors());
        let mut slew = None;
        self.commands.walk(Attribution::Played, &drive, from, until, |speeds, duration| {
            let twist = kinematics::forward(&drive, speeds);
            // As the robot plays it.
            let slew = slew.get_or_insert_with(|| Slew::new(twist));
            slew.hold(&drive, twist, duration, |twist, duration| {
                commanded.add(floors.moving(twist), duration);
            });
        });
        if !commanded.moves() {
            return;
        }
        let noise = self.watch.noise(self.pose_noise());
        let Some(follows) = &mut self.follows else { return };
        if follows.learn(stretch, &commanded, noise, drive.track_width) {
            self.act();
        }
    }
}
