//! What a robot truly is: its wheels, its floor, its camera, and the judge who watches it.
//!
//! The robot moves in real time behind a real agent: wheel speeds come as lines, poses go as lines.

use super::judge::{Blindness, Judge, Motion};
use crate::trace::Limits;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::sync::{Mutex, MutexGuard, PoisonError};
use umwelt_agent::Clock;
use umwelt_core::exchange::PoseNoise;
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::plant::{Plant, PlantModel, Slip};

/// Time in s after which a motor driver stops by itself that hears nothing.
const MOTORS_WAIT: f64 = 0.5;

/// A radian of turn counts as this many m of way.
const TURN_COUNTS: f64 = 0.05;

/// Most poses that wait for an agent; what does not fit is a frame that the tracker drops.
const WAITING: usize = 64;

/// What the tracker does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Camera {
    Sees,
    /// It repeats this pose.
    Repeats(Pose),
    Dark,
}

/// A robot. All times are those of [`Body::now`].
#[derive(Debug)]
pub struct Body {
    clock: Clock,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    plant: Plant,
    time: f64,
    told: WheelSpeeds,
    told_at: f64,
    camera: Camera,
    is_blocked: bool,
    next_frame: f64,
    frames: Option<SyncSender<String>>,
    /// Which agent is listened to; lines of one before are those of a dead one.
    agent: u64,
    limits: Limits,
    way: f64,
    judge: Judge,
}

impl Body {
    /// `robot`, at rest at the origin.
    ///
    /// # Panics
    /// Never: the plant is a good one.
    pub fn new(robot: &str, clock: Clock, seed: u64) -> Self {
        let drive = Drive::default();
        let model = PlantModel {
            drive,
            slip: Slip::HARD,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        };
        let now = clock.now();
        let state = State {
            plant: Plant::new(model, Pose::default(), seed).expect("a good plant"),
            time: now,
            told: WheelSpeeds::ZERO,
            told_at: now,
            camera: Camera::Sees,
            is_blocked: false,
            next_frame: now,
            frames: None,
            agent: 0,
            limits: Limits::new(drive),
            way: 0.0,
            judge: Judge::new(robot),
        };
        Self { clock, state: Mutex::new(state) }
    }

    /// The time in s.
    pub fn now(&self) -> f64 {
        self.clock.now()
    }

    /// Listens to a new agent: its number, and the poses that it is to be given.
    pub fn plug(&self) -> (u64, Receiver<String>) {
        let (frames, poses) = mpsc::sync_channel(WAITING);
        let mut state = self.lock();
        state.agent += 1;
        state.frames = Some(frames);
        state.limits = Limits::new(Drive::default());
        (state.agent, poses)
    }

    /// Listens to none any more; the motors stop by themselves.
    pub fn unplug(&self) {
        let mut state = self.lock();
        state.agent += 1;
        state.frames = None;
    }

    /// Agent number `agent` has written `line`.
    pub fn hear(&self, agent: u64, line: &str) {
        let mut state = self.lock();
        if agent != state.agent {
            return;
        }
        let now = self.clock.now();
        state.advance(now);
        let told = read(line).and_then(|(time, told)| {
            (state.told, state.told_at) = (told, now);
            state.limits.check(time, told)
        });
        state.judge.line(told);
    }

    /// Goes on until now; writes the frames that are due.
    pub fn tick(&self) {
        let mut state = self.lock();
        let now = self.clock.now();
        state.advance(now);
        if now >= state.next_frame {
            state.next_frame = (state.next_frame + SLOT).max(now);
            state.frame(now);
        }
    }

    /// The way that it has truly come so far in m, turns included.
    pub fn way(&self) -> f64 {
        self.lock().way
    }

    /// From now on its tracker repeats its last pose.
    pub fn freeze(&self) {
        let mut state = self.lock();
        let pose = state.plant.observe();
        state.camera = Camera::Repeats(pose);
        state.judge.goes_blind(Blindness::FrozenTracker, self.clock.now());
    }

    /// From now on its tracker shows nothing.
    pub fn darken(&self) {
        let mut state = self.lock();
        state.camera = Camera::Dark;
        state.judge.goes_blind(Blindness::NoPoses, self.clock.now());
    }

    /// From now on its wheels do not turn, whatever they are told.
    pub fn block(&self) {
        let mut state = self.lock();
        state.advance(self.clock.now());
        state.is_blocked = true;
        state.judge.goes_blind(Blindness::BlockedWheels, self.clock.now());
    }

    /// Its tracker and its wheels are as they were.
    pub fn mend(&self) {
        let mut state = self.lock();
        let now = self.clock.now();
        state.advance(now);
        (state.camera, state.is_blocked) = (Camera::Sees, false);
        for why in [Blindness::FrozenTracker, Blindness::NoPoses, Blindness::BlockedWheels] {
            state.judge.sees(why, now);
        }
    }

    /// Tells its judge something, with the time.
    pub fn judge<T>(&self, tell: impl FnOnce(&mut Judge, f64) -> T) -> T {
        let now = self.clock.now();
        tell(&mut self.lock().judge, now)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Who panicked with it has failed the run anyway.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn advance(&mut self, now: f64) {
        let end = self.told_at + MOTORS_WAIT;
        if self.time < end && end < now {
            self.go(end, self.told);
        }
        let told = if self.time < end { self.told } else { WheelSpeeds::ZERO };
        self.go(now, told);
    }

    fn go(&mut self, now: f64, told: WheelSpeeds) {
        let duration = now - self.time;
        if duration <= 0.0 {
            return;
        }
        self.plant.advance(if self.is_blocked { WheelSpeeds::ZERO } else { told }, duration);
        self.time = now;
        let turning = self.plant.wheel_speeds();
        let twist = kinematics::forward(&self.plant.model().drive, turning);
        self.way += duration * (twist.linear.abs() + TURN_COUNTS * twist.angular.abs());
        let motion =
            Motion { moves: turning != WheelSpeeds::ZERO, is_told: told != WheelSpeeds::ZERO };
        self.judge.moved(now, duration, motion);
    }

    fn frame(&mut self, now: f64) {
        let pose = match self.camera {
            Camera::Sees => self.plant.observe(),
            Camera::Repeats(pose) => pose,
            Camera::Dark => return,
        };
        let Some(frames) = &self.frames else { return };
        let Pose { x, y, heading } = pose;
        let line = json!({"t_s": now, "x_m": x, "y_m": y, "heading_rad": heading.radians()});
        // An agent that does not read has other things to do, or is dead.
        let _ = frames.try_send(line.to_string());
    }
}

/// Time and wheel speeds of a line.
fn read(line: &str) -> Result<(f64, WheelSpeeds), String> {
    let fields: BTreeMap<String, Value> =
        serde_json::from_str(line).map_err(|error| format!("{error}: {line:?}"))?;
    let number = |name: &str| {
        let value = fields.get(name).and_then(Value::as_f64).filter(|value| value.is_finite());
        value.ok_or_else(|| format!("no {name} in {line:?}"))
    };
    let speeds = WheelSpeeds { left: number("left_rad_per_s")?, right: number("right_rad_per_s")? };
    Ok((number("t_s")?, speeds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn line(time: f64, speed: f64) -> String {
        json!({"t_s": time, "left_rad_per_s": speed, "right_rad_per_s": speed}).to_string()
    }

    #[test]
    fn what_it_is_told_moves_it_and_what_is_too_fast_is_counted() {
        let body = Body::new("r1", Clock::host(), 1);
        let (agent, poses) = body.plug();
        body.hear(agent, &line(1.0, 0.7));
        std::thread::sleep(Duration::from_millis(20));
        body.hear(agent, &line(1.03, 0.7));
        assert!(body.way() > 0.7 * 0.03 * 0.02 * 0.9, "{}", body.way());
        body.hear(agent - 1, &line(1.0, 100.0));
        assert_eq!(body.judge(|judge, _| judge.counts().limits_broken), 0, "a dead agent");
        for wrong in [line(1.06, 100.0), line(1.09, -0.7), "nonsense".into(), line(0.5, 0.0)] {
            body.hear(agent, &wrong);
        }
        let counts = body.judge(|judge, _| judge.counts());
        assert_eq!((counts.lines, counts.limits_broken), (6, 4), "{:?}", counts.told);
        body.tick();
        let pose: Value = serde_json::from_str(&poses.try_recv().unwrap()).unwrap();
        assert!(pose["x_m"].as_f64().is_some() && pose["t_s"].as_f64().is_some(), "{pose}");
    }

    #[test]
    fn a_frozen_tracker_repeats_to_the_bit_with_fresh_stamps_and_a_dark_one_shows_nothing() {
        let body = Body::new("r1", Clock::host(), 1);
        let (_, poses) = body.plug();
        let see = || {
            std::thread::sleep(Duration::from_secs_f64(SLOT));
            body.tick();
            let line = poses.try_recv().ok()?;
            let mut fields: BTreeMap<String, Value> = serde_json::from_str(&line).unwrap();
            Some((fields.remove("t_s").unwrap().as_f64().unwrap(), fields))
        };
        let (one, other) = (see().unwrap(), see().unwrap());
        assert_ne!(one.1, other.1, "a camera has noise");
        body.freeze();
        let (one, other) = (see().unwrap(), see().unwrap());
        assert_eq!(one.1, other.1);
        assert!(one.0 < other.0);
        body.darken();
        assert_eq!(see(), None);
        body.mend();
        assert!(see().is_some());
    }

    #[test]
    fn motors_that_hear_nothing_stop_and_blocked_ones_do_not_turn() {
        let clock = Clock::host();
        let body = Body::new("r1", clock, 1);
        let (agent, _poses) = body.plug();
        body.hear(agent, &line(1.0, 0.7));
        body.block();
        let way = body.way();
        std::thread::sleep(Duration::from_millis(20));
        body.tick();
        assert_eq!(body.way(), way);
        body.mend();
        let mut state = body.lock();
        let now = clock.now();
        state.advance(now + 10.0);
        let most = 0.7 * 0.03 * MOTORS_WAIT;
        assert!(state.way > 0.5 * most && state.way < 1.01 * most, "{}", state.way);
    }
}
