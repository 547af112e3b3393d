//! Whether the robot gets nearer to where it is to go.

use crate::time::RobotTime;

/// Nearer by this part of the tolerance is nearer.
const NEARER: f64 = 0.2;

/// Turned toward the waypoint by this many rad is nearer, too: half the turn tolerance.
const TURNED: f64 = 0.05;

/// Noise of a pose that is no advance, in standard deviations.
const ABOVE_NOISE: f64 = 3.0;

/// Where the robot is to go, seen from where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Which waypoint.
    pub leg: usize,
    /// Distance in m.
    pub distance: f64,
    /// Heading error in rad.
    pub heading: f64,
    /// Distance in m at which it is there.
    pub tolerance: f64,
}

/// The best so far on the way to one waypoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advance {
    leg: usize,
    distance: f64,
    heading: f64,
    /// Since when it is no better; none before the first pose.
    since: Option<RobotTime>,
}

impl Advance {
    /// Takes in where the robot is `now`; returns for how many s it has not got nearer. Turning toward the
    /// waypoint counts once: a robot that circles turns past it again and again.
    pub fn push(&mut self, goal: Goal, noise: f64, now: RobotTime) -> f64 {
        let nearer = (NEARER * goal.tolerance).max(ABOVE_NOISE * noise);
        if self.since.is_none() || self.leg != goal.leg || goal.distance <= self.distance - nearer {
            let Goal { leg, distance, heading, .. } = goal;
            *self = Self { leg, distance, heading, since: Some(now) };
        } else if goal.heading <= self.heading - TURNED {
            self.heading = goal.heading;
            self.since = Some(now);
        }
        self.since.map_or(0.0, |since| now - since)
    }

    /// The robot is not to move now: time does not count.
    pub fn pause(&mut self) {
        self.since = None;
    }
}
