//! A robot, its camera and its link in simulated time, with what may be wrong with each.

use crate::METHOD;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;
use std::collections::VecDeque;
use umwelt_core::actuation::Actuation;
use umwelt_core::controller::{Controller, Event};
use umwelt_core::exchange::{Exchange, Observation, Request};
use umwelt_core::geometry::{Point, Pose, Twist, WheelSpeeds};
use umwelt_core::horizon::Horizon;
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::settings::{Attribution, Method, Settings};
use umwelt_core::task::{Stage, Task};
use umwelt_core::time::RobotTime;
use umwelt_core::watch::{Alarm, Condition};

/// Steps of the simulation in s.
const TICK: f64 = 0.005;

/// Robot time at which a run begins.
const START: f64 = 100.0;

/// Wheel speeds really made of those commanded, at a time since the start.
pub type Wheels = Box<dyn Fn(f64, WheelSpeeds) -> WheelSpeeds>;

/// The twist of the body really made of that of the wheels, at a time since the start.
pub type Floor = Box<dyn Fn(f64, Twist) -> Twist>;

/// The pose shown for a true one with its noise, at the n-th frame and a time since the start; none is a lost frame.
pub type Show = Box<dyn FnMut(u64, f64, Pose) -> Option<Pose>>;

/// One run.
pub struct World {
    pub settings: Settings,
    pub task: Task,
    /// Poses per second.
    pub rate: f64,
    /// Noise of the poses in m and rad.
    pub noise: (f64, f64),
    /// Sensor delay, uplink and downlink in s.
    pub delays: (f64, f64, f64),
    /// Lag in s of the wheels beyond what was described.
    pub lag: f64,
    pub wheels: Wheels,
    pub floor: Floor,
    pub show: Show,
    pub seed: u64,
}

/// The results of a run.
pub struct Run {
    pub controller: Controller,
    pub events: Vec<(f64, Event)>,
    /// Time since the start, true pose, true twist, commanded twist.
    pub track: Vec<(f64, Pose, Twist, Twist)>,
    pub arrived: Option<f64>,
}

pub fn rover() -> Drive {
    Drive::default()
}

/// A 1.3 m wide warehouse robot.
pub fn amr() -> Drive {
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

/// A robot of the size of a coin, on wheels of 5 mm.
pub fn mini() -> Drive {
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

/// A classroom robot.
pub fn burger() -> Drive {
    Drive {
        wheel_radius: 0.033,
        track_width: 0.16,
        max_wheel_speed: 6.67,
        max_linear: 0.22,
        min_linear: 0.01,
        max_angular: 2.5,
        min_angular: 0.05,
        max_linear_acceleration: 0.5,
        max_angular_acceleration: 3.0,
        ..Drive::default()
    }
}

/// With what its method asks for: adaptive identifies lag and noise, against the commands as played.
fn asked(settings: Settings) -> Settings {
    if settings.method != Method::Adaptive {
        return settings;
    }
    let attribution = Attribution::Played;
    Settings { attribution, identifies_lag: true, identifies_noise: true, ..settings }
}

impl World {
    /// A robot on its way to `to`, with nothing wrong, seen 30 times a second with the noise of a camera.
    pub fn new(drive: Drive, to: &[(f64, f64)]) -> Self {
        let waypoints = to.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let steering = umwelt_core::settings::SteeringSettings {
            alpha: drive.max_linear.max(0.2),
            ..Default::default()
        };
        Self {
            settings: asked(Settings { drive, steering, method: METHOD, ..Settings::default() }),
            task: Task { waypoints, calibration: None, ..Task::thesis() },
            rate: 30.0,
            noise: (0.0005, 0.003),
            delays: (0.03, 0.002, 0.002),
            lag: 0.0,
            wheels: Box::new(|_, speeds| speeds),
            floor: Box::new(|_, twist| twist),
            show: Box::new(|_, _, pose| Some(pose)),
            seed: 1,
        }
    }

    /// Runs for `seconds`, or until a second after the arrival.
    pub fn run(self, seconds: f64) -> Run {
        self.run_with(seconds, |_| {})
    }

    /// The same, with a look at the controller after each step.
    pub fn run_with(mut self, seconds: f64, mut look: impl FnMut(&Controller)) -> Run {
        let drive = self.settings.drive;
        let mut controller = Controller::new(self.settings);
        controller.set_task(self.task.clone());
        let mut random = Pcg64Mcg::seed_from_u64(self.seed);
        let (mut exchange, mut actuation) =
            (Exchange::new(RobotTime::new(START)), Actuation::new(drive, RobotTime::new(START)));
        let (mut pose, mut real) = (Pose::default(), WheelSpeeds::ZERO);
        let mut seen: VecDeque<(f64, Observation)> = VecDeque::new();
        let mut up: VecDeque<(f64, Request)> = VecDeque::new();
        let mut down: VecDeque<(f64, Horizon)> = VecDeque::new();
        let mut run = Run { controller, events: Vec::new(), track: Vec::new(), arrived: None };
        let mut frames = 0_u64;
        for tick in 0..(seconds / TICK) as u64 {
            let t = tick as f64 * TICK;
            let now = RobotTime::new(START + t);
            if t >= frames as f64 / self.rate - 1e-9 {
                frames += 1;
                let mut normal = || random.sample::<f64, _>(StandardNormal);
                let (position, heading) = self.noise;
                let noisy = Pose {
                    x: pose.x + position * normal(),
                    y: pose.y + position * normal(),
                    heading: pose.heading + heading * normal(),
                };
                if let Some(pose) = (self.show)(frames, t, noisy) {
                    seen.push_back((t + self.delays.0, Observation { pose, taken: now }));
                }
            }
            while seen.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                exchange.observe(seen.pop_front().expect("there is one").1);
            }
            while down.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                let (_, horizon) = down.pop_front().expect("there is one");
                exchange.reply(now, horizon.answers);
                actuation.accept(&horizon);
            }
            if let Some(request) = exchange.request(now, actuation.playing()) {
                up.push_back((t + self.delays.1, request));
            }
            while up.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                let (_, request) = up.pop_front().expect("there is one");
                let output = run.controller.step(&request);
                look(&run.controller);
                run.events.extend(output.events.iter().map(|event| (t, *event)));
                down.push_back((t + self.delays.2, output.horizon));
            }
            let commanded = actuation.advance(now);
            let wanted = (self.wheels)(t, commanded);
            let share = if self.lag > 0.0 { (TICK / self.lag).min(1.0) } else { 1.0 };
            real.left += share * (wanted.left - real.left);
            real.right += share * (wanted.right - real.right);
            let twist = (self.floor)(t, kinematics::forward(&drive, real));
            pose = pose.then(kinematics::integrate(twist, TICK));
            run.track.push((t, pose, twist, kinematics::forward(&drive, commanded)));
            if run.arrived.is_none() && run.controller.progress().stage == Stage::Arrived {
                run.arrived = Some(t);
            }
            if run.arrived.is_some_and(|at| t > at + 1.0) {
                break;
            }
        }
        run
    }
}

impl Run {
    /// When, and what, the watch brought the robot to rest for.
    pub fn alarm(&self) -> Option<(f64, Alarm)> {
        self.events.iter().find_map(|(t, event)| match event {
            Event::Found { alarm, rests: true } => Some((*t, *alarm)),
            _ => None,
        })
    }

    pub fn condition(&self) -> Option<Condition> {
        self.alarm().map(|(_, alarm)| alarm.condition())
    }

    /// What the watch remarked, in order.
    pub fn remarks(&self) -> Vec<Condition> {
        let remark = |(_, event): &(f64, Event)| match event {
            Event::Found { alarm, rests: false } => Some(alarm.condition()),
            _ => None,
        };
        self.events.iter().filter_map(remark).collect()
    }

    /// The first time after which only rest is commanded, to the end.
    pub fn rests_from(&self) -> Option<f64> {
        let moving = self.track.iter().rposition(|(.., commanded)| *commanded != Twist::ZERO);
        let next = moving.map_or(0, |last| last + 1);
        self.track.get(next).map(|(t, ..)| *t)
    }

    /// Largest distance from the start in m.
    pub fn away(&self) -> f64 {
        self.track.iter().map(|(_, pose, ..)| pose.x.hypot(pose.y)).fold(0.0, f64::max)
    }

    /// Radians turned and metres driven in all.
    pub fn turned(&self) -> (f64, f64) {
        self.track.iter().fold((0.0, 0.0), |(turned, driven), (_, _, twist, _)| {
            (turned + twist.angular.abs() * TICK, driven + twist.linear.abs() * TICK)
        })
    }

    pub fn report(&self) -> String {
        let events: Vec<_> = self
            .events
            .iter()
            .filter(|(_, event)| matches!(event, Event::Found { .. } | Event::Over(_)))
            .collect();
        format!(
            "arrived {:?}, alarm {:?}, rest {:?}, away {:.3}, turned {:?}, progress {:?}\n{events:?}",
            self.arrived,
            self.alarm(),
            self.rests_from(),
            self.away(),
            self.turned(),
            self.controller.progress(),
        )
    }
}
