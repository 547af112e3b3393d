//! Windows of motion: where the robot went, compared with where its commands should have taken it.

use crate::exchange::Observation;
use crate::geometry::elementary::sin_cos;
use crate::geometry::{Displacement, Twist};
use crate::horizon::SLOT;
use crate::kinematics::{self, Drive, MotionModel};
use crate::prediction::{ERROR_WINDOW, Motion};
use crate::settings::PoseNoise;

/// Shortest window in slots: the first whole number of 30 ms slots above the thesis's 100 ms.
pub const WINDOW_SLOTS: f64 = 4.0;

/// Longest window in slots; a motion that is too small by then gives no sample.
pub const MAX_WINDOW_SLOTS: f64 = 16.0;

/// Pose noise may be at most this part of a window's motion before the window is closed: a longer one says more.
const NOISE_SHARE: f64 = 0.1;

/// Largest change of speed within a window, relative to its mean: "nearly equal" of thesis eq. 30.
const CONSTANT: f64 = 0.2;

/// Below this part of the smallest speeds a window counts as rest: what a lag leaves over.
const STANDSTILL: f64 = 0.1;

/// The motion that commands alone would make of the robot's turning centre, with the actuator's lag, since the window's first
/// pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The pose at its beginning.
    pub start: Observation,
    /// Where it leads, and what it is made of.
    nominal: Displacement,
    motion: Motion,
    /// Slowest and fastest speeds, component by component; none in an empty window.
    range: Option<(Twist, Twist)>,
}

/// One error ratio from one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// (measured - nominal)/commanded motion.
    pub ratio: f64,
    /// Variance of the ratio is sigma^2/weight: weight = (int v dt)^2/(0.1 s x int v^2 dt).
    pub weight: f64,
    /// Commanded motion that one unit of pose noise is divided by, signed: m or rad.
    pub motion: f64,
    /// Variance of one pose's noise in the units of `motion`.
    pub pose_variance: f64,
    /// Further known variance of the ratio, not shared with the neighbouring windows.
    pub other_variance: f64,
}

/// What a finished window says, per channel in the order of `Channel::ALL`.
pub type Samples = [Option<Sample>; 4];

/// Whether a window is to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Too short so far, or too small a motion.
    Open,
    /// At rest: nothing to learn, nothing rejected.
    Rest,
    /// The commanded motion changed: no sample.
    Rejected,
    /// Samples.
    Closed(Samples),
}

impl Window {
    /// A window that begins at an accepted pose.
    pub fn new(start: Observation) -> Self {
        Self { start, nominal: Displacement::default(), motion: Motion::NONE, range: None }
    }

    /// Adds a piece of commanded motion: the mean twist over `duration` s. Returns where it leads.
    pub fn add(&mut self, twist: Twist, duration: f64) -> Displacement {
        let motion = Motion::new(twist, duration);
        let piece = kinematics::arc(motion.length, motion.turn);
        self.nominal = self.nominal.then(piece);
        self.motion = self.motion.then(motion);
        let (slowest, fastest) = self.range.unwrap_or((twist, twist));
        let range = |pick: fn(f64, f64) -> f64, so_far: Twist| {
            Twist::new(pick(so_far.linear, twist.linear), pick(so_far.angular, twist.angular))
        };
        self.range = Some((range(f64::min, slowest), range(f64::max, fastest)));
        piece
    }

    /// The motion that the commands alone make from the window's start.
    pub fn nominal(&self) -> Displacement {
        self.nominal
    }

    /// What the window is worth with the pose `end`, to which its motion has been added.
    pub fn verdict(&self, drive: &Drive, noise: PoseNoise, end: &Observation) -> Verdict {
        let Some((slowest, fastest)) = self.range else { return Verdict::Rest };
        let linear = slowest.linear.abs().max(fastest.linear.abs());
        let angular = slowest.angular.abs().max(fastest.angular.abs());
        if linear < STANDSTILL * drive.min_linear && angular < STANDSTILL * drive.min_angular {
            return Verdict::Rest;
        }
        let drives = steady(slowest.linear, fastest.linear, drive.min_linear);
        let turns = steady(slowest.angular, fastest.angular, drive.min_angular);
        if !drives && !turns {
            return Verdict::Rejected;
        }
        let slots = self.motion.duration / SLOT + 0.5;
        let small =
            |motion: f64, noise: f64| motion.abs() * NOISE_SHARE < std::f64::consts::SQRT_2 * noise;
        let too_small = (drives && small(self.motion.length, noise.position))
            || (turns && !drives && small(self.motion.turn, noise.heading));
        if slots < WINDOW_SLOTS || (too_small && slots < MAX_WINDOW_SLOTS) {
            return Verdict::Open;
        }
        let measured = drive.of_centre(end.pose.relative_to(self.start.pose));
        Verdict::Closed(self.samples(noise, measured, drives, turns))
    }

    fn samples(
        &self,
        noise: PoseNoise,
        measured: Displacement,
        drives: bool,
        turns: bool,
    ) -> Samples {
        let Motion { length, turn, duration, length_power, turn_power } = self.motion;
        // The error along and across the direction of motion: that of the chord, at half the turn.
        let (sin, cos) = sin_cos(turn / 2.0);
        let ahead = measured.forward - self.nominal.forward;
        let aside = measured.lateral - self.nominal.lateral;
        let along = cos * ahead + sin * aside;
        let across = cos * aside - sin * ahead;
        let around = crate::geometry::Angle::new(measured.turn - self.nominal.turn).radians();
        let (position, heading) = (noise.position * noise.position, noise.heading * noise.heading);
        let sample = |error: f64, motion: f64, power: f64, pose_variance, other_variance| Sample {
            ratio: error / motion,
            weight: motion * motion / (ERROR_WINDOW * power),
            motion,
            pose_variance,
            other_variance,
        };
        let by_length =
            |error, pose, other| drives.then(|| sample(error, length, length_power, pose, other));
        // Rotation informs the turn only; a turn while driving would mix turn and drift.
        let straight = !turns && turn.abs() < kinematics::STRAIGHT_BELOW * duration;
        [
            by_length(along, position, 0.0),
            // The starting heading's noise points the whole nominal motion aside.
            by_length(across, position, heading),
            turns.then(|| sample(around, turn, turn_power, heading, 0.0)),
            if straight { by_length(around, heading, 0.0) } else { None },
        ]
    }
}

/// Whether a speed between `slowest` and `fastest` is nearly constant and at least `minimum`.
fn steady(slowest: f64, fastest: f64, minimum: f64) -> bool {
    let mean = f64::midpoint(slowest, fastest).abs();
    mean >= 0.99 * minimum && fastest - slowest <= CONSTANT * mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::time::RobotTime;

    const NOISE: PoseNoise = PoseNoise { position: 0.0, heading: 0.0 };

    fn observed(pose: Pose, taken: f64) -> Observation {
        Observation { pose, taken: RobotTime::new(taken) }
    }

    /// A window of `slots` slots at `twist`, in a robot whose forward and turn ratios are off as given.
    fn driven(twist: Twist, slots: u32, forward: f64, turn: f64) -> (Window, Observation) {
        let start = Pose::new(0.3, -0.2, 2.0);
        let mut window = Window::new(observed(start, 1.0));
        let duration = SLOT * f64::from(slots);
        for _ in 0..slots {
            window.add(twist, SLOT);
        }
        let real = Twist::new(twist.linear * (1.0 + forward), twist.angular * (1.0 + turn));
        let end = start.then(kinematics::integrate(real, duration));
        (window, observed(end, 1.0 + duration))
    }

    #[test]
    fn a_straight_window_gives_the_forward_ratio() {
        let (window, end) = driven(Twist::new(0.1, 0.0), 4, -0.2, 0.0);
        let Verdict::Closed([Some(forward), Some(lateral), None, Some(drift)]) =
            window.verdict(&Drive::default(), NOISE, &end)
        else {
            panic!("{:?}", window.verdict(&Drive::default(), NOISE, &end));
        };
        assert!((forward.ratio + 0.2).abs() < 1e-9);
        assert!(lateral.ratio.abs() < 1e-9 && drift.ratio.abs() < 1e-9);
        assert!((forward.weight - 1.2).abs() < 1e-9, "120 ms are 1.2 x 100 ms");
    }

    #[test]
    fn a_rotation_informs_the_turn_only() {
        let (window, end) = driven(Twist::new(0.0, -0.8), 4, 0.0, 0.15);
        let Verdict::Closed([None, None, Some(turn), None]) =
            window.verdict(&Drive::default(), NOISE, &end)
        else {
            panic!();
        };
        assert!((turn.ratio - 0.15).abs() < 1e-9);
    }

    #[test]
    fn reversing_keeps_the_sign_of_the_ratio() {
        let (window, end) = driven(Twist::new(-0.1, 0.0), 4, -0.3, 0.0);
        let Verdict::Closed([Some(forward), ..]) = window.verdict(&Drive::default(), NOISE, &end)
        else {
            panic!();
        };
        assert!((forward.ratio + 0.3).abs() < 1e-9);
    }

    #[test]
    fn a_changing_motion_is_rejected_and_rest_is_not() {
        let drive = Drive::default();
        let mut window = Window::new(observed(Pose::default(), 0.0));
        for v in [0.03, 0.05, 0.07, 0.09] {
            window.add(Twist::new(v, 0.0), SLOT);
        }
        let end = observed(Pose::default(), 0.12);
        assert_eq!(window.verdict(&drive, NOISE, &end), Verdict::Rejected);
        let mut rest = Window::new(observed(Pose::default(), 0.0));
        rest.add(Twist::ZERO, 0.12);
        assert_eq!(rest.verdict(&drive, NOISE, &end), Verdict::Rest);
    }

    #[test]
    fn a_slow_motion_takes_a_longer_window_above_the_noise() {
        let noise = PoseNoise { position: 0.0005, heading: 0.003 };
        let (window, end) = driven(Twist::new(0.03, 0.0), 4, 0.0, 0.0);
        assert_eq!(window.verdict(&Drive::default(), noise, &end), Verdict::Open);
        let (window, end) = driven(Twist::new(0.03, 0.0), 8, 0.0, 0.0);
        assert!(matches!(window.verdict(&Drive::default(), noise, &end), Verdict::Closed(_)));
    }
}
