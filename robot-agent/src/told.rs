//! What the agent itself was told of the drive. The server has all of it; what both say must agree.

use std::fmt;
use umwelt_core::kinematics::Drive;

/// What the agent was told of its robot's drive, beside what the server says. Nothing, as a rule.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// Radius of both wheels in m.
    pub wheel_radius: Option<f64>,
    /// Distance between the wheels in m.
    pub track_width: Option<f64>,
    /// Largest speed of either wheel in rad/s.
    pub max_wheel_speed: Option<f64>,
    /// Largest speed in m/s.
    pub max_linear: Option<f64>,
    /// Smallest speed in m/s at which the motors turn.
    pub min_linear: Option<f64>,
    /// Largest angular velocity in rad/s.
    pub max_angular: Option<f64>,
    /// Smallest angular velocity in rad/s of a turn in place.
    pub min_angular: Option<f64>,
    /// Largest change of speed in m/s^2.
    pub max_linear_acceleration: Option<f64>,
    /// Largest change of angular velocity in rad/s^2.
    pub max_angular_acceleration: Option<f64>,
}

/// Something that agent and server were told differently.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The flag by which either is told it, without its hyphens.
    pub flag: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What the agent was told.
    pub here: f64,
    /// What the server was told.
    pub there: f64,
}

/// Numbers that differ by no more than this part are the same number, written with fewer digits.
const SAME: f64 = 1e-6;

impl Told {
    /// All of `drive`.
    pub fn all(drive: &Drive) -> Self {
        Self {
            wheel_radius: Some(drive.wheel_radius),
            track_width: Some(drive.track_width),
            max_wheel_speed: Some(drive.max_wheel_speed),
            max_linear: Some(drive.max_linear),
            min_linear: Some(drive.min_linear),
            max_angular: Some(drive.max_angular),
            min_angular: Some(drive.min_angular),
            max_linear_acceleration: Some(drive.max_linear_acceleration),
            max_angular_acceleration: Some(drive.max_angular_acceleration),
        }
    }

    /// `drive` with what was told in its place.
    pub fn over(&self, drive: Drive) -> Drive {
        Drive {
            wheel_radius: self.wheel_radius.unwrap_or(drive.wheel_radius),
            track_width: self.track_width.unwrap_or(drive.track_width),
            max_wheel_speed: self.max_wheel_speed.unwrap_or(drive.max_wheel_speed),
            max_linear: self.max_linear.unwrap_or(drive.max_linear),
            min_linear: self.min_linear.unwrap_or(drive.min_linear),
            max_angular: self.max_angular.unwrap_or(drive.max_angular),
            min_angular: self.min_angular.unwrap_or(drive.min_angular),
            max_linear_acceleration: self
                .max_linear_acceleration
                .unwrap_or(drive.max_linear_acceleration),
            max_angular_acceleration: self
                .max_angular_acceleration
                .unwrap_or(drive.max_angular_acceleration),
            ..drive
        }
    }

    /// What was told otherwise than `server` has it.
    pub fn differences(&self, server: &Drive) -> Vec<Difference> {
        let both = [
            ("wheel-radius", "m", self.wheel_radius, server.wheel_radius),
            ("track-width", "m", self.track_width, server.track_width),
            ("max-wheel-speed", "rad/s", self.max_wheel_speed, server.max_wheel_speed),
            ("max-speed", "m/s", self.max_linear, server.max_linear),
            ("min-speed", "m/s", self.min_linear, server.min_linear),
            ("max-turn", "rad/s", self.max_angular, server.max_angular),
            ("min-turn", "rad/s", self.min_angular, server.min_angular),
            (
                "max-acceleration",
                "m/s^2",
                self.max_linear_acceleration,
                server.max_linear_acceleration,
            ),
            (
                "max-turn-acceleration",
                "rad/s^2",
                self.max_angular_acceleration,
                server.max_angular_acceleration,
            ),
        ];
        let differs = |(flag, unit, here, there): (_, _, Option<f64>, f64)| {
            let here = here.filter(|here| (here - there).abs() > SAME * there.abs())?;
            Some(Difference { flag, unit, here, there })
        };
        both.into_iter().filter_map(differs).collect()
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { flag, unit, here, there } = self;
        write!(f, "--{flag} {here} {unit} here and {there} {unit} on the server")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_told_can_differ() {
        let server = Drive { wheel_radius: 0.021, ..Drive::default() };
        assert_eq!(Told::default().differences(&server), []);
        assert_eq!(Told::all(&server).differences(&server), []);
        assert_eq!(Told::default().over(server), server);
        let rounded = Told { wheel_radius: Some(0.021 + 1e-9), ..Told::default() };
        assert_eq!(rounded.differences(&server), []);
        let other = Told { wheel_radius: Some(0.03), max_angular: Some(1.0), ..Told::default() };
        let said: Vec<_> = other.differences(&server).iter().map(ToString::to_string).collect();
        let expected = [
            "--wheel-radius 0.03 m here and 0.021 m on the server",
            "--max-turn 1 rad/s here and 1.25 rad/s on the server",
        ];
        assert_eq!(said, expected);
    }

    /// Guards against a flag that is compared with another one's value.
    #[test]
    fn each_one_is_compared_with_its_own() {
        let server = Drive::default();
        let other = Drive {
            wheel_radius: 1.0,
            track_width: 2.0,
            max_wheel_speed: 3.0,
            max_linear: 4.0,
            min_linear: 5.0,
            max_angular: 6.0,
            min_angular: 7.0,
            max_linear_acceleration: 8.0,
            max_angular_acceleration: 9.0,
            ..server
        };
        let differences = Told::all(&other).differences(&server);
        assert_eq!(differences.len(), 9);
        assert!(differences.iter().zip(1..).all(|(it, n)| it.here == f64::from(n)));
        assert_eq!(Told::all(&other).over(server), other);
    }
}
