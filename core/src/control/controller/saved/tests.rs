use super::*;
use crate::controller::Event;
use crate::exchange::{Observation, Request};
use crate::geometry::{Point, Pose, WheelSpeeds};
use crate::horizon::{Horizon, SLOT};
use crate::kinematics;
use crate::settings::{Method, Prior};
use crate::task::Square;
use crate::time::RobotTime;

/// Slots from a pose being taken to the request that carries it.
const SENSOR: usize = 4;

/// A robot that moves exactly as commanded, with a clock of its own.
struct Robot {
    clock: RobotTime,
    sequence: u64,
    pose: Pose,
    seen: Vec<Observation>,
    horizons: Vec<Horizon>,
}

impl Robot {
    fn new() -> Self {
        let (pose, seen, horizons) = (Pose::default(), Vec::new(), Vec::new());
        Self { clock: RobotTime::ZERO, sequence: 0, pose, seen, horizons }
    }

    /// The same robot after it has come to rest and its clock has begun anew.
    fn restarted(self) -> Self {
        Self { pose: self.pose, clock: RobotTime::new(0.5), ..Self::new() }
    }

    fn step(&mut self, controller: &mut Controller) -> Vec<Event> {
        self.seen.push(Observation { pose: self.pose, taken: self.clock });
        self.sequence += 1;
        let observations = self.seen.iter().rev().skip(SENSOR).take(1).copied().collect();
        let output = controller.step(&Request {
            sequence: self.sequence,
            connection: 0,
            sent: self.clock,
            observations,
            deliveries: Default::default(),
            playing: None,
            limits: Default::default(),
        });
        self.horizons.push(output.horizon);
        let drive = &controller.settings().drive;
        let playing = self.horizons.iter().rev().find(|horizon| horizon.start <= self.clock);
        let speeds = playing.map_or(WheelSpeeds::ZERO, |horizon| horizon.at(self.clock, drive));
        let twist = kinematics::forward(drive, speeds);
        self.pose = self.pose.then(kinematics::integrate(twist, SLOT));
        self.clock += SLOT;
        let (saved, task) = (controller.saved(), controller.task());
        assert!(saved.fits(controller.settings(), task), "{saved:?}");
        output.events.to_vec()
    }

    /// Drives until `done` and returns what happened.
    fn until(
        &mut self,
        controller: &mut Controller,
        done: impl Fn(&Controller) -> bool,
    ) -> Vec<Event> {
        let mut events = Vec::new();
        for _ in 0..10_000 {
            if done(controller) {
                return events;
            }
            events.extend(self.step(controller));
        }
        panic!("never: {:?}", controller.progress());
    }
}

fn begun() -> Controller {
    let mut controller = Controller::new(Settings::default());
    controller.set_task(Task::thesis());
    controller
}

/// The controller after a restart of the server, by way of the disk.
fn restarted(controller: &Controller) -> Controller {
    let text = serde_json::to_string(&controller.saved()).expect("storable");
    let saved = serde_json::from_str(&text).expect("readable");
    let (settings, task) = (*controller.settings(), controller.task().cloned());
    Controller::restore(settings, task, controller.is_stopped(), saved).expect("it fits")
}

fn has_arrived(controller: &Controller) -> bool {
    controller.progress().stage == Stage::Arrived
}

#[test]
fn a_task_goes_on_from_its_leg_and_the_calibration_is_not_repeated() {
    let (mut robot, mut controller) = (Robot::new(), begun());
    robot.until(&mut controller, |controller| {
        let progress = controller.progress();
        (progress.leg, progress.stage) == (2, Stage::Driving) && progress.deviation > 0.0
    });
    let before = controller.progress();
    let mut controller = restarted(&controller);
    let after = controller.progress();
    assert_eq!((after.leg, after.elapsed), (before.leg, before.elapsed));
    assert_eq!(after.max_deviation, before.max_deviation);

    let mut robot = robot.restarted();
    let begun = robot.clock;
    let events = robot.until(&mut controller, has_arrived);
    assert_eq!(events, [Event::WaypointReached { leg: 2 }, Event::Arrived]);
    let progress = controller.progress();
    let since = robot.clock - begun;
    assert!(progress.elapsed > before.elapsed, "{progress:?}");
    assert!(progress.elapsed <= before.elapsed + since, "{progress:?} after {since} s");
    assert!(robot.pose.point().distance(Point::new(-0.5, 0.0)) < 0.02, "{:?}", robot.pose);
}

#[test]
fn a_calibration_goes_on_with_the_rotation_it_was_at() {
    let calibrated = |controller: &Controller| controller.progress().stage != Stage::Calibrating;
    let turns = |robot: &Robot| robot.clock.seconds();
    let (mut robot, mut controller) = (Robot::new(), begun());
    robot.until(&mut controller, calibrated);
    let whole = turns(&robot);

    let (mut robot, mut controller) = (Robot::new(), begun());
    for _ in 0..(0.6 * whole / SLOT) as usize {
        robot.step(&mut controller);
    }
    let mut controller = restarted(&controller);
    let mut robot = robot.restarted();
    let from = robot.clock.seconds();
    robot.until(&mut controller, calibrated);
    let rest = turns(&robot) - from;
    // Once more the rotation that broke off, and waiting for the first pose.
    assert!((0.3 * whole..0.4 * whole + 2.5).contains(&rest), "{rest} s of {whole} s");
}

#[test]
fn what_was_learned_stays() {
    let (mut robot, mut controller) = (Robot::new(), begun());
    robot.until(&mut controller, |controller| controller.progress().stage == Stage::Driving);
    let restored = restarted(&controller);
    assert_eq!(restored.estimates(), controller.estimates());
    assert_ne!(restored.estimates(), Controller::new(Settings::default()).estimates());
    assert_eq!(restored.saved(), controller.saved());
}

/// Guards against: a robot with the method `adaptive` that forgets what it learned, or is not read any more, because earlier
/// versions kept one prior per channel.
#[test]
fn what_was_learned_with_one_prior_per_channel_is_read() {
    let settings = Settings { drift: true, ..Settings::default() };
    let (mut robot, mut controller) = (Robot::new(), Controller::new(settings));
    controller.set_task(begun().task().expect("a task").clone());
    robot.until(&mut controller, |controller| controller.progress().stage == Stage::Driving);
    let former = serde_json::to_string(&controller.saved()).unwrap();
    let former = former.replace("\"method\":\"bayesian\"", "\"method\":\"adaptive\"");
    let saved: Saved = serde_json::from_str(&former).unwrap();
    let settings = Settings { method: Method::Adaptive, ..settings };
    assert!(saved.fits(&settings, controller.task()));
    for (kept, learned) in saved.estimates().channels.iter().zip(controller.estimates().channels) {
        assert_eq!(kept.samples, learned.samples);
        assert!((kept.mean - learned.mean).abs() < 1e-9, "{kept:?}");
    }
    let again: Saved = serde_json::from_str(&serde_json::to_string(&saved).unwrap()).unwrap();
    assert_eq!(again, saved, "in its new form it stays what it is");
}

/// Guards against: a time of the old clock, by which the new one is judged.
#[test]
fn nothing_of_the_robots_clock_is_saved() {
    let (mut robot, mut controller) = (Robot::new(), begun());
    robot.until(&mut controller, |controller| controller.progress().stage == Stage::Driving);
    let saved = controller.saved();
    controller.restart_clock();
    assert_eq!(controller.saved(), saved);
}

#[test]
fn a_stopped_robot_stays_stopped() {
    let (mut robot, mut controller) = (Robot::new(), begun());
    controller.stop();
    let mut controller = restarted(&controller);
    for _ in 0..100 {
        robot.step(&mut controller);
    }
    assert!(controller.is_stopped());
    assert_eq!(robot.pose, Pose::default());
}

/// Guards against: an index beyond a shorter task, or a belief that grew from another prior.
#[test]
fn what_was_saved_under_other_settings_or_another_task_is_not_taken_up() {
    let (mut robot, mut controller) = (Robot::new(), begun());
    robot.until(&mut controller, |controller| controller.progress().leg == 2);
    let (settings, task) = (Settings::default(), Task::thesis());
    let restore = |settings: Settings, task: Option<&Task>| {
        Controller::restore(settings, task.cloned(), false, controller.saved()).is_some()
    };
    assert!(restore(settings, Some(&task)));
    assert!(restore(Settings { slots: 3, ..settings }, Some(&task)), "it does not matter here");

    assert!(!restore(Settings { method: Method::Statistic, ..settings }, Some(&task)));
    let prior =
        Prior { turn: settings.prior.forward, forward: settings.prior.lateral, ..settings.prior };
    assert!(!restore(Settings { prior, ..settings }, Some(&task)));
    assert!(!restore(Settings { drift: true, ..settings }, Some(&task)));
    assert!(!restore(settings, None));
    let shorter = Task { waypoints: task.waypoints[..1].to_vec(), ..task };
    assert!(!restore(settings, Some(&shorter)));

    let calibrating = begun().saved();
    let without = Task { calibration: None, ..Task::thesis() };
    assert!(!calibrating.fits(&settings, Some(&without)));
    let idle = Controller::new(settings).saved();
    assert!(idle.fits(&settings, None) && !idle.fits(&settings, Some(&Task::thesis())));
}

/// A check begins anew after a restart, wherever it was; nothing of it is another task's.
#[test]
fn a_check_begins_anew() {
    let (settings, check) = (Settings::default(), Task::checking(Default::default()));
    let mut controller = Controller::new(settings);
    controller.set_task(check.clone());
    let mut robot = Robot::new();
    for _ in 0..200 {
        robot.step(&mut controller);
    }
    assert!(robot.pose.heading.radians().abs() > 0.1, "it wiggles");
    let json = serde_json::to_string(&controller.saved()).unwrap();
    let saved: Saved = serde_json::from_str(&json).unwrap();
    assert!(!saved.fits(&settings, Some(&Task::thesis())) && !saved.fits(&settings, None));
    assert!(!begun().saved().fits(&settings, Some(&check)));
    let mut restored = Controller::restore(settings, Some(check), false, saved).unwrap();
    let mut robot = robot.restarted();
    let events = robot.until(&mut restored, |controller| controller.has_arrived());
    assert_eq!(events, [Event::Arrived]);
    assert!(restored.report().is_some_and(|report| report.numbers.span > 20.0));
}

/// A square begins anew after a restart, with its first run; nothing of it is another task's.
#[test]
fn a_square_begins_anew() {
    let (settings, square) = (Settings::default(), Square { side: Some(0.2), ..Square::default() });
    let square = Task::squaring(square);
    let mut controller = Controller::new(settings);
    controller.set_task(square.clone());
    let mut robot = Robot::new();
    robot.until(&mut controller, |controller| controller.progress().leg == 1);
    let saved: Saved =
        serde_json::from_str(&serde_json::to_string(&controller.saved()).unwrap()).unwrap();
    assert!(!saved.fits(&settings, Some(&Task::thesis())) && !saved.fits(&settings, None));
    assert!(!saved.fits(&settings, Some(&Task::checking(Default::default()))));
    assert!(!begun().saved().fits(&settings, Some(&square)));
    let mut restored = Controller::restore(settings, Some(square), false, saved).unwrap();
    assert_eq!((restored.progress().leg, restored.progress().legs), (0, 2));
    let mut robot = robot.restarted();
    let events = robot.until(&mut restored, |controller| controller.has_arrived());
    assert_eq!(events, [Event::Arrived]);
    assert!(restored.square_report().is_some_and(|report| report.returns.len() == 2));
}
