//! A robot that drives a square in simulated time, on a floor that makes its wheels and track other than described.

use crate::actuation::Actuation;
use crate::controller::Controller;
use crate::exchange::{Exchange, Observation, PoseNoise, Request};
use crate::geometry::{Pose, WheelSpeeds};
use crate::horizon::Horizon;
use crate::kinematics::Drive;
use crate::plant::{Plant, PlantModel, Slip, SlipChannel};
use crate::settings::Settings;
use crate::square::Report;
use crate::task::{Square, Stage, Task};
use crate::time::RobotTime;
use std::collections::VecDeque;
use std::sync::Arc;

/// Steps of the simulation in s.
const TICK: f64 = 0.01;

/// Robot time at which a run begins.
const START: f64 = 50.0;

/// What its controller is told.
pub type Order = fn(&mut Controller);

pub struct Robot {
    pub settings: Settings,
    pub square: Square,
    pub plant: PlantModel,
    /// Poses a second.
    pub rate: f64,
    /// Time in s of a request and of its reply.
    pub delays: (f64, f64),
    pub seed: u64,
    /// Orders at times.
    pub orders: Vec<(f64, Order)>,
    /// The part of the commanded wheel speeds that is made, at a time.
    pub wheels: fn(f64, WheelSpeeds) -> WheelSpeeds,
}

pub struct Run {
    pub controller: Controller,
    pub report: Option<Arc<Report>>,
    /// When it ended.
    pub ended: Option<f64>,
    /// Farthest from the start in m.
    pub away: f64,
}

/// The hard floor as its random part has it.
pub fn floor(forward: f64, turn: f64, drift: f64) -> Slip {
    let with = |mean: f64, channel: SlipChannel| SlipChannel::new(mean, channel.sd()).unwrap();
    Slip {
        forward: with(forward, Slip::HARD.forward),
        turn: with(turn, Slip::HARD.turn),
        drift: with(drift, Slip::HARD.drift),
        ..Slip::HARD
    }
}

impl Robot {
    /// A robot under a camera of 30 Hz.
    pub fn new(drive: Drive, slip: Slip) -> Self {
        let noise = PoseNoise::CAMERA;
        Self {
            settings: Settings { drive, noise, ..Settings::default() },
            square: Square::default(),
            plant: PlantModel { drive, slip, noise, ..PlantModel::default() },
            rate: 30.0,
            delays: (0.02, 0.02),
            seed: 1,
            orders: Vec::new(),
            wheels: |_, speeds| speeds,
        }
    }

    pub fn run(mut self) -> Run {
        let mut controller = Controller::new(self.settings);
        controller.set_task(Task::squaring(self.square));
        let start = Pose::new(1.3, -0.7, 0.6);
        let mut plant = Plant::new(self.plant, start, self.seed).unwrap();
        let begin = RobotTime::new(START);
        let mut exchange = Exchange::new(begin);
        let mut actuation = Actuation::new(self.settings.drive, begin);
        let mut up: VecDeque<(f64, Request)> = VecDeque::new();
        let mut down: VecDeque<(f64, Horizon)> = VecDeque::new();
        let (mut frames, mut away, mut ended) = (0_u64, 0.0_f64, None);
        for tick in 0..(900.0 / TICK) as u64 {
            let t = tick as f64 * TICK;
            let now = RobotTime::new(START + t);
            if t >= frames as f64 / self.rate - 1e-9 {
                frames += 1;
                exchange.observe(Observation { pose: plant.observe(), taken: now });
            }
            while down.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                let (_, horizon) = down.pop_front().unwrap();
                exchange.reply(now, horizon.answers);
                actuation.accept(&horizon);
            }
            if let Some(request) = exchange.request(now, actuation.playing()) {
                up.push_back((t + self.delays.0, request));
            }
            if let Some((_, order)) = self.orders.first().filter(|(at, _)| t >= *at) {
                order(&mut controller);
                self.orders.remove(0);
            }
            while up.front().is_some_and(|(due, _)| *due <= t + 1e-9) {
                let (_, request) = up.pop_front().unwrap();
                let output = controller.step(&request);
                down.push_back((t + self.delays.1, output.horizon));
            }
            plant.advance((self.wheels)(t, actuation.advance(now)), TICK);
            away = away.max(plant.pose().point().distance(start.point()));
            if ended.is_none() && controller.progress().stage == Stage::Arrived {
                ended = Some(t);
                break;
            }
        }
        let report = controller.square_report().cloned();
        Run { controller, report, ended, away }
    }
}
