//! The smallest speeds, raised stepwise where the robot does not move at them: motors with a dead band, wheels that spin
//! at creeping speed and would climb at full.

use super::evidence::Kind;
use crate::geometry::Twist;
use crate::kinematics::Drive;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};

/// Longest time in s for which speeds are raised before the robot counts as stuck.
pub const RAISED_FOR: f64 = 20.0;

/// By how much a speed is raised in one step. From the slowest speed of any robot here to its fastest, 1:40, it takes nine
/// steps of about a second.
const STEP: f64 = 1.5;

/// One of the two smallest speeds, in m/s or rad/s; zero where nothing was raised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// Slower is not commanded.
    pub least: f64,
    /// Up to this speed the robot was seen to stand.
    pub dead: f64,
}

/// What was learned of the smallest speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Floors {
    /// Driving.
    pub drive: Floor,
    /// Turning in place.
    pub turn: Floor,
}

impl Floors {
    /// Whether nothing was raised.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The drive with its smallest speeds raised.
    pub fn raised(&self, drive: &Drive) -> Drive {
        Drive {
            min_linear: drive.min_linear.max(self.drive.least).min(drive.max_linear),
            min_angular: drive.min_angular.max(self.turn.least).min(drive.max_angular),
            ..*drive
        }
    }

    /// What the wheels make of `twist`: nothing up to the speeds at which the robot was seen to stand.
    pub fn moving(&self, twist: Twist) -> Twist {
        if twist.linear.abs() <= self.drive.dead && twist.angular.abs() <= self.turn.dead {
            return Twist::ZERO;
        }
        let stands = twist.linear != 0.0 && twist.linear.abs() <= self.drive.dead;
        if stands { Twist::new(0.0, twist.angular) } else { twist }
    }

    /// How far the robot still moves in m and rad while it ramps down from `twist`, where speeds were raised: above the
    /// speeds at which it stands.
    pub fn overrun(&self, drive: &Drive, twist: Twist) -> (f64, f64) {
        let over = |floor: Floor, speed: f64, acceleration: f64| {
            let above = speed * speed - floor.dead * floor.dead;
            if floor.least > 0.0 { above.max(0.0) / (2.0 * acceleration) } else { 0.0 }
        };
        (
            over(self.drive, twist.linear, drive.max_linear_acceleration),
            over(self.turn, twist.angular, drive.max_angular_acceleration),
        )
    }

    fn of(&mut self, kind: Kind) -> &mut Floor {
        match kind {
            Kind::Drive => &mut self.drive,
            Kind::Turn => &mut self.turn,
        }
    }
}

/// A raise under way, and what it has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Raise {
    /// The smallest speeds.
    pub floors: Floors,
    /// Since when each of them is raised; none where it is not.
    since: [Option<RobotTime>; 2],
    /// As they were before.
    before: Floors,
}

impl Raise {
    /// With floors learned before.
    pub fn learned(floors: Floors) -> Self {
        Self { floors, ..Self::default() }
    }

    /// Raises the speed of `kind` above `peak`, at which the robot stood (or, where `crept`, hardly moved), at most to
    /// `fastest`: by a step, or to the top `at_once`. Returns the new one.
    pub fn step(&mut self, kind: Kind, now: RobotTime, peak: f64, fastest: f64, how: How) -> f64 {
        if self.since == [None; 2] {
            self.before = self.floors;
        }
        self.since[kind as usize].get_or_insert(now);
        let floor = self.floors.of(kind);
        if how != How::Crept {
            floor.dead = floor.dead.max(peak);
        }
        let next = if how == How::AtOnce { fastest } else { STEP * peak.max(floor.least) };
        floor.least = next.min(fastest);
        floor.least
    }

    /// Whether the speed of `kind` has been raised for too long.
    pub fn is_over(&self, kind: Kind, now: RobotTime) -> bool {
        self.since[kind as usize].is_some_and(|since| now - since > RAISED_FOR)
    }

    /// The robot moves.
    pub fn succeeded(&mut self) {
        self.since = [None; 2];
    }

    /// It was no matter of speed: back to what was before.
    pub fn failed(&mut self) {
        if self.since != [None; 2] {
            (self.floors, self.since) = (self.before, [None; 2]);
        }
    }
}

/// Why and how a speed is raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// The robot stood.
    Stood,
    /// It hardly moved: nothing is known of a dead band.
    Crept,
    /// It stood, and there is no time for steps.
    AtOnce,
}
