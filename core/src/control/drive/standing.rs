//! Whether wheels turned at the speeds that they were commanded to turn at: only what was commanded steadily, for longer than
//! the drive takes to follow, and by more than the noise of the poses, can be judged.

use super::band::Judgement;
use super::stretch::{Commanded, MAX_POSES, Seen, Stretch};
use crate::exchange::{Observation, PoseNoise};
use crate::geometry::{Twist, WheelSpeeds};
use crate::kinematics::{self, Drive};
use crate::time::RobotTime;
use arrayvec::ArrayVec;

/// Lags after which a drive has followed a command, but for 5 % of it.
const LAGS: f64 = 3.0;

/// Time in s beside that: a slot.
const SETTLES: f64 = 0.03;

/// Speeds that differ by less than this factor are one steady speed.
const STEADY: f64 = 1.05;

/// The same of two wheels that stand or turn together.
const TOGETHER: f64 = 1.2;

/// Part of the commanded motion below which nothing moved, and above which it did. What lies between is a floor, wheels that
/// are told wrong, or a part of the time, and is not judged.
const STOOD: f64 = 0.25;
const MOVED: f64 = 0.45;

/// Motion of any other kind than commanded, as a part of what was, above which a robot does not stand.
const ELSEWHERE: f64 = 0.4;

/// Standard deviation of that part up to which it is judged: four lie below the first threshold.
const SURE: f64 = 0.06;

/// Equal poses in a row from which on a tracker with noise is frozen.
const FROZEN: usize = 3;

/// Speeds in rad/s that are none.
const NO_SPEED: f64 = 1e-9;

/// Time in s after a command from which on a drive follows it.
pub fn settles(dead_time: f64, lag: f64) -> f64 {
    dead_time + LAGS * lag + SETTLES
}

/// Time in s for which a turn in place at `angular` rad/s is to last until it can be judged whether the robot turns, by
/// poses with this `noise`.
pub fn shows(angular: f64, noise: PoseNoise) -> f64 {
    2.0_f64.sqrt() * noise.heading.max(PoseNoise::LEAST.heading) / (SURE * angular)
}

/// Steady speeds of both wheels.
#[derive(Clone, Copy, Debug)]
struct Run {
    from: RobotTime,
    until: RobotTime,
    /// With their sign, the slower and the faster of each wheel.
    left: (f64, f64),
    right: (f64, f64),
}

impl Run {
    fn goes_on(&self, speeds: WheelSpeeds) -> Option<Self> {
        let left = steady(self.left, speeds.left)?;
        Some(Self { left, right: steady(self.right, speeds.right)?, ..*self })
    }
}

/// The range of speeds with another one, where it is still one.
fn steady((slow, fast): (f64, f64), speed: f64) -> Option<(f64, f64)> {
    let (slow, fast) = if speed.abs() < slow.abs() {
        (speed, fast)
    } else if speed.abs() > fast.abs() {
        (slow, speed)
    } else {
        (slow, fast)
    };
    let is_one = slow * fast >= 0.0 && fast.abs() <= STEADY * slow.abs().max(NO_SPEED);
    (is_one && speed * fast >= 0.0).then_some((slow, fast))
}

/// What is seen of a stretch whose commands (raw, whatever wheels make of them) a robot of this `drive` follows after
/// `settles` s: one judgement for each steady motion and wheel, or for both where they are equally fast.
pub fn judgements(
    stretch: &Stretch,
    commanded: &Commanded,
    drive: &Drive,
    settles: f64,
    noise: PoseNoise,
) -> Vec<Judgement> {
    let mut found = Vec::new();
    let mut run: Option<Run> = None;
    let mut judge = |run: &Run| {
        let is_in =
            |pose: &&Observation| pose.taken - run.from >= settles && run.until - pose.taken >= 0.0;
        let poses: ArrayVec<Observation, MAX_POSES> =
            stretch.poses.iter().filter(is_in).copied().collect();
        found.extend(judged(run, &poses, drive, noise));
    };
    for (from, twist, until) in commanded.each() {
        let speeds = kinematics::inverse(drive, twist);
        run = Some(match run.and_then(|run| run.goes_on(speeds)) {
            Some(on) => Run { until, ..on },
            None => {
                if let Some(run) = &run {
                    judge(run);
                }
                let (left, right) = ((speeds.left, speeds.left), (speeds.right, speeds.right));
                Run { from, until, left, right }
            }
        });
    }
    if let Some(run) = &run {
        judge(run);
    }
    found
}

fn judged(
    run: &Run,
    poses: &[Observation],
    drive: &Drive,
    noise: PoseNoise,
) -> ArrayVec<Judgement, 2> {
    let mut found = ArrayVec::new();
    let (Some(first), Some(last)) = (poses.first(), poses.last()) else { return found };
    let is_frozen = noise.position > 0.0
        && poses.len() >= FROZEN
        && poses.iter().all(|pose| pose.pose == first.pose);
    let span = last.taken - first.taken;
    if is_frozen || span <= 0.0 {
        return found;
    }
    let between = |described: f64, least: f64| 2.0_f64.sqrt() * described.max(least);
    let position = between(noise.position, PoseNoise::LEAST.position);
    let heading = between(noise.heading, PoseNoise::LEAST.heading);
    let seen = poses.windows(2).map(|pair| Seen::between(&pair[0], &pair[1]));
    let seen = seen.fold(Seen { driven: 0.0, aside: 0.0, turned: 0.0 }, |sum, it| Seen {
        driven: sum.driven + it.driven,
        aside: sum.aside + it.aside,
        turned: sum.turned + it.turned,
    });
    let wheels = [run.left, run.right].map(|(slow, fast)| (slow.abs(), fast.abs()));
    let [left, right] = wheels;
    let slowest = left.0.min(right.0);
    let fastest = left.1.max(right.1);
    let mean = WheelSpeeds {
        left: f64::midpoint(run.left.0, run.left.1),
        right: f64::midpoint(run.right.0, run.right.1),
    };
    if slowest > NO_SPEED && fastest <= TOGETHER * slowest {
        let Twist { linear, angular } = kinematics::forward(drive, mean);
        let (length, turn) = (linear * span / position, angular * span / heading);
        let (driven, turned) = (seen.driven / position, seen.turned / heading);
        let information = length * length + turn * turn;
        let part = (driven * length + turned * turn) / information;
        let all = (driven.hypot(turned)) / information.sqrt();
        found.extend(moved(part, all, information.sqrt().recip()).map(|moved| Judgement {
            moved,
            slowest,
            fastest,
        }));
        return found;
    }
    let half = drive.track_width / 2.0;
    let sd = position.hypot(half * heading) / drive.wheel_radius;
    for ((slowest, fastest), speed, side) in [(left, mean.left, -1.0), (right, mean.right, 1.0)] {
        if slowest <= NO_SPEED {
            continue;
        }
        let rolled = (seen.driven + side * half * seen.turned) / drive.wheel_radius;
        let commanded = speed * span;
        let part = rolled / commanded;
        let is_moved = moved(part, part.abs(), sd / commanded.abs());
        found.extend(is_moved.map(|moved| Judgement { moved, slowest, fastest }));
    }
    found
}

/// Whether what made this `part` of its commanded motion, known to `sd`, and `all` in any direction, moved; none where that
/// cannot be said.
fn moved(part: f64, all: f64, sd: f64) -> Option<bool> {
    let stood = part.abs() < STOOD && all < ELSEWHERE;
    let moved = part > MOVED;
    (sd <= SURE && (stood || moved)).then_some(moved)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::plant::{Plant, PlantModel};

    /// Poses of 1.2 s of a robot whose wheels stand below `band` rad/s, at `speeds` for 2 s, and what was commanded.
    fn driven(speeds: WheelSpeeds, band: f64) -> (Stretch, Commanded) {
        let model =
            PlantModel { noise: PoseNoise::CAMERA, dead_band: band, ..PlantModel::default() };
        let mut plant = Plant::new(model, Pose::default(), 4).unwrap();
        let mut stretch = Stretch::default();
        plant.advance(speeds, 0.8);
        for slot in 0..40 {
            let taken = RobotTime::new(0.8 + 0.03 * f64::from(slot));
            assert!(stretch.push(Observation { pose: plant.observe(), taken }));
            plant.advance(speeds, 0.03);
        }
        let mut commanded = Commanded::new(RobotTime::ZERO);
        commanded.add(kinematics::forward(&Drive::default(), speeds), 2.0);
        (stretch, commanded)
    }

    fn judge((stretch, commanded): &(Stretch, Commanded), settles: f64) -> Vec<Judgement> {
        judgements(stretch, commanded, &Drive::default(), settles, PoseNoise::CAMERA)
    }

    /// Guards against: a wheel that turns is said to stand, or one stands for both.
    #[test]
    fn each_wheel_is_judged_by_its_own_speed() {
        let both = |left: f64, right: f64, band: f64| {
            let found = judge(&driven(WheelSpeeds { left, right }, band), 0.4);
            found.iter().map(|it| (it.moved, (1e3 * it.fastest).round())).collect::<Vec<_>>()
        };
        assert_eq!(both(0.6, 0.6, 0.5), [(true, 600.0)]);
        assert_eq!(both(-0.6, 0.6, 0.7), [(false, 600.0)]);
        assert_eq!(both(1.0, 2.0, 1.5), [(false, 1000.0), (true, 2000.0)]);
        assert_eq!(both(0.0, 2.0, 0.5), [(true, 2000.0)]);
        assert_eq!(both(0.0, 0.0, 0.5), []);
    }

    /// Guards against: what is not seen yet, or drowns in noise, is said to stand.
    #[test]
    fn only_what_must_be_seen_is_judged() {
        let slow = driven(WheelSpeeds { left: -0.3, right: 0.3 }, 1.0);
        assert_eq!(judge(&slow, 0.4).len(), 1);
        assert_eq!(judge(&slow, 1.8), []);
        assert_eq!(judge(&driven(WheelSpeeds { left: -0.05, right: 0.05 }, 1.0), 0.4), []);
    }

    /// Guards against: a tracker that repeats its last pose teaches a dead band.
    #[test]
    fn a_frozen_tracker_says_nothing() {
        let (stretch, commanded) = driven(WheelSpeeds { left: 2.0, right: 2.0 }, 0.0);
        let pose = stretch.poses[0].pose;
        let mut frozen = Stretch::default();
        stretch.poses.iter().for_each(|it| assert!(frozen.push(Observation { pose, ..*it })));
        assert_eq!(judge(&(frozen, commanded), 0.4), []);
    }
}
