//! A stretch of motion: poses as they were seen, and what the commands in force would have made of them.

use crate::exchange::{Observation, PoseNoise};
use crate::geometry::Twist;
use crate::geometry::elementary::sin_cos;
use crate::kinematics;
use crate::prediction::Motion;
use crate::time::RobotTime;
use arrayvec::ArrayVec;

/// Most poses of a stretch.
pub const MAX_POSES: usize = 48;

/// Longest stretch in s.
pub const MAX_SPAN: f64 = 1.5;

/// Poses nearer to each other than this in s are passed over: a stretch of motion has room for so many.
pub const APART: f64 = 0.02;

/// Where poses are missing for longer in s, another stretch begins.
pub const GAP: f64 = 0.5;

/// Fewest third differences that say something of the noise.
const FEWEST_THIRDS: usize = 10;

/// Median distance from the mean in standard deviations, of a normal distribution.
pub(super) const MEDIAN: f64 = 0.674_5;

/// Poses, oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stretch {
    pub(super) poses: ArrayVec<Observation, MAX_POSES>,
}

/// What was commanded from some time on: twists and for how long in s, without a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Commanded {
    from: RobotTime,
    pieces: Vec<(Twist, f64)>,
}

/// What was seen between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Distance in m ahead, in the mean direction of the two.
    pub driven: f64,
    /// Distance in m to the left of that direction.
    pub aside: f64,
    /// Turn in rad.
    pub turned: f64,
}

impl Seen {
    /// The second pose as seen from the first.
    pub(super) fn between(from: &Observation, to: &Observation) -> Self {
        let turned = to.pose.heading.minus(from.pose.heading);
        let (sin, cos) = sin_cos(from.pose.heading.radians() + turned / 2.0);
        let (x, y) = (to.pose.x - from.pose.x, to.pose.y - from.pose.y);
        Self { driven: x * cos + y * sin, aside: y * cos - x * sin, turned }
    }
}

impl Commanded {
    /// Nothing yet, from `from` on.
    pub fn new(from: RobotTime) -> Self {
        Self { from, pieces: Vec::new() }
    }

    /// Goes on by `twist` for `duration` s.
    pub fn add(&mut self, twist: Twist, duration: f64) {
        match self.pieces.last_mut() {
            Some((last, so_far)) if *last == twist => *so_far += duration,
            _ => self.pieces.push((twist, duration)),
        }
    }

    /// Piece by piece: from when to when in robot time.
    pub(super) fn each(&self) -> impl Iterator<Item = (RobotTime, Twist, RobotTime)> + '_ {
        self.pieces.iter().scan(self.from, |from, &(twist, duration)| {
            let begins = *from;
            *from = begins + duration;
            Some((begins, twist, *from))
        })
    }

    /// The same commands of which the wheels make what `made` says.
    pub fn made(&self, made: impl Fn(Twist) -> Twist) -> Self {
        let mut all = Self::new(self.from);
        self.pieces.iter().for_each(|&(twist, duration)| all.add(made(twist), duration));
        all
    }

    /// Whether it drives, and does not only turn.
    pub(super) fn drives(&self) -> bool {
        self.pieces.iter().any(|(twist, _)| twist.linear != 0.0)
    }

    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        self.pieces.iter().any(|(twist, _)| *twist != Twist::ZERO)
    }
}

impl Stretch {
    /// Its first and last pose; none where it has none.
    pub fn ends(&self) -> Option<(Observation, Observation)> {
        Some((*self.poses.first()?, *self.poses.last()?))
    }

    /// Whether most of it is one pose: of a tracker that froze, or of one without noise that sees a robot stand.
    pub fn is_still(&self) -> bool {
        let same = self.poses.windows(2).filter(|pair| pair[0].pose == pair[1].pose).count();
        2 * same > self.poses.len()
    }

    /// One pose more, later than those before; whether there was room.
    pub fn push(&mut self, pose: Observation) -> bool {
        self.poses.try_push(pose).is_ok()
    }

    /// Noise of the poses as their third differences show it, which smooth motion has none of: the slip of a bad floor is in
    /// it, single jumps are not. None of a short stretch.
    pub(super) fn noise(&self) -> Option<PoseNoise> {
        let x = self.rough(|pose| pose.pose.x)?;
        let y = self.rough(|pose| pose.pose.y)?;
        let first = self.poses.first()?.pose.heading;
        let heading = self.rough(|pose| pose.pose.heading.minus(first))?;
        Some(PoseNoise { position: x.max(y), heading })
    }

    fn rough(&self, of: impl Fn(&Observation) -> f64) -> Option<f64> {
        let mut thirds: ArrayVec<f64, MAX_POSES> = self
            .poses
            .windows(4)
            .map(|it| (of(&it[3]) - 3.0 * of(&it[2]) + 3.0 * of(&it[1]) - of(&it[0])).abs())
            .collect();
        thirds.sort_unstable_by(f64::total_cmp);
        let median = thirds.get(thirds.len() / 2).filter(|_| thirds.len() >= FEWEST_THIRDS)?;
        // A third difference has 1 + 9 + 9 + 1 times the variance of a pose.
        Some(median / MEDIAN / 20.0_f64.sqrt())
    }

    /// Calls `each` with the motion that a drive of this dead time and lag in s would make of the commands between two
    /// poses, and what was seen of it.
    ///
    /// Commands before the first one known are taken for those of the first.
    pub(super) fn compare(
        &self,
        commanded: &Commanded,
        dead_time: f64,
        lag: f64,
        mut each: impl FnMut(Motion, Seen),
    ) {
        let Some(first) = self.poses.first() else { return };
        let mut wheels = Follower::new(commanded, dead_time, lag);
        wheels.advance(first.taken);
        for pair in self.poses.windows(2) {
            each(wheels.advance(pair[1].taken), Seen::between(&pair[0], &pair[1]));
        }
    }
}

/// A drive that follows its commands with dead time and lag.
pub(super) struct Follower<'a> {
    pieces: &'a [(Twist, f64)],
    /// The piece in force, and for how many s it still is.
    at: usize,
    left: f64,
    time: RobotTime,
    twist: Twist,
    lag: f64,
    /// The last duration in s of a step, and what it leaves of a difference: at its end, and on average.
    left_over: (f64, (f64, f64)),
}

impl<'a> Follower<'a> {
    /// Before the first command, as that one has it.
    pub(super) fn new(commanded: &'a Commanded, dead_time: f64, lag: f64) -> Self {
        let pieces = &commanded.pieces[..];
        let (twist, left) = pieces.first().copied().unwrap_or((Twist::ZERO, f64::INFINITY));
        let time = commanded.from + dead_time;
        Self { pieces, at: 0, left, time, twist, lag, left_over: (0.0, (1.0, 1.0)) }
    }

    /// The motion from where it is to `until`.
    fn advance(&mut self, until: RobotTime) -> Motion {
        let mut motion = Motion::NONE;
        self.each(until, |next| motion = motion.then(next));
        motion
    }

    /// The same, bit by bit: every motion under one command.
    pub(super) fn each(&mut self, until: RobotTime, mut each: impl FnMut(Motion)) {
        let mut rest = until - self.time;
        while rest > 0.0 {
            let is_last = self.at + 1 >= self.pieces.len();
            let duration = if is_last { rest } else { rest.min(self.left) };
            let command = self.pieces.get(self.at).map_or(Twist::ZERO, |(twist, _)| *twist);
            each(self.follow(command, duration));
            rest -= duration;
            self.left -= duration;
            if self.left <= 0.0 && !is_last {
                self.at += 1;
                self.left = self.pieces[self.at].1;
            }
        }
        self.time = self.time.later(until);
    }

    /// As [`kinematics::follow`] has it of the wheels.
    fn follow(&mut self, command: Twist, duration: f64) -> Motion {
        if command == self.twist || self.lag <= 0.0 {
            self.twist = command;
            return Motion::new(command, duration);
        }
        if self.left_over.0 != duration {
            self.left_over = (duration, kinematics::left_over(self.lag, duration));
        }
        let (end, mean) = self.left_over.1;
        let follow = |from: f64, to: f64, part: f64| to + (from - to) * part;
        let twist = self.twist;
        self.twist = Twist {
            linear: follow(twist.linear, command.linear, end),
            angular: follow(twist.angular, command.angular, end),
        };
        let mean = Twist {
            linear: follow(twist.linear, command.linear, mean),
            angular: follow(twist.angular, command.angular, mean),
        };
        Motion::new(mean, duration)
    }
}
