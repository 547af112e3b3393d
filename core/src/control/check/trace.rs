//! What is seen while a robot is checked: poses as they come, thinned out, and the motions commanded.

use super::wiggle::{MOTIONS, Wiggle};
use crate::exchange::{Observation, PoseNoise};
use crate::geometry::Twist;
use crate::time::RobotTime;

/// Most samples of a trace: 12 a second for 30 s.
const SAMPLES: usize = 384;

/// Shortest time in s between two samples. The poses between them are averaged.
const SPACING: f64 = 0.08;

/// Part of the samples that the wiggle as planned takes: links and ramps take their time.
const PLANNED: f64 = 0.8;

/// Time in s for which a robot has to be seen too far away, so that no single pose ends a check.
const FAR_FOR: f64 = 0.4;

/// Time in s within which the first pose is to come.
const NO_POSE: f64 = 5.0;

/// Time in s within which each further one is.
const NO_MORE: f64 = 2.0;

/// Times its duration that a check may take, over a link however bad.
const LONGEST: f64 = 2.5;

/// So many steps that no wheels can make are of other units than metres, not a robot that ran away.
const UNITS: u32 = 2;

/// Poses of a standing robot are so many standard deviations apart at most.
const APART: f64 = 8.0;

/// The mean of some poses in a row: time in s since the first pose, and how far from it in m and rad, the heading unwrapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sample {
    pub(super) time: f32,
    pub(super) at: [f32; 3],
}

/// One motion as it was commanded, in s since the first pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    pub(super) from: f64,
    pub(super) until: f64,
    /// What was commanded in all, in m or rad, with its sign.
    pub(super) commanded: f64,
    /// Its centre in time, times `commanded`.
    moment: f64,
    pub(super) is_turn: bool,
}

impl Motion {
    /// Its centre in time.
    pub(super) fn centre(&self) -> f64 {
        self.moment / self.commanded
    }
}

/// Sums of some poses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    count: u32,
    time: f64,
    at: [f64; 3],
    squares: [f64; 3],
}

impl Sums {
    fn add(&mut self, time: f64, at: [f64; 3]) {
        self.count += 1;
        self.time += time;
        for (i, value) in at.into_iter().enumerate() {
            self.at[i] += value;
            self.squares[i] += value * value;
        }
    }

    fn mean(&self, i: usize) -> f64 {
        self.at[i] / f64::from(self.count.max(1))
    }

    fn variance(&self, i: usize) -> f64 {
        let (count, mean) = (f64::from(self.count), self.mean(i));
        if self.count < 2 {
            return 0.0;
        }
        (self.squares[i] - count * mean * mean).max(0.0) / (count - 1.0)
    }
}

/// The trace of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    wiggle: Wiggle,
    spacing: f64,
    /// When the first request came, and the newest.
    begun: Option<RobotTime>,
    now: RobotTime,
    first: Option<Observation>,
    last: Option<Observation>,
    /// Heading of the last pose in rad, unwrapped, less that of the first.
    turned: f64,
    poses: u32,
    samples: [Sample; SAMPLES],
    count: usize,
    open: Sums,
    /// When the last sample was closed.
    closed: f64,
    motions: [Motion; MOTIONS],
    begun_motions: usize,
    /// What the motion that was commanded last is.
    kind: Option<(bool, bool)>,
    /// The poses before the first motion.
    rest: Sums,
    /// Smallest age in s of a pose when it was sent, in the first and in the second half of the wiggle.
    ages: [f64; 2],
    has_changed: bool,
    far_since: Option<RobotTime>,
    farthest: f64,
    /// Samples that no wheels can have led to from the one before.
    impossible: u32,
}

impl Trace {
    /// A trace of nothing yet.
    pub fn new(wiggle: Wiggle) -> Self {
        let spacing = SPACING.max(wiggle.duration() / (PLANNED * SAMPLES as f64));
        Self {
            wiggle,
            spacing,
            begun: None,
            now: RobotTime::ZERO,
            first: None,
            last: None,
            turned: 0.0,
            poses: 0,
            samples: [Sample::default(); SAMPLES],
            count: 0,
            open: Sums::default(),
            closed: 0.0,
            motions: [Motion::default(); MOTIONS],
            begun_motions: 0,
            kind: None,
            rest: Sums::default(),
            ages: [f64::INFINITY; 2],
            has_changed: false,
            far_since: None,
            farthest: 0.0,
            impossible: 0,
        }
    }

    /// Forgets all that was seen.
    pub fn clear(&mut self) {
        *self = Self::new(self.wiggle);
    }

    /// The wiggle that it is a trace of.
    pub fn wiggle(&self) -> &Wiggle {
        &self.wiggle
    }

    /// A request was sent at `sent`; its newest pose, if it has one, was taken at `taken`.
    pub fn request(&mut self, sent: RobotTime, taken: Option<RobotTime>) {
        self.begun.get_or_insert(sent);
        self.now = sent;
        if let Some(taken) = taken {
            let half = usize::from(2 * self.begun_motions > MOTIONS);
            self.ages[half] = self.ages[half].min(sent - taken);
        }
    }

    /// When the last pose was taken.
    pub fn last_taken(&self) -> Option<RobotTime> {
        self.last.map(|last| last.taken)
    }

    /// `twist` was in force from `from` on for `duration` s.
    pub fn command(&mut self, from: RobotTime, twist: Twist, duration: f64, track_width: f64) {
        let Some(first) = self.first.filter(|_| twist != Twist::ZERO) else { return };
        let is_turn = twist.linear.abs() < track_width / 2.0 * twist.angular.abs();
        let speed = if is_turn { twist.angular } else { twist.linear };
        let kind = Some((is_turn, speed > 0.0));
        let from = from - first.taken;
        if kind != self.kind {
            if self.begun_motions == MOTIONS {
                return;
            }
            self.kind = kind;
            self.motions[self.begun_motions] = Motion { from, is_turn, ..Motion::default() };
            self.begun_motions += 1;
        }
        let motion = &mut self.motions[self.begun_motions - 1];
        motion.until = from + duration;
        motion.commanded += speed * duration;
        motion.moment += speed * duration * (from + duration / 2.0);
    }

    /// A pose, as it comes; the commands up to it are known.
    pub fn pose(&mut self, pose: Observation) {
        let first = *self.first.get_or_insert(pose);
        let last = self.last.replace(pose).unwrap_or(pose);
        self.turned += pose.pose.heading.minus(last.pose.heading);
        self.has_changed |= pose.pose != last.pose;
        self.poses += 1;
        let time = pose.taken - first.taken;
        let at = [pose.pose.x - first.pose.x, pose.pose.y - first.pose.y, self.turned];
        if self.begun_motions == 0 {
            self.rest.add(time, at);
        }
        self.open.add(time, at);
        if time - self.closed >= self.spacing {
            self.close();
            self.closed = time;
        }
        self.look_far(pose.taken, at[0].hypot(at[1]));
    }

    fn close(&mut self) {
        if self.count < SAMPLES {
            let count = f64::from(self.open.count);
            let at = [0, 1, 2].map(|i| self.open.mean(i) as f32);
            let sample = Sample { time: (self.open.time / count) as f32, at };
            if let Some(last) = self.count.checked_sub(1).map(|last| self.samples[last]) {
                let step = (at[0] - last.at[0]).hypot(at[1] - last.at[1]);
                let speed = f64::from(step / (sample.time - last.time));
                self.impossible += u32::from(self.wiggle.is_impossible(speed));
            }
            self.samples[self.count] = sample;
            self.count += 1;
        }
        self.open = Sums::default();
    }

    fn look_far(&mut self, now: RobotTime, distance: f64) {
        self.farthest = self.farthest.max(distance);
        let noise = APART * self.rest.variance(0).max(self.rest.variance(1)).sqrt();
        let is_far = distance > self.wiggle.allowed().max(noise)
            && self.impossible < UNITS
            && self.begun_motions > 0;
        self.far_since = is_far.then(|| self.far_since.unwrap_or(now));
    }

    /// Whether the robot has been seen too far away for a while.
    pub fn is_too_far(&self) -> bool {
        self.far_since.zip(self.last).is_some_and(|(since, last)| last.taken - since >= FAR_FOR)
    }

    /// Whether any motion was commanded.
    pub fn has_moved(&self) -> bool {
        self.begun_motions > 0
    }

    /// Whether the rest after the last motion has been seen.
    pub fn is_complete(&self) -> bool {
        let Some((first, last)) = self.first.zip(self.last) else { return false };
        let end = self.motions[MOTIONS - 1].until + self.wiggle.last_rest();
        self.begun_motions == MOTIONS && last.taken - first.taken >= end
    }

    /// Whether nothing more is to be seen: the wiggle is over, no poses come, the robot is too far away, or it takes too long.
    pub fn is_over(&self) -> bool {
        self.is_complete() || self.is_too_far() || self.is_silent() || self.is_late()
    }

    /// Whether no poses come, or no more of them.
    pub(super) fn is_silent(&self) -> bool {
        self.silence() > if self.poses == 0 { NO_POSE } else { NO_MORE }
    }

    fn is_late(&self) -> bool {
        self.span() > LONGEST * self.wiggle.duration()
    }

    /// Time in s since the last pose, or since the beginning where there was none.
    pub fn silence(&self) -> f64 {
        let Some(begun) = self.begun else { return 0.0 };
        self.now - self.last.map_or(begun, |last| last.taken)
    }

    /// Time in s since the beginning.
    pub fn span(&self) -> f64 {
        self.begun.map_or(0.0, |begun| self.now - begun)
    }

    pub(super) fn samples(&self) -> &[Sample] {
        &self.samples[..self.count]
    }

    pub(super) fn motions(&self) -> &[Motion] {
        &self.motions[..self.begun_motions]
    }

    /// Heading of the first pose in rad.
    pub(super) fn heading(&self) -> f64 {
        self.first.map_or(0.0, |first| first.pose.heading.radians())
    }

    pub(super) fn poses(&self) -> u32 {
        self.poses
    }

    /// Poses per second.
    pub(super) fn rate(&self) -> f64 {
        let span = self.first.zip(self.last).map_or(0.0, |(first, last)| last.taken - first.taken);
        if span > 0.0 { f64::from(self.poses - 1) / span } else { 0.0 }
    }

    /// Noise of the poses at rest, as they have it; none where there are too few.
    pub(super) fn noise(&self) -> Option<PoseNoise> {
        let [x, y, heading] = [0, 1, 2].map(|i| self.rest.variance(i));
        (self.rest.count >= 5)
            .then(|| PoseNoise { position: f64::midpoint(x, y).sqrt(), heading: heading.sqrt() })
    }

    pub(super) fn ages(&self) -> [f64; 2] {
        self.ages
    }

    /// Whether any two poses in a row differed.
    pub(super) fn has_changed(&self) -> bool {
        self.has_changed
    }

    /// Largest distance in m from the first pose.
    pub(super) fn farthest(&self) -> f64 {
        self.farthest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::kinematics::Drive;
    use crate::task::Check;

    fn trace() -> Trace {
        Trace::new(Wiggle::new(Check::default(), &Drive::default()))
    }

    fn pose(time: f64, x: f64, heading: f64) -> Observation {
        Observation { pose: Pose::new(x, 0.0, heading), taken: RobotTime::new(time) }
    }

    #[test]
    fn it_takes_a_few_kilobytes_however_many_poses_come() {
        assert!(size_of::<Trace>() < 8 * 1024, "{}", size_of::<Trace>());
        let mut trace = trace();
        for n in 0..100_000 {
            trace.pose(pose(f64::from(n) / 240.0, 0.0, 0.0));
        }
        assert_eq!(trace.samples().len(), SAMPLES);
        assert!((trace.rate() - 240.0).abs() < 0.1);
    }

    /// Held against the sum and the centre of what is commanded, piece by piece.
    #[test]
    fn motions_are_told_apart_by_kind_and_side_and_a_pause_within_one_is_none() {
        let (mut trace, drive) = (trace(), Drive::default());
        trace.pose(pose(0.0, 0.0, 0.0));
        let mut command = |from: f64, linear: f64, angular: f64, duration: f64| {
            let twist = Twist::new(linear, angular);
            trace.command(RobotTime::new(from), twist, duration, drive.track_width);
        };
        command(1.0, 0.0, 0.3, 1.0);
        command(2.0, 0.0, 0.0, 1.0);
        command(3.0, 0.0, 0.3, 1.0);
        command(4.0, 0.1, 0.0, 2.0);
        command(6.0, -0.1, 0.0, 2.0);
        let [left, ahead, back] = trace.motions() else { panic!("{:?}", trace.motions()) };
        assert!((left.commanded - 0.6).abs() < 1e-12 && (left.centre() - 2.5).abs() < 1e-12);
        assert!(left.is_turn && (left.from, left.until) == (1.0, 4.0));
        assert!((ahead.commanded - 0.2).abs() < 1e-12 && (ahead.centre() - 5.0).abs() < 1e-12);
        assert!((back.commanded + 0.2).abs() < 1e-12 && (back.centre() - 7.0).abs() < 1e-12);
    }

    /// The sample variance, held against the definition.
    #[test]
    fn noise_is_that_of_the_poses_before_the_first_motion() {
        let mut trace = trace();
        let all = [0.001, -0.002, 0.003, 0.0, 0.004, -0.001];
        for (n, x) in all.into_iter().enumerate() {
            trace.pose(pose(n as f64 / 10.0, x, 0.0));
        }
        let mean = all.iter().sum::<f64>() / 6.0;
        let variance = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 5.0;
        let noise = trace.noise().unwrap();
        assert!((noise.position - (variance / 2.0).sqrt()).abs() < 1e-12, "{noise:?}");
    }
}
