//! A simulated robot: the motion model of its kind, actuator lag and dead time, slip of the floor, noise of the camera.
//!
//! Slip is a ratio error of the commanded motion, white in time. It is drawn per **cell** of 10 ms of the plant's own
//! time and held within it, so the path does not depend on how a time span is cut into calls, and two plants of one
//! seed meet the same floor in the same cell whatever is commanded.

use crate::draws::{Draws, Stream};
use crate::exchange::PoseNoise;
use crate::geometry::elementary::least;
use crate::geometry::{Pose, Twist, WheelSpeeds};
use crate::kinematics::{self, Drive, Errors, Kind, MotionModel, SkidSteer};
use arrayvec::ArrayVec;

mod lateness;
mod slip;

pub use lateness::Lateness;
pub use slip::{MAX_SLIP_SD, SLIP_PRESETS, SLIP_WINDOW, Slip, SlipChannel, SlipError};

/// Length of a cell in s: slip is constant within one, and no integration step is longer.
pub const CELL: f64 = 0.010;

/// Longest dead time in s; five times the longest measured of robots of this class.
pub const MAX_DEAD_TIME: f64 = 1.0;

/// Most commands waiting out the dead time: one per 30 ms slot for [`MAX_DEAD_TIME`], twice.
/// If more come, the last one that waits is replaced.
pub const MAX_WAITING: usize = 64;

/// A rest of a cell shorter than this, in s, is rounding and not time.
const ROUNDING: f64 = 1e-12;

/// What a simulated robot is like. [`Plant::new`] refuses what means nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantModel {
    /// Wheels, track, limits, lag and dead time as they really are.
    pub drive: Drive,
    /// The floor.
    pub slip: Slip,
    /// The camera.
    pub noise: PoseNoise,
    /// Speed in rad/s commanded of a wheel up to which its motor does not turn it; 0 where every command does.
    pub dead_band: f64,
}

/// Why a plant cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// A length or speed of the drive is not positive and finite.
    #[error("{field} is {value}, it must be positive and finite")]
    NotPositive {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// A time or standard deviation is negative or not finite.
    #[error("{field} is {value}, it must be finite and not negative")]
    Negative {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number of either sign is not finite.
    #[error("{field} is {value}, it must be finite")]
    NotFinite {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// The dead time is longer than the limit.
    #[error("a dead time of {value} s is longer than {MAX_DEAD_TIME} s")]
    DeadTime {
        /// The dead time in s.
        value: f64,
    },
    /// The start is not a finite pose.
    #[error("the start at {x}, {y} m, {heading} rad must be finite")]
    Start {
        /// World x in m.
        x: f64,
        /// World y in m.
        y: f64,
        /// Heading in rad.
        heading: f64,
    },
}

impl PlantModel {
    /// Checks every field that the plant uses; the first that means nothing is the error.
    pub fn validate(&self) -> Result<(), PlantError> {
        let Self { drive, noise, dead_band, .. } = self;
        for (field, value) in [
            ("wheel_radius", drive.wheel_radius),
            ("track_width", drive.track_width),
            ("max_wheel_speed", drive.max_wheel_speed),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PlantError::NotPositive { field, value });
            }
        }
        for (field, value) in [
            ("lag", drive.lag),
            ("dead_time", drive.dead_time),
            ("position", noise.position),
            ("heading", noise.heading),
            ("dead_band", *dead_band),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(PlantError::Negative { field, value });
            }
        }
        if let Kind::SkidSteer(SkidSteer { turn_by_speed, sideways }) = drive.kind {
            for (field, value) in [("turn_by_speed", turn_by_speed), ("sideways", sideways)] {
                if !value.is_finite() {
                    return Err(PlantError::NotFinite { field, value });
                }
            }
        }
        if drive.dead_time > MAX_DEAD_TIME {
            return Err(PlantError::DeadTime { value: drive.dead_time });
        }
        Ok(())
    }
}

/// A simulated robot with its own time, which begins at 0 and advances with [`Plant::advance`].
///
/// Its stored form is a checkpoint of ours, exact but for the last digit of a float, and is not checked when read.
///
/// ```
/// use umwelt_core::geometry::{Pose, WheelSpeeds};
/// use umwelt_core::plant::{Plant, PlantModel};
/// let mut plant = Plant::new(PlantModel::default(), Pose::default(), 1)?;
/// plant.advance(WheelSpeeds { left: 4.0, right: 4.0 }, 0.5);
/// // 4 rad/s on wheels of 0.03 m for 0.5 s
/// assert!((plant.pose().x - 0.06).abs() < 1e-12 && plant.pose().y == 0.0);
/// # Ok::<(), umwelt_core::plant::PlantError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    model: PlantModel,
    pose: Pose,
    time: f64,
    /// What the wheels really do.
    speeds: WheelSpeeds,
    /// The command that has got through the dead time.
    in_force: WheelSpeeds,
    /// The command given last.
    given: WheelSpeeds,
    /// Commands on their way through the dead time, with the time in s they come into force.
    waiting: ArrayVec<(f64, WheelSpeeds), MAX_WAITING>,
    /// The key of its floor's draws.
    floor: u64,
    /// Cells begun so far, and the rest of the current one in s.
    cells: i64,
    cell_left: f64,
    /// Ratio errors of the current cell in standard deviations: turn, drift, forward, lateral; and how many of them its
    /// motion has asked for.
    errors: [f64; 4],
    asked: usize,
    /// The key of its camera's draws, and poses observed so far.
    camera: u64,
    observed: i64,
}

impl Plant {
    /// A robot at rest at `start`.
    pub fn new(model: PlantModel, start: Pose, seed: u64) -> Result<Self, PlantError> {
        model.validate()?;
        let (x, y, heading) = (start.x, start.y, start.heading.radians());
        if !(x.is_finite() && y.is_finite() && heading.is_finite()) {
            return Err(PlantError::Start { x, y, heading });
        }
        Ok(Self {
            model,
            pose: start,
            time: 0.0,
            speeds: WheelSpeeds::ZERO,
            in_force: WheelSpeeds::ZERO,
            given: WheelSpeeds::ZERO,
            waiting: ArrayVec::new(),
            floor: Draws::key(seed, Stream::Slip),
            cells: 0,
            cell_left: 0.0,
            errors: [0.0; 4],
            asked: 0,
            camera: Draws::key(seed, Stream::Noise),
            observed: 0,
        })
    }

    /// What the robot is like.
    pub fn model(&self) -> &PlantModel {
        &self.model
    }

    /// Another floor from now on. The draws go on: the same seed gives the same floor, scaled.
    pub fn set_slip(&mut self, slip: Slip) {
        self.model.slip = slip;
    }

    /// Other wheels and limits from now on; they turn as they did. What cannot be a drive changes nothing.
    pub fn set_drive(&mut self, drive: Drive) {
        let model = PlantModel { drive, ..self.model };
        if model.validate().is_ok() {
            self.model = model;
        }
    }

    /// Seconds that the plant has advanced.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Where the robot truly is.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// How fast the wheels truly turn, in rad/s: the command after dead time and lag.
    pub fn wheel_speeds(&self) -> WheelSpeeds {
        self.speeds
    }

    /// The true pose plus measurement noise, drawn anew on each call.
    pub fn observe(&mut self) -> Pose {
        let PoseNoise { position, heading } = self.model.noise;
        let mut draws = Draws::at(self.camera, self.observed);
        self.observed += 1;
        let [x, y, turn]: [f64; 3] = std::array::from_fn(|_| draws.normal());
        Pose {
            x: self.pose.x + position * x,
            y: self.pose.y + position * y,
            heading: self.pose.heading + heading * turn,
        }
    }

    /// Gives `command` now and lets `duration` s pass.
    ///
    /// The command is limited to what the wheels can do; one that is not a number is a command to stand. A duration
    /// that is not positive and finite lets no time pass.
    pub fn advance(&mut self, command: WheelSpeeds, duration: f64) {
        self.give(command);
        if !duration.is_finite() {
            return;
        }
        let end = self.time + duration;
        let mut left = duration;
        while left > 0.0 {
            self.take_over();
            if self.cell_left <= ROUNDING {
                self.cells += 1;
                self.cell_left = CELL;
                self.asked = 0;
            }
            let mut step = least(left, self.cell_left);
            if let Some(&(from, _)) = self.waiting.first() {
                step = least(step, from - self.time);
            }
            self.step(step);
            left -= step;
        }
        if duration > 0.0 {
            // one sum per call, not per step: the plant's time is the caller's
            self.time = end;
        }
        self.take_over();
    }

    /// Puts `command` on its way to the wheels.
    fn give(&mut self, command: WheelSpeeds) {
        let limit = self.model.drive.max_wheel_speed;
        let band = self.model.dead_band;
        // What is not a number turns no wheel either.
        let turns = |speed: f64| speed.abs() > band;
        let limited = |speed: f64| if turns(speed) { speed.clamp(-limit, limit) } else { 0.0 };
        let command = WheelSpeeds { left: limited(command.left), right: limited(command.right) };
        if command == self.given {
            return;
        }
        self.given = command;
        let entry = (self.time + self.model.drive.dead_time, command);
        if let Err(full) = self.waiting.try_push(entry)
            && let Some(last) = self.waiting.last_mut()
        {
            *last = full.element();
        }
        self.take_over();
    }

    /// Brings the commands into force whose dead time is over.
    fn take_over(&mut self) {
        while let Some(&(from, command)) = self.waiting.first()
            && from <= self.time + ROUNDING
        {
            self.in_force = command;
            self.waiting.remove(0);
            if self.model.drive.lag == 0.0 {
                self.speeds = command;
            }
        }
    }

    /// Moves on by `duration` s within one cell and under one command.
    fn step(&mut self, duration: f64) {
        let drive = &self.model.drive;
        let (end, twist) = kinematics::travel(drive, self.speeds, self.in_force, duration);
        self.speeds = end;
        if twist != Twist::ZERO {
            let (length, turn) = (twist.linear * duration, twist.angular * duration);
            // A turn in place asks for its own error only.
            let asked = if length == 0.0 { 1 } else { 4 };
            if self.asked < asked {
                let mut draws = Draws::at(self.floor, self.cells);
                self.errors[..asked].fill_with(|| draws.normal());
                self.asked = asked;
            }
            let errors = ratios(&self.model.slip, self.errors);
            self.pose = drive.next(self.pose, length, turn, &errors);
        }
        self.time += duration;
        self.cell_left -= duration;
    }
}

/// The errors of a motion within a cell, on a floor with `slip`.
///
/// A ratio error is mean + sd sqrt(window/cell) z, so that over a cell of h = 10 ms the forward error is
/// l mean + N(0, sd^2 0.1 s l^2/h).
fn ratios(slip: &Slip, z: [f64; 4]) -> Errors {
    let scale = (SLIP_WINDOW / CELL).sqrt();
    let ratio = |channel: SlipChannel, z: f64| channel.mean() + channel.sd() * scale * z;
    let [around, drift, forward, lateral] = z;
    Errors {
        forward: ratio(slip.forward, forward),
        lateral: ratio(slip.lateral, lateral),
        turn: ratio(slip.turn, around),
        drift: ratio(slip.drift, drift),
    }
}

#[cfg(test)]
mod tests;
