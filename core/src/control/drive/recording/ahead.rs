//! How far poses of a recording are from where a drive has them, predicted some time ahead.

use super::super::stretch::Follower;
use super::Recording;
use crate::control::drive::{DriveBelief, LONGEST, Quantity};
use crate::geometry::{Pose, Twist};
use crate::kinematics::arc;
use crate::prediction::Scale;
use crate::time::RobotTime;

/// How a drive is taken to follow its commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followed {
    /// Time in s before it begins to follow.
    pub dead_time: f64,
    /// Time constant in s with which it follows then.
    pub lag: f64,
    /// Forward motion per commanded forward motion.
    pub forward: f64,
    /// Turn per commanded turn.
    pub turn: f64,
    /// Turn in rad per commanded m.
    pub drift: f64,
}

/// Errors of predicted poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorsAhead {
    /// How far ahead in s they were predicted, on average.
    pub ahead: f64,
    /// How many.
    pub poses: usize,
    /// Of the heading, in rad.
    pub heading: Percentiles,
    /// Distance in m.
    pub position: Percentiles,
}

/// Of sizes of errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Percentiles {
    /// Half are no larger.
    pub p50: f64,
    /// Nine of ten are no larger.
    pub p90: f64,
}

impl DriveBelief {
    /// What it expects of the drive.
    pub fn followed(&self) -> Followed {
        let (dead_time, lag) = self.grid.expected();
        let Scale { forward, turn, drift } = self.scale();
        Followed { dead_time, lag, forward: 1.0 + forward, turn: 1.0 + turn, drift }
    }

    /// Turn per commanded turn, and forward motion per commanded forward motion.
    pub fn ratios(&self) -> (Quantity, Quantity) {
        let [forward, turn, _] =
            self.together().map(|it| Quantity::normal(1.0 + it.mean, it.variance));
        (turn, forward)
    }
}

/// A pose of the recording, as the commands have it.
pub(super) struct Reckoned {
    /// From an arbitrary start, without a correction ever.
    pub(super) pose: Pose,
    /// Until when something was commanded to move.
    moved: RobotTime,
}

impl Recording {
    /// From every pose after `from`, the pose some `ahead` s later is predicted as the commands have it, followed so
    /// from the first command on; the errors of those during or shortly after something is commanded to move. None where
    /// there are no such.
    pub fn errors_ahead(
        &self,
        followed: &Followed,
        from: RobotTime,
        ahead: f64,
    ) -> Option<ErrorsAhead> {
        let (known, until) = self.known()?;
        let (from, reckoned) = (from.later(known), self.reckon(followed));
        let nearest = self.interval()? / 2.0;
        let (mut headings, mut positions, mut sum) = (Vec::new(), Vec::new(), 0.0);
        let mut then = 0;
        for (now, seen) in self.poses.iter().enumerate() {
            let goal = seen.taken + ahead;
            let off = |index: usize| (self.poses[index].taken - goal).abs();
            while then + 1 < self.poses.len() && off(then + 1) <= off(then) {
                then += 1;
            }
            let later = &self.poses[then];
            let is_known = seen.taken >= from && later.taken <= until;
            let moves = reckoned[then].moved >= seen.taken - LONGEST;
            if then <= now || off(then) > nearest || !is_known || !moves {
                continue;
            }
            let motion = reckoned[then].pose.relative_to(reckoned[now].pose);
            let predicted = seen.pose.then(motion);
            headings.push(later.pose.heading.minus(predicted.heading).abs());
            positions.push(later.pose.point().distance(predicted.point()));
            sum += later.taken - seen.taken;
        }
        let poses = headings.len();
        Some(ErrorsAhead {
            ahead: sum / poses as f64,
            poses,
            heading: Percentiles::of(headings)?,
            position: Percentiles::of(positions)?,
        })
    }

    /// Where the robot is at every pose as the commands have it, which are followed so.
    pub(super) fn reckon(&self, followed: &Followed) -> Vec<Reckoned> {
        let Followed { dead_time, lag, forward, turn, drift } = *followed;
        let start = self.commands.first().map_or(RobotTime::NEVER, |(time, _)| *time);
        let end = self.poses.last().map_or(start, |pose| pose.taken);
        let commanded = self.commanded(start, end, &mut 0);
        let mut wheels = Follower::new(&commanded, dead_time, lag);
        let (mut pose, mut next) = (Pose::default(), 0);
        let (mut moved, mut is_moving) = (RobotTime::BEFORE_ALL, false);
        let reckon = |time: RobotTime| {
            wheels.each(time, |motion| {
                let turned = turn * motion.turn + drift * motion.length;
                pose = pose.then(arc(forward * motion.length, turned));
            });
            while let Some((begin, twist)) = self.commands.get(next).filter(|it| it.0 <= time) {
                moved = if is_moving { *begin } else { moved };
                is_moving = *twist != Twist::ZERO;
                next += 1;
            }
            moved = if is_moving { time } else { moved };
            Reckoned { pose, moved }
        };
        self.poses.iter().map(|pose| pose.taken).map(reckon).collect()
    }

    /// Median time in s between two poses; none of less than two.
    pub fn interval(&self) -> Option<f64> {
        let between = self.poses.windows(2).map(|pair| pair[1].taken - pair[0].taken);
        Some(Percentiles::of(between.collect())?.p50)
    }
}

impl Percentiles {
    /// None of no values.
    fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_unstable_by(f64::total_cmp);
        let at = |part: f64| values.get((values.len() as f64 * part) as usize).copied();
        Some(Self { p50: at(0.5)?, p90: at(0.9)? })
    }
}
