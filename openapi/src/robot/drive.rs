//! The drive of a robot, and how well it is seen.

use super::choice::Kind;
use crate::check::{Check, Range, Validate};
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// From the wheels of a toy to those of a tractor.
pub const WHEEL_RADIUS: Range = Range::new(0.001, 2.0, "m");
/// From a coin to a tractor.
pub const TRACK_WIDTH: Range = Range::new(0.005, 10.0, "m");
/// Up to 9500 revolutions per minute; a wheel that does not turn is no drive.
pub const WHEEL_SPEED: Range = Range::new(0.01, 1000.0, "rad/s");
/// Up to 36 km/h, beyond which no one steers by a bad link.
pub const LINEAR_SPEED: Range = Range::new(1e-4, 10.0, "m/s");
/// Up to 16 turns per second.
pub const ANGULAR_SPEED: Range = Range::new(1e-3, 100.0, "rad/s");
/// Up to 10 g; a drive that cannot accelerate cannot stop.
pub const LINEAR_ACCELERATION: Range = Range::new(1e-3, 100.0, "m/s^2");
/// As for the speed, reached in 0.1 s.
pub const ANGULAR_ACCELERATION: Range = Range::new(1e-2, 1000.0, "rad/s^2");
/// Slower wheels would still follow the last command when the longest horizon is over.
pub const LAG: Range = Range::new(0.0, 2.0, "s");
/// From a robot that turns about its bumper to one that turns about its tail: those of tractors.
pub const SIDEWAYS: Range = Range::new(-5.0, 5.0, "m/rad");
/// Half of the turn more or less at 0.01 m/s: more than any robot has between its speeds.
pub const TURN_BY_SPEED: Range = Range::new(-50.0, 50.0, "s/m");
/// Most by which the turn ratio changes up to the speed of the fastest wheels, as a part of that at standstill.
pub const TURN_CHANGE: f64 = 0.5;
/// Noise of a metre leaves nothing to control by.
pub const POSITION_NOISE: Range = Range::new(0.0, 1.0, "m");
/// Noise of a radian leaves nothing to steer by.
pub const HEADING_NOISE: Range = Range::new(0.0, 1.0, "rad");

/// A drive of two wheels, or of wheels or tracks on two sides. What is left out is that of a robot of the 0.1 m class.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = Drive)]
pub struct Drive {
    /// Radius of both wheels.
    pub wheel_radius_m: f64,
    /// Distance between the wheels.
    pub track_width_m: f64,
    /// Largest speed of either wheel.
    pub max_wheel_speed_rad_per_s: f64,
    /// Largest forward or reverse speed.
    pub max_linear_m_per_s: f64,
    /// Smallest forward or reverse speed at which the motors turn.
    pub min_linear_m_per_s: f64,
    /// Largest angular velocity.
    pub max_angular_rad_per_s: f64,
    /// Smallest angular velocity of a turn in place.
    pub min_angular_rad_per_s: f64,
    /// Largest change of forward speed.
    pub max_linear_acceleration_m_per_s2: f64,
    /// Largest change of angular velocity.
    pub max_angular_acceleration_rad_per_s2: f64,
    /// Time constant with which the wheels follow a command; 0 follows at once. Of a robot of which neither this nor
    /// `dead_time_s` is said both are identified.
    pub lag_s: f64,
    /// Time before the wheels begin to follow a command.
    pub dead_time_s: f64,
    /// What the wheels do on the ground.
    pub kind: Kind,
    /// Of skid steer: by what part the turn of the same difference of the wheels grows per m/s of speed; `track_width_m` is
    /// that with which it turns at standstill.
    pub turn_by_speed_s_per_m: f64,
    /// Of skid steer: how far the tracked point moves to the left per radian of turn to the left, which is how far it lies
    /// ahead of the point about which the robot turns in place.
    pub sideways_m_per_rad: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            wheel_radius_m: 0.03,
            track_width_m: 0.10,
            max_wheel_speed_rad_per_s: 8.0,
            max_linear_m_per_s: 0.130,
            min_linear_m_per_s: 0.023,
            max_angular_rad_per_s: 1.25,
            min_angular_rad_per_s: 0.20,
            max_linear_acceleration_m_per_s2: 0.3,
            max_angular_acceleration_rad_per_s2: 3.0,
            lag_s: 0.0,
            dead_time_s: 0.0,
            kind: Kind::Differential,
            turn_by_speed_s_per_m: 0.0,
            sideways_m_per_rad: 0.0,
        }
    }
}

impl Validate for Drive {
    fn check(&self, check: &mut Check) {
        self.check_ranges(check);
        self.check_agreement(check);
    }
}

impl Drive {
    /// Checks each field by itself.
    pub(super) fn check_ranges(&self, check: &mut Check) {
        check.number("wheel_radius_m", self.wheel_radius_m, WHEEL_RADIUS);
        check.number("track_width_m", self.track_width_m, TRACK_WIDTH);
        check.number("max_wheel_speed_rad_per_s", self.max_wheel_speed_rad_per_s, WHEEL_SPEED);
        check.number("max_linear_m_per_s", self.max_linear_m_per_s, LINEAR_SPEED);
        check.number("min_linear_m_per_s", self.min_linear_m_per_s, LINEAR_SPEED);
        check.number("max_angular_rad_per_s", self.max_angular_rad_per_s, ANGULAR_SPEED);
        check.number("min_angular_rad_per_s", self.min_angular_rad_per_s, ANGULAR_SPEED);
        check.number(
            "max_linear_acceleration_m_per_s2",
            self.max_linear_acceleration_m_per_s2,
            LINEAR_ACCELERATION,
        );
        check.number(
            "max_angular_acceleration_rad_per_s2",
            self.max_angular_acceleration_rad_per_s2,
            ANGULAR_ACCELERATION,
        );
        check.number("lag_s", self.lag_s, LAG);
        check.number("dead_time_s", self.dead_time_s, LAG);
        check.number("turn_by_speed_s_per_m", self.turn_by_speed_s_per_m, TURN_BY_SPEED);
        check.number("sideways_m_per_rad", self.sideways_m_per_rad, SIDEWAYS);
    }

    /// Checks the fields against each other.
    pub(super) fn check_agreement(&self, check: &mut Check) {
        check.agrees(
            "min_linear_m_per_s",
            self.min_linear_m_per_s <= self.max_linear_m_per_s,
            self.min_linear_m_per_s,
            "use at most max_linear_m_per_s",
        );
        check.agrees(
            "min_angular_rad_per_s",
            self.min_angular_rad_per_s <= self.max_angular_rad_per_s,
            self.min_angular_rad_per_s,
            "use at most max_angular_rad_per_s",
        );
        let wheels = self.max_wheel_speed_rad_per_s * self.wheel_radius_m;
        let turning = self.min_angular_rad_per_s * self.track_width_m / 2.0;
        check.agrees(
            "max_wheel_speed_rad_per_s",
            wheels >= self.min_linear_m_per_s && wheels >= turning,
            self.max_wheel_speed_rad_per_s,
            "use a speed at which the wheels reach min_linear_m_per_s and min_angular_rad_per_s",
        );
        let is_skid_steer = self.kind == Kind::SkidSteer;
        for (name, value) in [
            ("turn_by_speed_s_per_m", self.turn_by_speed_s_per_m),
            ("sideways_m_per_rad", self.sideways_m_per_rad),
        ] {
            let remedy = "leave it out, or describe kind as skid-steer";
            check.agrees(name, is_skid_steer || value == 0.0, value, remedy);
        }
        check.agrees(
            "turn_by_speed_s_per_m",
            self.turn_by_speed_s_per_m.abs() * wheels <= TURN_CHANGE,
            self.turn_by_speed_s_per_m,
            "use at most 0.5 over the speed of the fastest wheels in m/s, either way",
        );
    }
}

/// Known standard deviations of one observed pose; by default those of a good camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = Noise)]
pub struct Noise {
    /// Per axis.
    pub position_m: f64,
    /// Of the heading.
    pub heading_rad: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self { position_m: 0.0005, heading_rad: 0.003 }
    }
}

impl Validate for Noise {
    fn check(&self, check: &mut Check) {
        check.number("position_m", self.position_m, POSITION_NOISE);
        check.number("heading_rad", self.heading_rad, HEADING_NOISE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::reason;

    /// Guards against: numbers of skid steer that are taken and have no effect, or that turn a robot round.
    #[test]
    fn what_skid_steer_says_goes_with_it_and_means_something() {
        let wrong = |drive: Drive| match drive.validate() {
            Ok(()) => Vec::new(),
            Err(problems) => {
                problems.details().iter().map(|it| (it.field.clone(), it.reason.clone())).collect()
            }
        };
        let skid = Drive {
            kind: Kind::SkidSteer,
            turn_by_speed_s_per_m: -2.0,
            sideways_m_per_rad: 0.05,
            ..Drive::default()
        };
        assert_eq!(wrong(skid), []);
        let rolls = Drive { kind: Kind::Differential, ..skid };
        let inconsistent = |field: &str| (field.to_owned(), reason::INCONSISTENT.to_owned());
        let fields = ["turn_by_speed_s_per_m", "sideways_m_per_rad"].map(inconsistent);
        assert_eq!(wrong(rolls), fields);
        // Its fastest wheels run at 0.24 m/s.
        let turns_round = Drive { turn_by_speed_s_per_m: -2.1, ..skid };
        assert_eq!(wrong(turns_round), [inconsistent("turn_by_speed_s_per_m")]);
    }
}
