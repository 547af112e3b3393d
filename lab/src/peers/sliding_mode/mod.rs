//! `sliding-mode`: delay and dropout as one Markov chain, a predictive sliding-mode law, zero-order hold.
//!
//! Source: Zhang, Xie, Zhang, Ren, Zhou and Wang, "Chattering-Free Sliding Mode Control for Networked Control System with
//! Time Delay and Packet Dropout Based on a New Compensation Strategy", Complexity 1016381, 2019 (doi
//! 10.1155/2019/1016381), and the same authors' predictive controller with one Markov chain and a logic zero-order hold,
//! which the thesis cites. We had their abstracts and introductions, not their derivations.
//!
//! Taken from there: one chain for delay and dropout in both directions ([`DelayChain`]); the controller cannot know what
//! becomes of the packet that it sends, so it compensates for the delay that the chain foresees; a sliding-mode law on the
//! predicted state that does not chatter; the actuator holds the last command that arrived.
//!
//! Ours:
//! - Their transition matrix is known. Ours is learned from the loop delays that the robot reports, a dropped packet being
//!   one so late that it counts as the last state.
//! - Their plants are linear. For a unicycle at speed v on a line, with cross-track error e and heading error theta, the
//!   surface is s = theta + sat(lambda e), and the reaching law s' = -eta sat(s/phi) - kappa s. Within the boundary layer
//!   phi it is linear: that is how it does not chatter. The approach angle is limited, or the controller that all share
//!   would stop and turn in place.
//! - A command begins some slots later than it is expected to arrive ([`SlidingTuning::margin`]): one that begins when it
//!   arrives in the mean comes late half of the time. Tuning asks for 12 slots: the robot then holds commands back for
//!   0.36 s, and a packet late by 0.4 s is hardly late any more. Its price is a longer prediction. With 4 slots, the spread
//!   of the ordinary delay, the median deviation over the bad link is some 17 mm instead of 10 mm.
//! - Zero-order hold is one slot per packet with the watchdog that all have: their hold has no end, but a robot that drives
//!   on for 12 s of silence is no method for use.

mod chain;

pub use chain::DelayChain;

use super::line::Line;
use super::{AsCommanded, without_identification};
use umwelt_core::controller::compensation::{Compensation, DelayModel, PathFollower, Way};
use umwelt_core::exchange::Delivery;
use umwelt_core::geometry::Twist;
use umwelt_core::geometry::elementary::sin_cos;
use umwelt_core::settings::{Attribution, Settings};
use umwelt_core::task::Limit;

/// Constants of chain and law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingTuning {
    /// Requests between the last delivery that the controller knows of and the one that it answers.
    pub ahead: usize,
    /// Slots by which a command begins later than it is expected to arrive.
    pub margin: f64,
    /// Slope lambda of the surface in rad/m: how steeply the line is approached.
    pub slope: f64,
    /// Constant part eta of the reaching law in rad/s.
    pub reaching: f64,
    /// Proportional part kappa of the reaching law in 1/s.
    pub proportional: f64,
    /// Boundary layer phi in rad, within which the constant part is proportional.
    pub layer: f64,
    /// What the robot is taken to have moved by.
    pub attribution: Attribution,
}

impl Default for SlidingTuning {
    fn default() -> Self {
        Self {
            ahead: 8,
            margin: 12.0,
            slope: 8.0,
            reaching: 0.2,
            proportional: 1.0,
            layer: 0.05,
            attribution: Attribution::Sent,
        }
    }
}

/// The part of the steepest approach that the shared controller allows before it stops to turn in place.
const STEEPEST: f64 = 0.75;

/// The delay that a chain of delays foresees.
#[derive(Clone, Debug, PartialEq)]
pub struct ForeseenDelay {
    chain: DelayChain,
    /// Requests between the last delivery that is known of and the one that is answered.
    ahead: usize,
    /// Slots by which a command begins later than it is expected to arrive.
    margin: f64,
}

impl ForeseenDelay {
    /// The chain as it is learned.
    pub fn chain(&self) -> &DelayChain {
        &self.chain
    }
}

impl DelayModel for ForeseenDelay {
    fn on_delivery(&mut self, delivery: &Delivery) {
        self.chain.learn(delivery.loop_delay);
    }

    fn loop_delay(&self, settings: &Settings) -> f64 {
        self.chain.expected(self.ahead) + self.margin * settings.slot
    }
}

/// The law: it slides onto the line of its leg and along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingMode {
    tuning: SlidingTuning,
}

impl PathFollower for SlidingMode {
    fn steer(&self, settings: &Settings, way: &Way) -> (Twist, Limit) {
        let drive = &settings.drive;
        let along = Line::of(way);
        let steepest = STEEPEST * 2.0 * settings.steering.turn_tolerance;
        let speed = reached(settings, way);
        let angular = self.tuning.law(along.cross, along.heading, speed.abs(), steepest);
        (drive.limited(Twist::new(speed, angular)), Limit::Waypoint)
    }
}

impl SlidingTuning {
    /// What it decides by; its chain knows the nominal delay and has seen nothing.
    pub fn compensation(
        &self,
        settings: &Settings,
    ) -> Compensation<AsCommanded, ForeseenDelay, SlidingMode> {
        let chain = DelayChain::new(settings.slot, settings.loop_delay);
        Compensation {
            estimator: AsCommanded,
            delay: ForeseenDelay { chain, ahead: self.ahead, margin: self.margin },
            follower: SlidingMode { tuning: *self },
        }
    }

    /// The settings of its controller.
    pub fn settings(&self, settings: &Settings) -> Settings {
        Settings { attribution: self.attribution, ..without_identification(settings) }
    }

    /// Angular velocity in rad/s at `cross` m to the left of the line, turned from it by `heading` rad, at `speed` m/s.
    ///
    /// s = theta + sat(lambda e), s' = omega + lambda e' with e' = v sin theta, so
    /// omega = -lambda v sin theta - eta sat(s/phi) - kappa s, the first term only where the surface slopes.
    fn law(&self, cross: f64, heading: f64, speed: f64, steepest: f64) -> f64 {
        let approach = self.slope * cross;
        let surface = heading + approach.clamp(-steepest, steepest);
        let slope = if approach.abs() < steepest { self.slope } else { 0.0 };
        let (sin, _) = sin_cos(heading);
        -slope * speed * sin
            - self.reaching * (surface / self.layer).clamp(-1.0, 1.0)
            - self.proportional * surface
    }
}

/// The signed speed in m/s that is reached in the next slot on the way to the speed that the way allows: a curve belongs to
/// the speed at which it is driven.
fn reached(settings: &Settings, way: &Way) -> f64 {
    let speed = way.speed(settings);
    let speed = if way.reverse { -speed } else { speed };
    settings.drive.reach(way.previous, Twist::new(speed, 0.0), way.since_change).linear
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_core::geometry::{Point, Pose};
    use umwelt_core::kinematics::integrate;

    fn way(pose: Pose, previous: Twist, reverse: bool) -> Way {
        let to = Point::new(if reverse { -2.0 } else { 2.0 }, 0.0);
        Way {
            pose,
            previous,
            from: Some(Point::new(0.0, 0.0)),
            to,
            reverse,
            stoppable: 0.13,
            slowest: 0.023,
            is_raised: false,
            since_change: 0.03,
        }
    }

    /// Drives for 14 s from `start`; poses and commands.
    fn driven(start: Pose, reverse: bool) -> Vec<(Pose, Twist)> {
        let settings = Settings::default();
        let peer = SlidingMode { tuning: SlidingTuning::default() };
        let (mut pose, mut twist, mut driven) = (start, Twist::ZERO, Vec::new());
        for _ in 0..466 {
            let (wanted, _) = peer.steer(&settings, &way(pose, twist, reverse));
            twist = settings.drive.reach(twist, wanted, settings.slot);
            pose = pose.then(integrate(twist, settings.slot));
            driven.push((pose, twist));
        }
        driven
    }

    #[test]
    fn the_law_drives_the_cross_track_error_to_zero_and_does_not_chatter() {
        for (start, reverse) in [
            (Pose::new(0.0, 0.03, 0.05), false),
            (Pose::new(0.0, -0.02, -0.15), false),
            (Pose::new(0.0, 0.03, 0.05), true),
        ] {
            let driven = driven(start, reverse);
            let (end, _) = driven[driven.len() - 1];
            assert!(end.y.abs() < 2e-4 && end.heading.radians().abs() < 2e-3, "{end:?}");
            // Chatter is a turn that changes sides again and again.
            let sides = driven.iter().filter(|it| it.1.angular.abs() > 1e-3);
            let sides: Vec<_> = sides.map(|it| it.1.angular > 0.0).collect();
            let changes = sides.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!(changes <= 3, "{changes} changes of side");
            // Nor does the error: it dies down without swinging over.
            let beyond = driven.iter().map(|it| -it.0.y * start.y.signum()).fold(0.0, f64::max);
            assert!(beyond < 0.15 * start.y.abs(), "{beyond}");
        }
    }
}
