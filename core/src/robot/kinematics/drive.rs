//! A robot's drive as it is described, and the motion model of its kind.

use super::differential::Differential;
use super::lag::follow;
use super::model::MotionModel;
use super::skid_steer::{SkidSteer, SkidSteering};
use crate::geometry::{Twist, WheelSpeeds};

/// What the wheels of a robot do on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kind {
    /// They roll.
    #[default]
    Differential,
    /// They slide sideways in turns.
    SkidSteer(SkidSteer),
}

impl Kind {
    /// Motion of the middle to the left in m per radian of turn to the left ([`MotionModel::sideways`]).
    pub fn sideways(&self) -> f64 {
        match self {
            Self::Differential => 0.0,
            Self::SkidSteer(skid) => skid.sideways,
        }
    }
}

/// A two-wheel drive. Every field is positive and finite; `lag` and `dead_time` may be zero.
///
/// Radius, track width and acceleration are not given by the thesis: the defaults are a robot of the 0.1 m class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Radius of both wheels in m.
    pub wheel_radius: f64,
    /// Distance between the wheels in m (W of thesis eq. 11).
    pub track_width: f64,
    /// By what part of their mean the right wheel is larger than the left; 0 where they are equal.
    pub unequal: f64,
    /// Largest speed of either wheel in rad/s.
    pub max_wheel_speed: f64,
    /// Largest forward or reverse speed in m/s (thesis table 1).
    pub max_linear: f64,
    /// Smallest forward or reverse speed in m/s at which the motors turn (thesis table 1).
    pub min_linear: f64,
    /// Largest angular velocity in rad/s (thesis table 1).
    pub max_angular: f64,
    /// Smallest angular velocity in rad/s of a turn in place (thesis table 1).
    pub min_angular: f64,
    /// Largest change of forward speed in m/s^2 (thesis eq. 20, a constant it does not give).
    pub max_linear_acceleration: f64,
    /// Largest change of angular velocity in rad/s^2 (thesis eq. 20 for the heading).
    pub max_angular_acceleration: f64,
    /// Time constant in s with which the wheels follow a command; 0 follows at once.
    pub lag: f64,
    /// Time in s before the wheels begin to follow a command.
    pub dead_time: f64,
    /// What its wheels do on the ground.
    pub kind: Kind,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            wheel_radius: 0.03,
            track_width: 0.10,
            unequal: 0.0,
            max_wheel_speed: 8.0,
            max_linear: 0.130,
            min_linear: 0.023,
            max_angular: 1.25,
            min_angular: 0.20,
            max_linear_acceleration: 0.3,
            max_angular_acceleration: 3.0,
            lag: 0.0,
            dead_time: 0.0,
            kind: Kind::Differential,
        }
    }
}

impl Drive {
    /// Its wheels, as if they rolled.
    pub fn wheels(&self) -> Differential {
        let Self { wheel_radius, track_width, unequal, .. } = *self;
        Differential { wheel_radius, track_width, unequal }
    }
}

/// Each by that of its kind.
impl MotionModel for Drive {
    fn forward(&self, speeds: WheelSpeeds) -> Twist {
        let wheels = self.wheels();
        match self.kind {
            Kind::Differential => wheels.forward(speeds),
            Kind::SkidSteer(skid) => SkidSteering { wheels, skid }.forward(speeds),
        }
    }

    fn inverse(&self, twist: Twist) -> WheelSpeeds {
        let wheels = self.wheels();
        match self.kind {
            Kind::Differential => wheels.inverse(twist),
            Kind::SkidSteer(skid) => SkidSteering { wheels, skid }.inverse(twist),
        }
    }

    fn sideways(&self) -> f64 {
        self.kind.sideways()
    }

    fn share(&self, twist: Twist, over: f64, fastest: f64) -> f64 {
        let wheels = self.wheels();
        match self.kind {
            Kind::Differential => wheels.share(twist, over, fastest),
            Kind::SkidSteer(skid) => SkidSteering { wheels, skid }.share(twist, over, fastest),
        }
    }

    fn faster(&self, linear: f64, turning: f64) -> f64 {
        let wheels = self.wheels();
        match self.kind {
            Kind::Differential => wheels.faster(linear, turning),
            Kind::SkidSteer(skid) => SkidSteering { wheels, skid }.faster(linear, turning),
        }
    }

    fn linear_within(&self, room: f64, turning: f64, least: f64, most: f64) -> f64 {
        let wheels = self.wheels();
        match self.kind {
            Kind::Differential => wheels.linear_within(room, turning, least, most),
            Kind::SkidSteer(skid) => {
                SkidSteering { wheels, skid }.linear_within(room, turning, least, most)
            }
        }
    }

    fn turning_within(&self, room: f64, linear: f64, least: f64) -> f64 {
        let wheels = self.wheels();
        match self.kind {
            Kind::Differential => wheels.turning_within(room, linear, least),
            Kind::SkidSteer(skid) => {
                SkidSteering { wheels, skid }.turning_within(room, linear, least)
            }
        }
    }
}

/// The twist of the turning centre where the wheels turn at `speeds` (thesis eq. 10-11, corrected), by the drive's kind.
pub fn forward(drive: &Drive, speeds: WheelSpeeds) -> Twist {
    MotionModel::forward(drive, speeds)
}

/// The wheel speeds that make the body move with `twist` (thesis eq. 19), by the drive's kind.
///
/// ```
/// use umwelt_core::{geometry::Twist, kinematics::{forward, inverse, Drive}};
/// let (drive, twist) = (Drive { unequal: 0.02, ..Drive::default() }, Twist::new(0.1, -0.7));
/// let back = forward(&drive, inverse(&drive, twist));
/// assert!((back.linear - twist.linear).abs() < 1e-15 && (back.angular - twist.angular).abs() < 1e-15);
/// ```
pub fn inverse(drive: &Drive, twist: Twist) -> WheelSpeeds {
    MotionModel::inverse(drive, twist)
}

/// How the robot gets from wheel speeds `current` toward `command` in `duration` s with its own lag: its wheel speeds at
/// the end, and its mean twist over the time.
pub fn travel(
    drive: &Drive,
    current: WheelSpeeds,
    command: WheelSpeeds,
    duration: f64,
) -> (WheelSpeeds, Twist) {
    let (end, mean) = follow(drive.lag, current, command, duration);
    (end, forward(drive, mean))
}
