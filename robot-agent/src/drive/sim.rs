//! A simulated robot in real time: the plant of `umwelt_core`, advanced as the clock goes.

use super::{Drive, DriveError};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use tokio::sync::watch;
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics;
use umwelt_core::link::SENSOR_DELAY;
use umwelt_core::local::LocalLimits;
use umwelt_core::plant::{Plant, PlantError, PlantModel};
use umwelt_core::time::RobotTime;

/// A simulated robot under a camera that takes a frame per slot and tells its pose a sensor delay later.
#[derive(Clone, Debug)]
pub struct Sim {
    plant: Plant,
    sensor_delay: f64,
    began: f64,
    frames: u64,
    /// Robot time in s up to which time has passed.
    now: f64,
    applied: WheelSpeeds,
    /// Poses on their way from the camera: (arrival, pose).
    seen: VecDeque<(f64, Observation)>,
    /// Whether it is as the server describes it.
    is_as_described: bool,
    /// What its wheels do whatever the server says; none where they do what that describes.
    kind: Option<kinematics::Kind>,
    /// Its bumper and buttons.
    limits: Option<watch::Receiver<LocalLimits>>,
}

impl Sim {
    /// A robot at rest at `start`, with the thesis's sensor delay.
    ///
    /// # Errors
    /// Where model or start mean nothing.
    pub fn new(model: PlantModel, start: Pose, seed: u64) -> Result<Self, PlantError> {
        Ok(Self {
            plant: Plant::new(model, start, seed)?,
            sensor_delay: SENSOR_DELAY,
            began: 0.0,
            frames: 0,
            now: 0.0,
            applied: WheelSpeeds::ZERO,
            seen: VecDeque::new(),
            is_as_described: false,
            kind: None,
            limits: None,
        })
    }

    /// The same with the wheels and limits that the server has for it; its lag stays its own.
    pub fn as_described(self) -> Self {
        Self { is_as_described: true, ..self }
    }

    /// What it really is.
    pub fn model(&self) -> &PlantModel {
        self.plant.model()
    }

    /// The same whose wheels do this on the ground, whatever the server says.
    pub fn with_kind(self, kind: Option<kinematics::Kind>) -> Self {
        Self { kind, ..self }
    }

    /// The same with another time in s from a pose being taken to its being known.
    pub fn with_sensor_delay(self, sensor_delay: f64) -> Self {
        Self { sensor_delay, ..self }
    }

    /// The same with a bumper and buttons: what the robot itself allows, at each moment.
    pub fn with_limits(self, limits: watch::Receiver<LocalLimits>) -> Self {
        Self { limits: Some(limits), ..self }
    }

    fn next_frame(&self) -> f64 {
        self.began + self.frames as f64 * SLOT
    }

    /// Lets time pass up to `to`.
    fn pass(&mut self, to: f64) {
        self.plant.advance(self.applied, to - self.now);
        self.now = to;
    }
}

impl Drive for Sim {
    /// What the robot itself allows has changed.
    type Input = ();

    const IS_HARDWARE: bool = false;

    fn describe(&mut self, drive: &kinematics::Drive) {
        if self.is_as_described {
            let own = self.plant.model().drive;
            self.plant.set_drive(kinematics::Drive {
                lag: own.lag,
                dead_time: own.dead_time,
                kind: self.kind.unwrap_or(drive.kind),
                ..*drive
            });
        }
    }

    fn begin(&mut self, now: f64) {
        (self.began, self.now) = (now, now);
    }

    fn next(&self) -> f64 {
        self.seen.front().map_or(f64::INFINITY, |(arrival, _)| *arrival).min(self.next_frame())
    }

    async fn input(&mut self) {
        if let Some(limits) = &mut self.limits
            && limits.changed().await.is_ok()
        {
            return;
        }
        // Where no one can change it any more, it stays as it is.
        std::future::pending().await
    }

    fn take(&mut self, _: f64, (): ()) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn limits(&self) -> LocalLimits {
        self.limits.as_ref().map_or(LocalLimits::NONE, |limits| *limits.borrow())
    }

    fn observe(&mut self, now: f64) -> Option<Observation> {
        while self.next_frame() <= now {
            let taken = self.next_frame();
            self.pass(taken);
            self.frames += 1;
            let observation =
                Observation { pose: self.plant.observe(), taken: RobotTime::new(taken) };
            self.seen.push_back((taken + self.sensor_delay, observation));
        }
        self.pass(now);
        let arrived = self.seen.front().is_some_and(|(arrival, _)| *arrival <= now);
        if arrived { self.seen.pop_front().map(|(_, observation)| observation) } else { None }
    }

    fn apply(&mut self, _: f64, speeds: WheelSpeeds) -> Result<(), DriveError> {
        self.applied = speeds;
        Ok(())
    }

    fn true_pose(&self) -> Option<Pose> {
        Some(self.plant.pose())
    }

    async fn finish(&mut self, _: f64) -> Result<(), DriveError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_per_slot_becomes_known_a_sensor_delay_later() {
        let mut sim = Sim::new(PlantModel::default(), Pose::default(), 1).unwrap();
        sim.begin(5.0);
        let mut known = Vec::new();
        let mut now = 5.0;
        while now < 6.0 {
            while let Some(observation) = sim.observe(now) {
                known.push((now, observation.taken));
            }
            sim.apply(now, WheelSpeeds { left: 2.0, right: 2.0 }).unwrap();
            now = sim.next();
        }
        // 1 s less the sensor delay, in slots
        assert_eq!(known.len(), ((1.0 - SENSOR_DELAY) / SLOT).ceil() as usize);
        assert!(known.iter().all(|(at, taken)| (at - taken.seconds() - SENSOR_DELAY).abs() < 1e-9));
        assert!((sim.true_pose().unwrap().x - 0.06 * (sim.now - 5.0)).abs() < 1e-9);
    }

    #[test]
    fn a_late_wake_takes_the_frames_when_they_were_due() {
        let mut sim = Sim::new(PlantModel::default(), Pose::default(), 1).unwrap();
        sim.begin(0.0);
        sim.observe(0.0);
        sim.apply(0.0, WheelSpeeds { left: 2.0, right: 2.0 }).unwrap();
        let mut poses = Vec::new();
        while let Some(observation) = sim.observe(1.0) {
            poses.push(observation);
        }
        for Observation { pose, taken } in poses {
            assert!((pose.x - 0.06 * taken.seconds()).abs() < 1e-9);
        }
    }
}
