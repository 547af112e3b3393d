//! What a pose teaches: it is accepted or set aside, closes windows of motion, and shows how far the task has got.

use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::event::{Event, Events};
use super::plan::{Phase, REST_SLOTS};
use super::{ACCEPTED_AGAIN, Controller, RejectedPoses, Track};
use crate::exchange::Observation;
use crate::fusion::Verdict;
use crate::geometry::{Displacement, Pose, WheelSpeeds};
use crate::identification::{self, SampleObserver, Window};
use crate::kinematics::{self, MotionModel};
use crate::settings::{Attribution, FollowsLink, Settings};
use crate::time::RobotTime;

/// A gap between poses in s, beyond which a window of motion begins anew, and their noise is not compared.
pub(super) const MAX_GAP: f64 = 0.5;

/// Slots of zero after which a robot rests that is seen to move still: 1 s.
const SURE_REST_SLOTS: u32 = 33;

/// Standard deviations of a pose by which the poses of a robot at rest may differ: three of their difference.
const STILL: f64 = 4.5;

/// Turn in rad of a robot at rest beside the noise of its heading.
const STILL_TURN: f64 = 0.02;

/// Times that differ by less than this many s are the same.
const SAME_TIME: f64 = 1e-6;

/// Margin of an acceptable pose in m and rad, for what the known noise does not cover.
const MARGIN: (f64, f64) = (0.005, 0.1);

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// Takes in one pose: accepts it or sets it aside, closes windows of motion, follows the task.
    pub(super) fn observe(
        &mut self,
        observation: Observation,
        events: &mut Events,
        observer: &mut impl SampleObserver,
    ) {
        let Some(track) = self.track else {
            self.begin_poses(observation, WheelSpeeds::ZERO);
            return;
        };
        let taken = observation.taken;
        if taken <= track.last.taken {
            self.observe_late(&track, &observation);
            return;
        }
        let (window, moved, wheels) = self.nominal(&track, taken);
        let verdict = match self.fuse(&track, &observation) {
            Some(verdict) => verdict,
            None => self.gate(&track, &observation, moved),
        };
        let unseen = track.unseen.then(moved);
        let track = Track { window, wheels, unseen, ..track };
        match verdict {
            Verdict::SetAside { distance } => {
                self.belief.poses_set_aside += 1;
                if let Some(pose) = self.fused() {
                    self.track = Some(Track { last: Observation { pose, ..observation }, ..track });
                } else {
                    self.forget_gathered();
                }
                self.watch_set_aside(taken, events);
                let _ = events.try_push(Event::PoseSetAside { observation, distance });
                return;
            }
            Verdict::Again => {
                let _ = events.try_push(Event::PosesAcceptedAgain);
                self.watch_anew();
                self.begin_poses(observation, wheels);
                if let Some(begun) = &mut self.track {
                    begun.interval = track.interval;
                }
            }
            Verdict::Accepted => self.go_on(track, observation, moved, events, observer),
        }
        self.rejected = None;
        self.commands.settle(taken - self.acting.drive.dead_time);
        self.follow_task(&observation, events);
    }

    /// Poses begin with this one, while the wheels do so much.
    fn begin_poses(&mut self, observation: Observation, wheels: WheelSpeeds) {
        self.compensation.estimator.reset(observation);
        self.forget_gathered();
        self.begin_fusion(&observation);
        let pose = self.fused().unwrap_or(observation.pose);
        self.track = Some(Track::new(observation, pose, wheels));
    }

    /// Goes on to an accepted pose; since the last of all poses the robot has `moved` by its commands.
    fn go_on(
        &mut self,
        track: Track,
        observation: Observation,
        moved: Displacement,
        events: &mut Events,
        observer: &mut impl SampleObserver,
    ) {
        let Observation { pose: observed, taken } = observation;
        let window = self.close(&track, &observation, observer);
        let span = taken - track.seen.taken;
        let interval = track.interval + 0.2 * (span.min(MAX_GAP) - track.interval);
        let pose = self.fused().unwrap_or_else(|| {
            let predicted = track.last.pose.then(moved);
            self.compensation.estimator.filter_pose(taken, observed, predicted, moved)
        });
        let last = Observation { pose, taken };
        let still = if self.has_moved(track.still.pose, pose) { last } else { track.still };
        // The watch compares what was seen with what was seen.
        let (from, commanded) = (track.seen, track.unseen);
        let seen = if self.fused().is_some() { observation } else { last };
        let unseen = Displacement::default();
        self.track = Some(Track { last, seen, unseen, window, interval, still, ..track });
        self.gather(observation);
        let predicted = from.pose.then(commanded);
        self.watch_step(from, observation, predicted, commanded, events);
    }

    /// Whether a pose is accepted where poses are taken as they are observed; by the commands the robot has `moved` since
    /// the last one.
    fn gate(&mut self, track: &Track, observation: &Observation, moved: Displacement) -> Verdict {
        let predicted = track.last.pose.then(moved);
        let span = observation.taken - track.last.taken;
        if self.can_have_moved(predicted, observation.pose, span) {
            return Verdict::Accepted;
        }
        let again = self.rejected.filter(|rejected| {
            let span = observation.taken - rejected.last.taken;
            self.can_have_moved(rejected.last.pose, observation.pose, span)
        });
        let count = again.map_or(1, |rejected| rejected.count + 1);
        if count >= ACCEPTED_AGAIN {
            return Verdict::Again;
        }
        self.rejected = Some(RejectedPoses { last: *observation, count });
        Verdict::SetAside { distance: predicted.point().distance(observation.pose.point()) }
    }

    /// The motion that the commands alone make from the last pose to `until`: added to the window, as one
    /// displacement of the robot's middle, and what the wheels do at its end.
    pub(super) fn nominal(
        &self,
        track: &Track,
        until: RobotTime,
    ) -> (Window, Displacement, WheelSpeeds) {
        let (described, acting) = (&self.settings.drive, &self.acting.drive);
        let (floors, is_scaled) = (self.floors(acting), self.scaled_belief().is_some());
        let (mut window, mut moved, mut wheels) = (track.window, None, track.wheels);
        self.walk(track.last.taken, until, |speeds, duration| {
            let (end, mean) = kinematics::follow(acting.lag, wheels, speeds, duration);
            let twist = |drive| floors.moving(kinematics::forward(drive, mean));
            // Errors are those of commands as described, whatever else is known of the drive.
            let mut piece = window.add(twist(described), duration);
            if is_scaled {
                piece = kinematics::integrate(twist(acting), duration);
            }
            moved = Some(moved.map_or(piece, |moved: Displacement| moved.then(piece)));
            wheels = end;
        });
        (window, acting.of_middle(moved.unwrap_or_default()), wheels)
    }

    /// The commands that act on the robot from `from` to `until`: dead time after they come into force.
    pub(super) fn walk(
        &self,
        from: RobotTime,
        until: RobotTime,
        each: impl FnMut(WheelSpeeds, f64),
    ) {
        let Settings { drive, attribution, .. } = &self.acting;
        self.commands.walk(
            *attribution,
            drive,
            from - drive.dead_time,
            until - drive.dead_time,
            each,
        );
    }

    /// How far from where it was predicted a robot can be after `span` s, in m and rad.
    pub(super) fn reach(&self, span: f64) -> (f64, f64) {
        let (drive, noise) = (&self.acting.drive, self.pose_noise());
        let far = 2.0 * drive.max_linear * span + 6.0 * noise.position + MARGIN.0;
        let turned = 2.0 * drive.max_angular * span + 6.0 * noise.heading + MARGIN.1;
        (far, turned)
    }

    /// Whether a robot can be at `pose` where `expected` was predicted over `span` s.
    fn can_have_moved(&self, expected: Pose, pose: Pose, span: f64) -> bool {
        let (far, turned) = self.reach(span);
        expected.point().distance(pose.point()) <= far
            && expected.heading.minus(pose.heading).abs() <= turned
    }

    /// Closes the window with a pose where it is ripe; the window that goes on.
    fn close(
        &mut self,
        track: &Track,
        end: &Observation,
        observer: &mut impl SampleObserver,
    ) -> Window {
        let Settings { drive, attribution, .. } = self.settings;
        let (window, noise) = (track.window, self.pose_noise());
        let (start, dead_time) = (window.start.taken, self.acting.drive.dead_time);
        let is_taught = self.teaches_from.is_some_and(|from| start >= from);
        if !is_taught || self.heard.was_away(start, end.taken) {
            return Window::new(*end);
        }
        if end.taken - track.seen.taken > MAX_GAP {
            return Window::new(*end);
        }
        if attribution == Attribution::Played
            && !self.commands.is_known(&drive, start - dead_time, end.taken - dead_time)
        {
            return Window::new(*end);
        }
        match window.verdict(&drive, noise, end) {
            identification::Verdict::Open => return window,
            identification::Verdict::Rest => {}
            identification::Verdict::Rejected => self.belief.windows_rejected += 1,
            // A robot that rests for the watch teaches nothing on its way there.
            identification::Verdict::Closed(_) if self.watch.rests() => {}
            identification::Verdict::Closed(samples) => {
                observer.on_samples(&self.belief, &samples, start);
                self.belief.update(&samples, start, end.taken);
            }
        }
        Window::new(*end)
    }

    /// Follows the task as observed.
    fn follow_task(&mut self, observation: &Observation, events: &mut Events) {
        let Some(task) = &self.task else { return };
        let observation =
            self.track.filter(|_| self.fused().is_some()).map_or(*observation, |it| it.last);
        let here = observation.pose.point();
        let phase = if self.phase == Phase::Settling {
            let is_settled = self.was_at_rest(observation.taken);
            is_settled.then(|| self.record.begin(task, here, events))
        } else {
            let target = self.record.target(task);
            let is_near = target.is_some_and(|target| here.distance(target) <= task.tolerance);
            let is_there = is_near && self.was_at_rest(observation.taken);
            self.record.observe(task, &observation, is_there, events)
        };
        if let Some(phase) = phase {
            self.phase = phase;
            self.phases.clear();
        }
    }

    /// Whether the robot was at rest at `time`: zero was played for three slots before, by its reports where there are any,
    /// and it was not seen to move meanwhile. A tracker whose noise no one knows may show motion for ever: after a second
    /// at zero it rests. Where all timing is described, as in the thesis, its reports are believed.
    pub(super) fn was_at_rest(&self, time: RobotTime) -> bool {
        let slot = self.settings.slot;
        let has_passed =
            |since: RobotTime, slots: u32| time - since >= f64::from(slots) * slot - SAME_TIME;
        let is_still = self.track.is_none_or(|track| has_passed(track.still.taken, REST_SLOTS));
        let is_judged = self.is_watched && self.settings.follows_link != FollowsLink::default();
        let slots = if is_still || !is_judged {
            REST_SLOTS
        } else if self.track.is_some_and(|track| has_passed(track.began, SURE_REST_SLOTS)) {
            SURE_REST_SLOTS
        } else {
            return false;
        };
        let drive = &self.acting.drive;
        (0..slots).all(|slots| {
            let then = time - drive.dead_time - f64::from(slots) * slot;
            self.commands.at(Attribution::Played, drive, then) == WheelSpeeds::ZERO
        })
    }

    /// Whether two poses differ by more than noise.
    fn has_moved(&self, from: Pose, to: Pose) -> bool {
        let noise = self.watch.noise(self.pose_noise());
        let (apart, turned) =
            (from.point().distance(to.point()), from.heading.minus(to.heading).abs());
        let (far, round) = (self.settings.steering.stop_radius / 2.0, STILL_TURN);
        apart > far + STILL * noise.position || turned > round + STILL * noise.heading
    }
}
