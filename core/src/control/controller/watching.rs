//! How the controller uses the [watch](crate::watch): what it is shown, and what follows from what it finds.

use super::Controller;
use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::event::{Event, Events};
use super::plan::Phase;
use crate::commands::Commands;
use crate::exchange::Observation;
use crate::geometry::{Displacement, Pose, Twist, length};
use crate::identification::estimate::Channel;
use crate::identification::{Belief, Window};
use crate::kinematics;
use crate::settings::{Attribution, Settings};
use crate::task::{Limit, Task};
use crate::time::RobotTime;
use crate::watch::{Alarm, Finding, Goal, Oddity, Situation, Step};
use std::f64::consts::{FRAC_PI_2, PI};

/// Samples from which on they say what a robot is like by themselves.
const SAMPLES: u64 = 40;

/// A standard deviation of a ratio over 100 ms that no floor of the field facts shows.
const SPREAD: f64 = 0.5;

/// Means of forward and turn ratios at which predictions clamp them, and of the lateral one.
const CLAMPS: (f64, f64, f64) = (-0.7, 0.5, 0.5);

/// Time in s that a look looks back, as a rule: what was learned within it may be of a robot that stood already.
const LOOKED_BACK: f64 = 1.0;

/// Most slots of a window that are looked at.
const MOST_SLOTS: u32 = 100;

/// Commands are alike where they differ by less than this part.
const ALIKE: f64 = 0.3;

/// A report of what is played holds for so many s after it: four slots.
const HOLE: f64 = 0.12;

/// In so large a part of the time in which the robot is to move they have to be.
const MOSTLY: f64 = 0.8;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// What the watch has found, with its numbers, and whether the robot rests for it.
    pub fn watch_state(&self) -> Option<(Alarm, bool)> {
        self.watch.state()
    }

    /// The robot is held: nothing that is seen meanwhile says anything of its commands. To be said with each step.
    pub fn pause_watch(&mut self) {
        self.watch.pause();
    }

    /// Whether the task wants the robot to move, now or soon.
    fn wants_motion(&self) -> bool {
        let is_done = matches!(self.phase, Phase::Idle | Phase::Arrived);
        self.task.is_some() && !self.stopped && !is_done
    }

    /// How old the newest accepted pose is `now`.
    pub(super) fn watch_age(&mut self, now: RobotTime, events: &mut Events) {
        if !self.is_watched {
            return;
        }
        let age = self.track.map(|track| now - track.seen.taken);
        let (begun, ended) = self.watch.age(now, age, self.wants_motion());
        if let Some(alarm) = begun {
            let _ = events.try_push(Event::Found { alarm, rests: true });
        }
        if let Some(alarm) = ended {
            let _ = events.try_push(Event::Over(alarm));
        }
    }

    /// A pose was set aside at `taken`.
    pub(super) fn watch_set_aside(&mut self, taken: RobotTime, events: &mut Events) {
        if self.is_watched && self.wants_motion() && !self.watch.rests() {
            let finding = self.watch.set_aside(taken);
            self.take_up(finding, events);
        }
    }

    /// Poses begin anew where the robot was carried: it may be farther from its path than it should.
    pub(super) fn watch_anew(&mut self) {
        self.watch.forget();
        if self.task.as_ref().is_some_and(|task| task.max_deviation.is_none()) {
            self.watch.carried();
        }
    }

    /// Shows the watch an accepted pose, and has it look where it has seen enough.
    pub(super) fn watch_step(
        &mut self,
        from: Observation,
        to: Observation,
        predicted: Pose,
        commanded: Displacement,
        events: &mut Events,
    ) {
        if !self.is_watched {
            return;
        }
        let (far, turned) = self.reach(to.taken - from.taken);
        let off = [
            to.pose.x - predicted.x,
            to.pose.y - predicted.y,
            to.pose.heading.minus(predicted.heading),
        ];
        let step = Step { from, to, commanded, off };
        let wants = self.wants_motion();
        let (commands, settings) = (&self.commands, &self.acting);
        let played = |from, until| was_played(commands, settings, from, until);
        let far = (far / 2.0, turned / 2.0);
        let (ended, mut finding) = self.watch.accept(settings, &step, far, wants, played);
        if self.healthy.is_none() {
            self.healthy = Some([self.belief.channels(); 2]);
        }
        if let Some(kind) = ended {
            let situation = self.situation(to);
            finding = self.watch.look(settings, kind, &situation, played);
        }
        self.take_up(finding, events);
    }

    /// What follows from what the watch has found.
    fn take_up(&mut self, finding: Finding, events: &mut Events) {
        let (alarm, rests) = match finding {
            Finding::Nothing => return,
            Finding::Healthy => return self.keep_healthy(),
            Finding::Rest(alarm) => (alarm, true),
            Finding::Remark(alarm) | Finding::Raised(alarm) => (alarm, false),
        };
        let _ = events.try_push(Event::Found { alarm, rests });
        let taught_nothing = matches!(
            alarm,
            Alarm::Stuck(_)
                | Alarm::Frozen { .. }
                | Alarm::FrameMismatch { .. }
                | Alarm::Raised { .. }
        );
        if taught_nothing {
            self.take_back();
        }
        // What raises a speed was judged as well; what rests was no matter of speed.
        if taught_nothing
            && rests
            && let Some(follows) = &mut self.follows
        {
            follows.take_back_band();
        }
    }

    /// Takes back what was learned since the robot last moved as commanded: it says nothing of its floor.
    pub(super) fn take_back(&mut self) {
        if let Some([channels, _]) = self.healthy {
            self.belief.restore(channels);
            if let Some(track) = &mut self.track {
                track.window = Window::new(track.last);
            }
        }
    }

    /// The robot moves as commanded: what is believed now is worth coming back to, once it is known that it still did a
    /// look later.
    fn keep_healthy(&mut self) {
        if let Some(follows) = &mut self.follows {
            follows.keep_band();
        }
        let now = self.track.map_or(RobotTime::ZERO, |track| track.last.taken);
        if let Some([older, newer]) = &mut self.healthy
            && self.healthy_at.is_none_or(|at| now - at >= LOOKED_BACK)
        {
            (*older, *newer) = (*newer, self.belief.channels());
            self.healthy_at = Some(now);
        }
    }

    /// What the watch is to know of a pose.
    fn situation(&self, here: Observation) -> Situation {
        let record = &self.record;
        let path = self.task.as_ref().and_then(|task| {
            let (deviation, (from, to)) = (record.deviation()?, record.leg(task)?);
            let track = self.settings.drive.track_width;
            let default = || Task::default_deviation(from.distance(to), track);
            Some((deviation, task.max_deviation.unwrap_or_else(default)))
        });
        let is_under_way = matches!(self.phase, Phase::Turning { .. } | Phase::Driving { .. });
        let goal = self.task.as_ref().filter(|_| is_under_way).and_then(|task| {
            let (ahead, aside) = here.pose.toward(record.target(task)?);
            let error = aside.atan2(ahead).abs();
            let heading = if task.reverse && error > FRAC_PI_2 { PI - error } else { error };
            let (leg, distance) = (record.reached(), length(ahead, aside));
            Some(Goal { leg, distance, heading, tolerance: task.tolerance })
        });
        Situation {
            now: here.taken,
            heading: here.pose.heading.radians(),
            creeps: self.limit == Some(Limit::Variance),
            goal,
            path,
            oddity: oddity(&self.belief),
        }
    }
}

/// Whether the robot played from `from` to `until`, as far as it reports that, what the commands are counted by: replies that
/// come late are no fault of the robot.
fn was_played(commands: &Commands, settings: &Settings, from: RobotTime, until: RobotTime) -> bool {
    let Settings { drive, slot, attribution, .. } = settings;
    let (from, until) = (from - drive.dead_time, until - drive.dead_time);
    if !commands.is_reported() {
        return true;
    }
    let slots = (((until - from) / slot) as u32).clamp(1, MOST_SLOTS);
    let (mut moving, mut alike) = (0, 0);
    for slot in 0..slots {
        let time = from + (until - from) * (f64::from(slot) + 0.5) / f64::from(slots);
        let [counted, played] = [*attribution, Attribution::Played]
            .map(|attribution| kinematics::forward(drive, commands.at(attribution, drive, time)));
        let linear = counted.linear.abs().max(drive.min_linear);
        let angular = counted.angular.abs().max(drive.min_angular);
        if counted != Twist::ZERO {
            moving += 1;
            alike += u32::from(
                commands.is_covered(time, HOLE)
                    && (counted.linear - played.linear).abs() <= ALIKE * linear
                    && (counted.angular - played.angular).abs() <= ALIKE * angular,
            );
        }
    }
    moving > 0 && f64::from(alike) >= MOSTLY * f64::from(moving)
}

/// What the samples alone say that cannot be the robot that was described.
fn oddity(belief: &Belief) -> Option<Oddity> {
    let of = |channel| {
        let channel = belief.channel(channel);
        let model = channel.statistic().filter(|_| channel.samples() >= SAMPLES)?;
        Some((model.mean, model.variance.sqrt(), channel.samples()))
    };
    // A standard deviation of n samples is known to 1/sqrt(2 n) of itself: it is surely above what is left of it after four
    // of those.
    let surely = |(mean, sd, samples): (f64, f64, u64)| {
        (mean, sd * (1.0 - 4.0 / (2.0 * samples as f64).sqrt()))
    };
    let (low, high, aside) = CLAMPS;
    let is_out = |mean: f64| mean <= low || mean >= high;
    let (forward, turn) = (of(Channel::Forward), of(Channel::Turn));
    let (forward, turn) = (forward.map(surely), turn.map(surely));
    match (forward, turn, of(Channel::Lateral)) {
        (Some((mean, _)), _, _) if is_out(mean) => Some(Oddity::ForwardMean(mean)),
        (_, Some((mean, _)), _) if is_out(mean) => Some(Oddity::TurnMean(mean)),
        (_, _, Some((mean, ..))) if mean.abs() >= aside => Some(Oddity::LateralMean(mean)),
        (Some((_, sd)), _, _) if sd > SPREAD => Some(Oddity::ForwardSpread(sd)),
        (_, Some((_, sd)), _) if sd > SPREAD => Some(Oddity::TurnSpread(sd)),
        _ => None,
    }
}
