//! The horizon that answers a request: from where the robot will be, by the plan.

use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::plan::{self, REST_SLOTS, Start};
use super::{Controller, Track};
use crate::exchange::Request;
use crate::geometry::elementary::least;
use crate::geometry::{Pose, WheelSpeeds};
use crate::horizon::{Horizon, MAX_WATCHDOG};
use crate::kinematics;
use crate::prediction::{Agents, ErrorModel, Motion, Pieces, Prediction};
use crate::settings::{PoseNoise, PredictorKind, Settings};
use crate::task::Limit;
use crate::time::RobotTime;

/// A pose at most this old in s, beyond the loop delay, is fresh.
const FRESH: f64 = 0.15;

/// A pause in s after which a phase is taken up again rather than gone on with.
const PAUSE: f64 = 1.0;

/// Lags after which a robot is seen to rest: what is left of its speed moves it no more.
const COASTS: f64 = 2.0;

/// Part of the variance limits up to which the noise of a pose is next to nothing.
const SMALL_NOISE: f64 = 0.01;

/// Times that differ by less than this many s are the same slot boundary.
const SAME_BOUNDARY: f64 = 1e-6;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// Plans the horizon that answers `request`.
    pub(super) fn command(&mut self, request: &Request) -> &Horizon {
        let Settings { drive, slot, watchdog, attribution, .. } = self.acting;
        // The robot holds no longer, whatever it was described with: what was driven is to be known.
        let watchdog = least(watchdog, MAX_WATCHDOG);
        let loop_delay = self.compensation.delay.loop_delay(&self.acting);
        let newest = self.commands.newest().map_or(RobotTime::BEFORE_ALL, |newest| newest.start);
        let soonest = (request.sent + slot).later(newest);
        let Some(track) = self.track else {
            let horizon = self.commands.begin(request.sequence, soonest, slot, watchdog);
            horizon.speeds.push(WheelSpeeds::ZERO);
            return horizon;
        };
        let taken = track.last.taken;
        let begins = soonest.later(taken + loop_delay);
        let since_change = self.enter_phase(newest, begins);
        self.teaches_from.get_or_insert(begins);

        let model = self.error_model(track.last.pose);
        let (prediction, wheels) = self.predict(&track, &model, begins, request.sequence);
        let before = self.commands.at(attribution, &drive, begins - SAME_BOUNDARY);
        // Poses that are set aside are no poses.
        let seen = track.seen.taken;
        let age = request.sent - seen;
        let floors = self.floors(&drive);
        let start = Start {
            time: begins,
            since_change,
            wheels,
            previous: kinematics::forward(&drive, before),
            phase: self.phase,
            fresh: age <= loop_delay + FRESH,
            stopped: self.stopped
                || self.watch.rests()
                || self.heard.is_held()
                || begins - seen > self.compensation.delay.max_pose_age(&self.acting),
            rest: f64::from(REST_SLOTS) * slot + COASTS * drive.lag + track.interval,
            settles: self.settles(),
            between: 2.0 * (track.interval + slot),
            may_stand: self.may_stand(),
            is_band_known: floors.turn != self.watch.floors().turn,
        };
        let horizon = self.commands.begin(request.sequence, begins, slot, watchdog);
        let (speeds, phases) = (&mut horizon.speeds, &mut self.phases);
        let task = self.task.as_ref();
        let slowed = self.heard.slowed(&drive).map(|drive| Settings { drive, ..self.acting });
        let settings = slowed.as_ref().unwrap_or(&self.acting);
        let follower = &self.compensation.follower;
        let rules = plan::Rules { settings, follower, floors: &floors };
        let limit = plan::plan(rules, &model, task, start, prediction, speeds, phases);
        self.limit = if self.watch.rests() {
            Some(Limit::Watch)
        } else if self.heard.is_held() || (slowed.is_some() && limit == Some(Limit::Drive)) {
            Some(Limit::Hold)
        } else {
            limit
        };
        horizon
    }

    /// The phase at the start of the new horizon: what the old plan had come to by then. Returns the time in s since
    /// the old plan's last change of command.
    fn enter_phase(&mut self, old_start: RobotTime, start: RobotTime) -> f64 {
        let slot = self.settings.slot;
        let phases = &self.phases;
        if phases.is_empty() {
            self.record.pass(self.phase, start);
            return slot;
        }
        // Poses need not come once per slot: a plan may begin within a slot of the old one, whose decision then stands
        // already, or after many, and with them perhaps several phases, after a stall.
        let slots = ((start - old_start) / slot).max(0.0);
        let same = SAME_BOUNDARY / slot;
        let index = (slots + same) as usize;
        let whole = index as f64;
        let within = (slots - whole).max(0.0);
        let is_within = within > same;
        let last = phases.len() - 1;
        let index = index.saturating_add(usize::from(is_within)).min(last);
        for (index, phase) in phases.iter().enumerate().take(index + 1) {
            self.record.pass(*phase, old_start + index as f64 * slot);
        }
        self.phase = phases[index];
        if start - old_start > slot * last as f64 + PAUSE {
            self.phase = self.phase.resumed();
        }
        if is_within && whole < last as f64 { within * slot } else { slot }
    }

    /// The noise of the pose as the variance rule reckons with it. The rule judges what motion adds: the tracker's noise is
    /// there at any speed, and slowing down for it would only make it more per metre. Noise that is next to nothing beside
    /// the limits stays in, as those have it who publish methods.
    fn judged_noise(&self) -> PoseNoise {
        let Settings { noise, variance, .. } = self.settings;
        let is_small = noise.position * noise.position <= SMALL_NOISE * variance.position
            && noise.heading * noise.heading <= SMALL_NOISE * variance.heading;
        if is_small { noise } else { PoseNoise::NONE }
    }

    /// The pose at the start of the horizon, and what the wheels do then.
    pub(super) fn predict(
        &self,
        track: &Track,
        model: &ErrorModel,
        start: RobotTime,
        sequence: u64,
    ) -> (Prediction, WheelSpeeds) {
        let Settings { drive, predictor, .. } = &self.acting;
        let pose = track.last.pose;
        let exact = self.judged_noise();
        let (mut prediction, pieces) = match *predictor {
            PredictorKind::Moments => {
                (Prediction::moments(drive.kind, pose, exact), Pieces::gathered())
            }
            PredictorKind::MonteCarlo { agents, cell, seed } => {
                let agents =
                    Agents::new(drive.kind, pose, exact, model, agents, cell, seed ^ sequence);
                (Prediction::MonteCarlo(agents), Pieces::apart())
            }
        };
        // Commands act a dead time after they come into force, those of the horizon too.
        let until = start + drive.dead_time;
        let wheels = self.motions(track.last.taken, until, track.wheels, pieces, |motion| {
            prediction.advance(model, motion);
        });
        let taken = track.last.taken;
        let estimator = &self.compensation.estimator;
        let prediction = estimator.predict_pose(&self.acting, taken, pose, start, prediction);
        (prediction, wheels)
    }

    /// The errors to reckon with around `pose`.
    pub(super) fn error_model(&self, pose: Pose) -> ErrorModel {
        match self.scaled_belief() {
            Some(drive) => self.belief.model_of(&drive.scale(), &drive.scale_sd()),
            None => self.compensation.estimator.error_model(&self.belief, pose),
        }
    }

    /// The commands that act on the robot from `from` to `until` as motions, gathered in `pieces`, `wheels` being what they
    /// did at first. Returns what they do at the end.
    pub(super) fn motions(
        &self,
        from: RobotTime,
        until: RobotTime,
        wheels: WheelSpeeds,
        mut pieces: Pieces,
        mut each: impl FnMut(Motion),
    ) -> WheelSpeeds {
        let drive = &self.acting.drive;
        let (floors, mut now) = (self.floors(drive), wheels);
        self.walk(from, until, |speeds, duration| {
            let (end, twist) = kinematics::travel(drive, now, speeds, duration);
            if let Some(motion) = pieces.add(floors.moving(twist), duration) {
                each(motion);
            }
            now = end;
        });
        if let Some(motion) = pieces.rest() {
            each(motion);
        }
        now
    }
}
