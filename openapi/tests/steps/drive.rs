//! One robot: what comes to its controller, and where its commands have led it.

use crate::draw::{Act, Plays, Said, Seen};
use crate::judge::Judge;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use serde_json::{Value, json};
use umwelt_api::robot::MAX_INTEGER;
use umwelt_api::step::{self, Request};
use umwelt_api::task::COORDINATE;
use umwelt_core::controller::Controller;
use umwelt_core::geometry::Pose;
use umwelt_core::horizon::Horizon;
use umwelt_core::settings::Settings;
use umwelt_core::task::Task;
use umwelt_core::{exchange, kinematics};

/// Longest time in s for which the robot goes on as told: longer ones end at rest.
const GOES_ON: f64 = 0.5;

/// What a robot's agent knows.
struct Agent {
    sequence: u64,
    clock: f64,
    pose: Pose,
    /// Horizons that came, newest last.
    sent: Vec<Horizon>,
}

/// Drives `robot` through `acts`; an error where an answer is wrong.
pub fn drive(robot: &Settings, first: Task, began: f64, acts: Vec<Act>) -> TestCaseResult {
    let mut controller = Controller::new(*robot);
    controller.set_task(first);
    let mut judge = Judge::default();
    let mut agent = Agent { sequence: 0, clock: began, pose: Pose::default(), sent: Vec::new() };
    for act in acts {
        match act {
            Act::Steps(steps) => {
                for said in steps {
                    let request = agent.says(said);
                    let horizon = controller.step(&request).horizon;
                    judge.answer(&controller, &request, &horizon)?;
                    agent.hears(&controller, horizon);
                }
            }
            Act::Late(said) => {
                let (sequence, clock) = (agent.sequence, agent.clock);
                let newest = controller.newest().cloned();
                prop_assert_eq!(controller.late(&agent.says(said)), newest);
                (agent.sequence, agent.clock) = (sequence, clock);
            }
            Act::Stop => controller.stop(),
            Act::Resume => controller.resume(),
            Act::Task(task) => controller.set_task(task),
            Act::Cancel => controller.cancel_task(),
            Act::RestartClock(clock) => {
                controller.restart_clock();
                agent.restarts(clock);
                judge = Judge::default();
            }
            Act::Restore => {
                controller = judge.restored(&controller)?;
                judge = Judge::default();
            }
            // Its drive is what it was: one whose limits shrink under way would have to brake first.
            Act::Settings(settings) => {
                controller.replace_settings(Settings { drive: robot.drive, ..*settings });
            }
            Act::Forget => controller.reset_belief(),
        }
    }
    judge.restored(&controller).map(|_| ())
}

impl Agent {
    fn restarts(&mut self, clock: f64) {
        (self.sequence, self.clock) = (0, clock);
        self.sent.clear();
    }

    /// The next request, as the wire has it and as it is read.
    fn says(&mut self, said: Said) -> exchange::Request {
        let sent = (self.clock + said.pause).min(step::TIME.max);
        self.sequence = (self.sequence + said.gap).min(MAX_INTEGER);
        self.clock = sent;
        let deliveries: Vec<Value> = said
            .deliveries
            .into_iter()
            .filter_map(|(back, delay)| {
                let sequence = self.sequence.checked_sub(1)?.saturating_sub(back);
                Some(json!({"sequence": sequence, "loop_delay_s": delay}))
            })
            .collect();
        let request = json!({
            "sequence": self.sequence, "epoch": 1, "sent_s": sent,
            "observations": self.observations(sent, said.age, said.poses),
            "deliveries": deliveries, "playing": self.playing(sent, &said.plays),
            "hold": said.allows.0, "max_speed_m_per_s": said.allows.1,
        });
        let request = Request::read(request.to_string().as_bytes());
        request.unwrap().to_core()
    }

    /// Oldest first, their times strictly increasing as far as numbers of this size allow.
    fn observations(&self, sent: f64, age: f64, poses: Vec<(Seen, f64)>) -> Vec<Value> {
        let (mut taken, mut newer) = (sent - age, f64::INFINITY);
        let mut observations = Vec::new();
        for (seen, apart) in poses {
            if taken < newer && taken >= step::TIME.min {
                let (x, y, heading) = self.shown(&seen);
                observations.push(json!({
                    "x_m": x, "y_m": y, "heading_rad": heading, "taken_s": taken,
                }));
                newer = taken;
            }
            taken -= apart;
        }
        observations.reverse();
        observations
    }

    fn shown(&self, seen: &Seen) -> (f64, f64, f64) {
        match *seen {
            Seen::Anywhere(x, y, heading) => (x, y, heading),
            Seen::AsTold(x, y, heading) => {
                let place = |at: f64, off: f64| (at + off).clamp(COORDINATE.min, COORDINATE.max);
                let Pose { x: x0, y: y0, heading: h0 } = self.pose;
                (place(x0, x), place(y0, y), h0.radians() + heading)
            }
        }
    }

    fn playing(&self, sent: f64, plays: &Plays) -> Value {
        let since = |ago: f64| (sent - ago).max(step::TIME.min);
        match *plays {
            Plays::Nothing => Value::Null,
            Plays::Any(horizon, ago) => json!({"horizon": horizon, "since_s": since(ago)}),
            Plays::Sent(back, ago) => match self.sent.iter().rev().nth(back) {
                Some(horizon) => json!({"horizon": horizon.sequence, "since_s": since(ago)}),
                None => Value::Null,
            },
        }
    }

    /// Goes on as told, roughly: its poses are what the controller expects.
    fn hears(&mut self, controller: &Controller, horizon: Horizon) {
        let drive = &controller.settings().drive;
        if let (Some(before), Some(seen)) = (self.sent.last(), controller.pose()) {
            let duration = (horizon.start - before.start).clamp(0.0, GOES_ON);
            let twist = kinematics::forward(drive, before.at(before.start, drive));
            self.pose = seen.pose.then(kinematics::integrate(twist, duration));
        }
        self.sent.push(horizon);
    }
}
