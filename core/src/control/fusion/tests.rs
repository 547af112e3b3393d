use super::*;
use crate::geometry::Displacement;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;

const SPEED: f64 = 0.13;

/// A tracker's noise in m and rad.
const NOISE: (f64, f64) = (0.001, 0.005);

/// A robot that drives ahead, as its controller sees it.
struct World {
    random: Pcg64Mcg,
    /// Time in s between poses.
    interval: f64,
    pose: Pose,
    fusion: Option<Fusion>,
}

impl World {
    fn new(interval: f64, seed: u64) -> Self {
        let random = Pcg64Mcg::seed_from_u64(seed);
        Self { random, interval, pose: Pose::default(), fusion: None }
    }

    fn normal(&mut self) -> f64 {
        self.random.sample(StandardNormal)
    }

    fn noise() -> Matrix3<f64> {
        let (position, heading) = NOISE;
        Matrix3::from_diagonal(&[position, position, heading].map(|sd| sd * sd).into())
    }

    /// What the commands say: ahead, with errors of 3 % over 100 ms.
    fn commanded(&self, speed: f64) -> Moved {
        let forward = speed * self.interval;
        let spread = 0.03 * speed * (0.1 * self.interval).sqrt();
        let spreads = [spread, spread / 2.0, spread].map(|sd| sd * sd);
        Moved {
            by: Displacement { forward, ..Displacement::default() },
            covariance: Matrix3::from_diagonal(&spreads.into()),
        }
    }

    /// The robot moves at `speed` where `commanded` was; what is observed goes through `lie`.
    fn next(&mut self, speed: f64, commanded: f64, lie: impl FnOnce(Pose) -> Pose) -> Verdict {
        let moved = self.commanded(commanded);
        let [along, aside, around] = [(0, 0), (1, 1), (2, 2)].map(|at| moved.covariance[at].sqrt());
        let really = Displacement {
            forward: speed * self.interval + along * self.normal(),
            lateral: aside * self.normal(),
            turn: around * self.normal(),
        };
        let really = if speed == 0.0 { Displacement::default() } else { really };
        self.pose = self.pose.then(really);
        let Pose { x, y, heading } = self.pose;
        let (position, angle) = NOISE;
        let seen = Pose {
            x: x + position * self.normal(),
            y: y + position * self.normal(),
            heading: heading + angle * self.normal(),
        };
        let seen = lie(seen);
        let reach = Reach { far: SPEED * self.interval, round: 1.25 * self.interval };
        match &mut self.fusion {
            Some(fusion) => fusion.observe(&moved, reach, self.interval, seen, &Self::noise()),
            None => {
                self.fusion = Some(Fusion::new(seen, &Self::noise()));
                Verdict::Accepted
            }
        }
    }

    /// How far the robot is from where it is believed to be, in m and rad.
    fn off(&self) -> (f64, f64) {
        let mean = self.fusion.as_ref().unwrap().pose().mean;
        (mean.point().distance(self.pose.point()), mean.heading.minus(self.pose.heading).abs())
    }
}

/// Guards against: a tag's second solution drives the robot astray or stops it, whichever came first.
#[test]
fn where_poses_of_two_minds_alternate_the_way_decides() {
    for seed in 0..20 {
        for first in [0, 1] {
            let mut world = World::new(0.1, seed);
            for pose in 0..40 {
                let flips = (pose + first) % 2 == 1;
                let turned = if flips { 35_f64.to_radians() } else { 0.0 };
                let speed = if pose < 5 { 0.0 } else { SPEED };
                world.next(speed, speed, |it| Pose { heading: it.heading + turned, ..it });
                if pose > 15 {
                    let (far, round) = world.off();
                    assert!(round < 0.03 && far < 0.006, "{seed} {first} {pose}: {far} {round}");
                }
            }
        }
    }
}

/// Guards against: one pose out of many that lies moves the robot, or a few of them are believed.
#[test]
fn poses_that_lie_are_set_aside() {
    for interval in [0.004, 0.03, 0.1] {
        let mut world = World::new(interval, 3);
        let mut aside = 0;
        for pose in 0..400 {
            let lies = pose % 40 > 37;
            let by = world.normal();
            let lie = |it: Pose| if lies { Pose::new(it.x + 0.3 + by, it.y - by, by) } else { it };
            let verdict = world.next(SPEED, SPEED, lie);
            aside += u32::from(matches!(verdict, Verdict::SetAside { .. }));
            assert_eq!(matches!(verdict, Verdict::SetAside { .. }), lies, "{interval} {pose}");
            assert!(world.off().0 < 0.006, "{interval} {pose}: {:?}", world.off());
        }
        assert_eq!(aside, 20);
    }
}

/// Guards against: a map that is corrected, or a robot that is carried away, is never believed, or at once.
#[test]
fn a_robot_that_was_carried_is_found_again_in_half_a_second() {
    for interval in [0.004, 0.03, 0.1] {
        // Where the heading is another one the way tells that sooner.
        for (moved, least) in [(0.1, 0.05), (0.7, 0.015)] {
            let mut world = World::new(interval, 5);
            for _ in 0..40 {
                world.next(SPEED, SPEED, |it| it);
            }
            world.pose.y += moved;
            world.pose.heading = world.pose.heading + moved;
            let poses = (0..100).position(|_| world.next(SPEED, SPEED, |it| it) == Verdict::Again);
            let time = interval * (1 + poses.unwrap()) as f64;
            assert!((least..=0.5).contains(&time), "{interval} {moved}: after {time} s");
            assert!(world.off().0 < 0.006 && world.off().1 < 0.03, "{:?}", world.off());
        }
    }
}

/// Guards against: a robot whose wheels stand or that is pushed is taken for a tracker that lies.
#[test]
fn a_robot_that_does_otherwise_is_believed() {
    for interval in [0.004, 0.03, 0.1] {
        let mut world = World::new(interval, 7);
        for pose in 0..200 {
            let verdict = world.next(0.0, SPEED, |it| it);
            assert_eq!(verdict, Verdict::Accepted, "{interval} {pose}");
            assert!(world.off().0 < 0.006, "{interval} {pose}: {:?}", world.off());
        }
    }
}

/// Guards against: a filter that knows the robot no better than its last pose, or believes itself too much.
#[test]
fn a_fused_pose_is_as_good_as_it_says() {
    let (mut square, mut surprise, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..40 {
        let mut world = World::new(0.03, seed);
        for pose in 0..200 {
            world.next(SPEED, SPEED, |it| it);
            if pose >= 50 {
                let pose = world.fusion.as_ref().unwrap().pose();
                let off = pose.off(world.pose);
                let inverse = pose.covariance.try_inverse().unwrap();
                surprise += (off.transpose() * inverse * off)[(0, 0)] / 3.0;
                square += off[0] * off[0] + off[1] * off[1];
                count += 1.0;
            }
        }
    }
    let rms = (square / count / 2.0_f64).sqrt();
    assert!(rms < 0.5 * NOISE.0, "{rms} m");
    assert!((0.8..1.2).contains(&(surprise / count)), "{}", surprise / count);
}

/// Guards against: a pose that comes after a newer one is lost, or put where the robot is by now.
#[test]
fn a_late_pose_counts_where_it_was_taken() {
    let (mut late, mut without) = (0.0, 0.0);
    for seed in 0..200 {
        let mut world = World::new(0.1, seed);
        for _ in 0..10 {
            world.next(SPEED, SPEED, |it| it);
        }
        without += world.off().0.powi(2);
        // Of a tracker that is ten times better, taken two poses ago.
        let moved = world.commanded(2.0 * SPEED);
        let Pose { x, y, heading } = world.pose;
        let back = -moved.by.forward;
        let (sin, cos) = heading.radians().sin_cos();
        let then = Pose { x: x + cos * back, y: y + sin * back, heading };
        let fusion = world.fusion.as_mut().unwrap();
        fusion.observe_late(&moved, then, &(World::noise() * 0.01));
        late += world.off().0.powi(2);
    }
    assert!(late < 0.5 * without, "{late} against {without}");
}

/// A random walk of `slip` per step, seen through noise: how far its steps are off, and what is identified of the noise.
fn noise_of(sd: f64, slip: f64, poses: u32, seed: u64) -> Identified {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut normal = move || -> f64 { random.sample(StandardNormal) };
    let mut belief = NoiseBelief::default();
    let mut before = [0, 1, 2].map(|_| sd * normal());
    for _ in 0..poses {
        let now = [0, 1, 2].map(|_| sd * normal());
        let off = [0, 1, 2].map(|axis| slip * normal() + now[axis] - before[axis]);
        belief.push(&Step { off, turn: 0.0, kind: Kind::Drive, power: 1e-5 });
        before = now;
    }
    belief.identified()[0]
}

/// Guards against: slip that is taken for noise, noise for slip, and intervals that say more than is known.
#[test]
fn the_noise_is_told_from_slip_as_surely_as_is_said() {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let (mut held, runs) = (0, 400);
    for seed in 0..runs {
        let part = |random: &mut Pcg64Mcg| random.random::<f64>();
        let sd = 1e-4 * 300_f64.powf(part(&mut random));
        let slip = 1e-5 * 300_f64.powf(part(&mut random));
        let (low, high) = noise_of(sd, slip, 300, seed).interval;
        held += u32::from((low..=high).contains(&sd));
    }
    let share = f64::from(held) / f64::from(runs as u32);
    assert!((0.85..0.95).contains(&share), "{share}");
}

/// Guards against: a restart that shows another noise, or believes one for ever that is of another tracker.
#[test]
fn what_was_identified_goes_on_after_a_restart() {
    let before = noise_of(0.004, 1e-4, 500, 1);
    let mut belief = NoiseBelief::of([before, before]);
    assert_eq!(belief.identified(), [before, before]);
    belief.push(&Step { off: [0.0; 3], turn: 0.0, kind: Kind::Drive, power: 1e-5 });
    let after = belief.identified()[0];
    assert!((after.sd / before.sd - 1.0).abs() < 0.05, "{after:?} {before:?}");
    assert!(after.poses < 210.0 && after.interval.0 < before.interval.0);
}
