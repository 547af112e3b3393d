//! A robot under check in simulated time, with what may be wrong with it and its tracker.

use crate::actuation::Actuation;
use crate::check::{Fault, Report};
use crate::controller::Controller;
use crate::exchange::{Exchange, Observation, PoseNoise, Request};
use crate::geometry::{Pose, Twist, WheelSpeeds};
use crate::horizon::Horizon;
use crate::kinematics::{self, Drive};
use crate::settings::Settings;
use crate::task::{Check, Stage, Task};
use crate::time::RobotTime;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;
use std::collections::VecDeque;
use std::sync::Arc;

/// Steps of the simulation in s.
const TICK: f64 = 0.005;

/// Robot time at which a run begins.
const START: f64 = 50.0;

/// What the tracker makes of a pose at a time since the start: x and y, heading; none is a lost frame.
pub type Show = Box<dyn FnMut(f64, [f64; 3]) -> Option<[f64; 3]>>;

/// Wheel speeds made of those commanded.
pub type Wheels = fn(WheelSpeeds) -> WheelSpeeds;

/// What its controller is told.
pub type Order = fn(&mut Controller);

/// One run.
pub struct Robot {
    /// As it is described.
    pub settings: Settings,
    /// As it is.
    pub real: Drive,
    pub wheels: Wheels,
    /// What of a twist is made, forward and turned; and how much it differs from slot to slot.
    pub floor: (f64, f64),
    pub slip: f64,
    /// Poses a second.
    pub rate: f64,
    /// Noise of the poses, before the tracker makes anything of them.
    pub noise: PoseNoise,
    pub show: Show,
    /// When a pose taken at a time is said to have been.
    pub stamp: fn(f64) -> f64,
    /// Time in s from a pose to its being known, of a request and of its reply.
    pub delays: (f64, f64, f64),
    pub start: Pose,
    pub seed: u64,
    /// Orders at times.
    pub orders: Vec<(f64, Order)>,
}

pub struct Run {
    pub controller: Controller,
    pub report: Option<Arc<Report>>,
    /// When it ended.
    pub ended: Option<f64>,
    /// Farthest from the start in m, and whether it was at rest at the end.
    pub away: f64,
    pub rests: bool,
}

impl Robot {
    /// A robot with nothing wrong under a camera of 10 Hz, at a heading at which no axis hides another.
    pub fn new(drive: Drive) -> Self {
        let noise = PoseNoise { position: 0.001, heading: 0.005 };
        Self {
            settings: Settings { drive, noise, ..Settings::default() },
            real: drive,
            wheels: |speeds| speeds,
            floor: (1.0, 1.0),
            slip: 0.0,
            rate: 10.0,
            noise,
            show: Box::new(|_, pose| Some(pose)),
            stamp: |t| t,
            delays: (0.03, 0.01, 0.01),
            start: Pose::new(1.3, -0.7, 0.6),
            seed: 1,
            orders: Vec::new(),
        }
    }

    /// Checks it.
    pub fn run(mut self) -> Run {
        let described = self.settings.drive;
        let mut controller = Controller::new(self.settings);
        controller.set_task(Task::checking(Check::default()));
        let mut random = Pcg64Mcg::seed_from_u64(self.seed);
        let start = RobotTime::new(START);
        let (mut exchange, mut actuation) =
            (Exchange::new(start), Actuation::new(described, start));
        let (mut pose, mut speeds) = (self.start, WheelSpeeds::ZERO);
        let mut waiting: VecDeque<(f64, WheelSpeeds)> = VecDeque::new();
        let mut seen: VecDeque<(f64, Observation)> = VecDeque::new();
        let mut up: VecDeque<(f64, Request)> = VecDeque::new();
        let mut down: VecDeque<(f64, Horizon)> = VecDeque::new();
        let (mut frames, mut away, mut ended, mut rests) = (0_u64, 0.0_f64, None, false);
        for tick in 0..(120.0 / TICK) as u64 {
            let t = tick as f64 * TICK;
            let now = RobotTime::new(START + t);
            let mut normal = || random.sample::<f64, _>(StandardNormal);
            if t >= frames as f64 / self.rate - 1e-9 {
                frames += 1;
                let noisy = [
                    pose.x + self.noise.position * normal(),
                    pose.y + self.noise.position * normal(),
                    pose.heading.radians() + self.noise.heading * normal(),
                ];
                if let Some([x, y, heading]) = (self.show)(t, noisy) {
                    let taken = RobotTime::new(START + (self.stamp)(t));
                    let pose = Pose::new(x, y, heading);
                    seen.push_back((t + self.delays.0, Observation { pose, taken }));
                }
            }
            while seen.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                exchange.observe(seen.pop_front().unwrap().1);
            }
            while down.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                let (_, horizon) = down.pop_front().unwrap();
                exchange.reply(now, horizon.answers);
                actuation.accept(&horizon);
            }
            if let Some(request) = exchange.request(now, actuation.playing()) {
                up.push_back((t + self.delays.1, request));
            }
            if let Some((_, order)) = self.orders.first().filter(|(at, _)| t >= *at) {
                order(&mut controller);
                self.orders.remove(0);
            }
            while up.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                let (_, request) = up.pop_front().unwrap();
                let output = controller.step(&request);
                down.push_back((t + self.delays.2, output.horizon));
            }
            let commanded = actuation.advance(now);
            rests = commanded == WheelSpeeds::ZERO;
            waiting.push_back((t + self.real.dead_time, (self.wheels)(commanded)));
            let (lag, mut wanted) = (self.real.lag, speeds);
            while waiting.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                wanted = waiting.pop_front().unwrap().1;
            }
            (speeds, _) = kinematics::follow(lag, speeds, wanted, TICK);
            let twist = kinematics::forward(&self.real, speeds);
            let (forward, turned) = self.floor;
            // White slip: so much of the motion over 100 ms.
            let slip = self.slip * (0.1 / TICK).sqrt();
            let twist = Twist::new(
                twist.linear * (forward + slip * normal()),
                twist.angular * (turned + slip * normal()),
            );
            pose = pose.then(kinematics::integrate(twist, TICK));
            away = away.max(pose.point().distance(self.start.point()));
            if ended.is_none() && controller.progress().stage == Stage::Arrived {
                ended = Some(t);
            }
            if ended.is_some_and(|at| t > at + 1.0) {
                break;
            }
        }
        let report = controller.report().cloned();
        Run { controller, report, ended, away, rests }
    }

    /// What is wrong with it.
    pub fn faults(self) -> Vec<Fault> {
        self.run().faults()
    }
}

impl Run {
    pub fn faults(&self) -> Vec<Fault> {
        let report = self.report.as_ref().expect("a check ends");
        report.findings.iter().map(|finding| finding.fault()).collect()
    }
}

/// Noise of a poor camera.
pub const POOR: PoseNoise = PoseNoise { position: 0.003, heading: 0.0175 };

/// A robot with nothing wrong under a poor camera that is described.
pub fn poor(drive: Drive, rate: f64, seed: u64) -> Robot {
    let robot = Robot::new(drive);
    let settings = Settings { noise: POOR, ..robot.settings };
    Robot { noise: POOR, settings, rate, seed, ..robot }
}

pub fn rover() -> Drive {
    Drive::default()
}

/// A robot of the size of a coin, on wheels of 5 mm.
pub fn coin() -> Drive {
    Drive {
        wheel_radius: 0.005,
        track_width: 0.02,
        max_wheel_speed: 20.0,
        max_linear: 0.08,
        min_linear: 0.005,
        max_angular: 4.0,
        min_angular: 0.3,
        max_linear_acceleration: 0.5,
        max_angular_acceleration: 20.0,
        ..Drive::default()
    }
}

/// A warehouse robot, 1.3 m wide.
pub fn truck() -> Drive {
    Drive {
        wheel_radius: 0.1,
        track_width: 1.3,
        max_wheel_speed: 25.0,
        max_linear: 2.0,
        min_linear: 0.05,
        max_angular: 0.7,
        min_angular: 0.05,
        max_linear_acceleration: 0.6,
        max_angular_acceleration: 0.7,
        ..Drive::default()
    }
}
