use crate::actuation::Actuation;
use crate::controller::Controller;
use crate::exchange::{Exchange, Observation, PoseNoise, Request};
use crate::geometry::{Point, Pose, Twist, WheelSpeeds};
use crate::horizon::{Horizon, RAMP_STEP, SLOT};
use crate::kinematics::Drive;
use crate::local::LocalLimits;
use crate::plant::{Plant, PlantModel, Slip};
use crate::settings::{Attribution, Method, Settings};
use crate::task::{Stage, Task};
use crate::time::RobotTime;
use std::collections::VecDeque;

/// Delays in s of the camera, and of the link each way.
const SEEN_AFTER: f64 = 0.12;
const CARRIED: f64 = 0.03;

const HOLD: LocalLimits = LocalLimits { hold: true, max_speed: None };

/// A robot on a perfect floor under a perfect camera, its link, and its controller, in steps of 10 ms.
struct Closed {
    controller: Controller,
    exchange: Exchange,
    actuation: Actuation,
    plant: Plant,
    applied: WheelSpeeds,
    tick: u64,
    seen: VecDeque<(f64, Observation)>,
    upward: VecDeque<(f64, Request)>,
    downward: VecDeque<(f64, Horizon)>,
    is_cut: bool,
}

fn due<T>(queue: &mut VecDeque<(f64, T)>, now: f64) -> Option<T> {
    let is_due = queue.front().is_some_and(|(at, _)| *at <= now + 1e-9);
    if is_due { queue.pop_front().map(|(_, what)| what) } else { None }
}

impl Closed {
    fn new(attribution: Attribution) -> Self {
        let drive = Drive::default();
        let settings =
            Settings { drive, attribution, method: Method::Statistic, ..Settings::default() };
        let mut controller = Controller::new(settings);
        controller.set_task(Task { calibration: None, ..Task::thesis() });
        let model =
            PlantModel { drive, slip: Slip::NONE, noise: PoseNoise::NONE, ..PlantModel::default() };
        Self {
            controller,
            exchange: Exchange::new(RobotTime::ZERO),
            actuation: Actuation::new(drive, RobotTime::ZERO),
            plant: Plant::new(model, Pose::default(), 1).expect("a plant"),
            applied: WheelSpeeds::ZERO,
            tick: 0,
            seen: VecDeque::new(),
            upward: VecDeque::new(),
            downward: VecDeque::new(),
            is_cut: false,
        }
    }

    fn now(&self) -> f64 {
        self.tick as f64 * RAMP_STEP
    }

    fn restrain(&mut self, limits: LocalLimits) {
        self.actuation.restrain(limits, self.exchange.newest_sequence());
        self.exchange.restrain(limits);
    }

    /// The next 10 ms.
    fn step(&mut self) {
        self.tick += 1;
        let now = self.now();
        self.plant.advance(self.applied, now - self.plant.time());
        if self.tick.is_multiple_of(3) {
            let observation =
                Observation { pose: self.plant.observe(), taken: RobotTime::new(now) };
            self.seen.push_back((now + SEEN_AFTER, observation));
        }
        while let Some(observation) = due(&mut self.seen, now) {
            self.exchange.observe(observation);
        }
        while let Some(request) = due(&mut self.upward, now) {
            let horizon = self.controller.step(&request).horizon;
            self.downward.push_back((now + CARRIED, horizon));
        }
        while let Some(horizon) = due(&mut self.downward, now) {
            self.exchange.reply(RobotTime::new(now), horizon.answers);
            self.actuation.accept(&horizon);
        }
        self.applied = self.actuation.advance(RobotTime::new(now));
        if let Some(request) = self.exchange.request(RobotTime::new(now), self.actuation.playing())
        {
            self.upward.push_back((now + CARRIED, request));
        }
        if self.is_cut {
            self.upward.clear();
            self.downward.clear();
        }
    }

    fn twist(&self) -> Twist {
        self.actuation.output()
    }

    /// Goes on for `seconds`, or less where `done`.
    fn run(&mut self, seconds: f64, done: impl Fn(&Self) -> bool) {
        let until = self.now() + seconds;
        while self.now() < until - 1e-9 && !done(self) {
            self.step();
        }
    }

    fn speed_up(&mut self) {
        self.run(20.0, |it| it.twist().linear > 0.129);
        assert!(self.twist().linear > 0.129, "{:?}", self.controller.progress());
    }

    fn arrive(&mut self) {
        self.run(90.0, |it| it.controller.progress().stage == Stage::Arrived);
        assert_eq!(self.controller.progress().stage, Stage::Arrived, "{:?}", self.plant.pose());
    }

    /// On a perfect floor every motion is as commanded: what is learned from anything else shows.
    fn assert_nothing_false_was_learned(&self, what: &str) {
        for channel in self.controller.estimates().channels {
            assert!(channel.mean.abs() < 0.02, "{what}: {channel:?}");
        }
        assert!(self.controller.estimates().channels[0].samples > 10, "{what}");
    }
}

/// Held at full speed, as sent and as played: at rest after the ramp, shown within the time that the link takes.
#[test]
fn a_robot_that_holds_rests_at_once_and_shows_it() {
    for attribution in [Attribution::Sent, Attribution::Played] {
        let mut closed = Closed::new(attribution);
        closed.speed_up();
        let drive = Drive::default();
        let stopping = drive.stopping_time(closed.twist());
        closed.restrain(HOLD);
        closed.run(1.5 * SLOT + CARRIED + RAMP_STEP, |_| false);
        assert!(closed.controller.is_held());
        closed.run(stopping + SLOT - (1.5 * SLOT + CARRIED + RAMP_STEP), |_| false);
        assert_eq!(closed.twist(), Twist::ZERO);
        let (pose, learned) = (closed.plant.pose(), closed.controller.estimates().channels);
        closed.run(5.0, |it| it.twist() != Twist::ZERO);
        assert_eq!((closed.twist(), closed.plant.pose()), (Twist::ZERO, pose));
        assert_eq!(closed.controller.estimates().channels, learned);
        closed.restrain(LocalLimits::NONE);
        closed.run(0.5, |it| !it.controller.is_held());
        assert!(!closed.controller.is_held());
        closed.arrive();
        let progress = closed.controller.progress();
        assert!(progress.max_deviation < 0.01, "{progress:?}");
        closed.assert_nothing_false_was_learned("one hold");
    }
}

/// However short or long, in whatever phase, with and without a link: it goes on by itself and learns nothing false.
#[test]
fn however_often_it_holds_it_arrives_and_learns_nothing_false() {
    for attribution in [Attribution::Sent, Attribution::Played] {
        for is_cut in [false, true] {
            let mut closed = Closed::new(attribution);
            closed.run(1.0, |_| false);
            for (drive_for, hold_for) in [
                (0.61, 0.01),
                (1.3, 0.05),
                (0.9, 0.13),
                (1.7, 0.25),
                (1.1, 0.4),
                (2.03, 0.9),
                (1.4, 2.2),
            ] {
                closed.run(drive_for, |_| false);
                closed.restrain(HOLD);
                closed.is_cut = is_cut;
                closed.run(hold_for, |_| false);
                closed.restrain(LocalLimits::NONE);
                // Nothing planned before it was let go moves the robot.
                if is_cut {
                    closed.run(0.4, |_| false);
                    closed.run(0.3, |it| it.twist() != Twist::ZERO);
                    assert_eq!(closed.twist(), Twist::ZERO, "{hold_for} s");
                }
                closed.is_cut = false;
            }
            closed.arrive();
            let progress = closed.controller.progress();
            assert!(progress.max_deviation < 0.02, "{progress:?}");
            closed.assert_nothing_false_was_learned(&format!("{attribution:?}, cut: {is_cut}"));
        }
    }
}

#[test]
fn a_slower_speed_is_kept_planned_with_and_teaches_nothing_false() {
    for attribution in [Attribution::Sent, Attribution::Played] {
        let mut closed = Closed::new(attribution);
        let far = vec![Point::new(1.5, 0.0)];
        closed.controller.set_task(Task { waypoints: far, calibration: None, ..Task::thesis() });
        for _ in 0..3 {
            closed.speed_up();
            closed.restrain(LocalLimits { hold: false, max_speed: Some(0.05) });
            closed.run(0.08 / 0.3 + SLOT, |_| false);
            closed.run(1.5, |it| it.twist().linear > 0.05 + 1e-9);
            assert!(closed.twist().linear <= 0.05 + 1e-9, "{:?}", closed.twist());
            assert!(closed.twist().linear > 0.04, "it goes on: {:?}", closed.twist());
            let planned = closed.controller.newest().expect("sent").speeds[5];
            let drive = Drive::default();
            assert!(crate::kinematics::forward(&drive, planned).linear <= 0.05 + 1e-9);
            closed.restrain(LocalLimits::NONE);
        }
        closed.arrive();
        assert!(closed.controller.progress().max_deviation < 0.01);
        closed.assert_nothing_false_was_learned(&format!("{attribution:?}"));
    }
}

/// A server that was restarted hears of a hold with the first request, and keeps it.
#[test]
fn a_controller_that_begins_anew_keeps_a_hold() {
    let mut closed = Closed::new(Attribution::Sent);
    closed.speed_up();
    closed.restrain(HOLD);
    closed.run(1.0, |_| false);
    let (settings, task) = (*closed.controller.settings(), closed.controller.task().cloned());
    let saved = closed.controller.saved();
    closed.controller = Controller::restore(settings, task, false, saved).expect("its own");
    closed.run(3.0, |it| it.twist() != Twist::ZERO);
    assert!(closed.controller.is_held() && closed.twist() == Twist::ZERO);
    closed.restrain(LocalLimits::NONE);
    closed.arrive();
}
