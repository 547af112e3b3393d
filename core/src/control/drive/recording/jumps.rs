//! Single poses that jump there and back, as trackers make them where two markers are taken for each other.

use super::Recording;
use crate::control::drive::stretch::{GAP, MEDIAN};
use crate::exchange::{Observation, PoseNoise};
use crate::geometry::{Twist, length};

/// Standard deviations of a pose beyond what the robot drives meanwhile from which on it jumps.
const FAR: f64 = 8.0;

/// Times the fastest command: robots are faster than commanded where wheels are told too small.
const FASTER: f64 = 2.0;

impl Recording {
    /// Leaves out every pose to which no robot of these commands gets and back, whose poses are known to `noise`, or to what
    /// they show where that is more. How many there were.
    pub fn leave_out_jumps(&mut self, noise: PoseNoise) -> usize {
        let noise = PoseNoise {
            position: noise.position.max(self.rough(|it| it.position)),
            heading: noise.heading.max(self.rough(|it| it.heading)),
        };
        let fastest = self.commands.iter().fold(Twist::ZERO, |fastest, (_, twist)| Twist {
            linear: fastest.linear.max(twist.linear.abs()),
            angular: fastest.angular.max(twist.angular.abs()),
        });
        let jumps: Vec<bool> = self.poses.windows(3).map(|it| jumps(it, noise, fastest)).collect();
        let (before, mut index) = (self.poses.len(), 0);
        self.poses.retain(|_| {
            index += 1;
            // The first window is about the second pose.
            !(index >= 2 && jumps.get(index - 2).copied().unwrap_or(false))
        });
        before - self.poses.len()
    }

    /// Standard deviation of a pose by how far it is from the middle of its neighbours, in the median: the noise, and what
    /// the robot does in the time between two poses.
    fn rough(&self, of: impl Fn(PoseNoise) -> f64) -> f64 {
        let mut apart: Vec<f64> = self.poses.windows(3).map(|it| of(off_the_middle(it))).collect();
        if apart.is_empty() {
            return 0.0;
        }
        let middle = apart.len() / 2;
        let (_, median, _) = apart.select_nth_unstable_by(middle, f64::total_cmp);
        // Off by its own variance and half of that for the mean of two others.
        *median / MEDIAN / 1.5_f64.sqrt()
    }
}

/// How far the second of three poses is from where it would be on the way from the first to the third.
fn off_the_middle(it: &[Observation]) -> PoseNoise {
    let (before, here, after) = (&it[0], &it[1], &it[2]);
    let part = (here.taken - before.taken) / (after.taken - before.taken);
    let (turned, turn) = (
        here.pose.heading.minus(before.pose.heading),
        after.pose.heading.minus(before.pose.heading),
    );
    let x = here.pose.x - before.pose.x - part * (after.pose.x - before.pose.x);
    let y = here.pose.y - before.pose.y - part * (after.pose.y - before.pose.y);
    // Of either axis.
    PoseNoise { position: x.abs().max(y.abs()), heading: (turned - part * turn).abs() }
}

/// Whether the second of three poses is one to which the robot gets and back.
fn jumps(it: &[Observation], noise: PoseNoise, fastest: Twist) -> bool {
    let (before, here, after) = (&it[0], &it[1], &it[2]);
    let durations = [here.taken - before.taken, after.taken - here.taken];
    if durations.iter().any(|duration| *duration > GAP) {
        return false;
    }
    let beyond = |lengths: [f64; 2], noise: f64, speed: f64| {
        let far = |(length, duration): (f64, f64)| length > FAR * noise + FASTER * speed * duration;
        lengths.into_iter().zip(durations).all(far)
    };
    let turns =
        [here.pose.heading.minus(before.pose.heading), after.pose.heading.minus(here.pose.heading)];
    let there = (here.pose.x - before.pose.x, here.pose.y - before.pose.y);
    let back = (after.pose.x - here.pose.x, after.pose.y - here.pose.y);
    let lengths = [length(there.0, there.1), length(back.0, back.1)];
    (turns[0] * turns[1] < 0.0 && beyond(turns.map(f64::abs), noise.heading, fastest.angular))
        || (there.0 * back.0 + there.1 * back.1 < 0.0
            && beyond(lengths, noise.position, fastest.linear))
}
