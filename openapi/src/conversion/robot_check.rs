//! The wiggle of a check, and its report.

use crate::robot_check::{Fault, Finding, Report, Wiggle};
use umwelt_core::check;
use umwelt_core::task;

impl From<task::Check> for Wiggle {
    fn from(core: task::Check) -> Self {
        Self {
            speed_share: core.speed,
            rest_s: core.rest,
            turn_s: core.turn,
            drive_s: core.drive,
            pause_s: core.pause,
        }
    }
}

impl Wiggle {
    /// In core's terms.
    pub(super) fn convert(&self) -> task::Check {
        task::Check {
            speed: self.speed_share,
            rest: self.rest_s,
            turn: self.turn_s,
            drive: self.drive_s,
            pause: self.pause_s,
        }
    }
}

impl From<check::Fault> for Fault {
    fn from(core: check::Fault) -> Self {
        use check::Fault as Core;
        match core {
            Core::NoPoses => Self::NoPoses,
            Core::TooFewPoses => Self::TooFewPoses,
            Core::OtherClock => Self::OtherClock,
            Core::TooFar => Self::TooFar,
            Core::DoesNotMove => Self::DoesNotMove,
            Core::DoesNotDrive => Self::DoesNotDrive,
            Core::DoesNotTurn => Self::DoesNotTurn,
            Core::HeadingFixed => Self::HeadingFixed,
            Core::Millimetres => Self::PositionsInMillimetres,
            Core::Centimetres => Self::PositionsInCentimetres,
            Core::Degrees => Self::HeadingInDegrees,
            Core::LeftInverted => Self::LeftWheelInverted,
            Core::RightInverted => Self::RightWheelInverted,
            Core::BothInverted => Self::BothWheelsInverted,
            Core::Swapped => Self::WheelsSwapped,
            Core::LeftStands => Self::LeftWheelStands,
            Core::RightStands => Self::RightWheelStands,
            Core::HalfTurn => Self::HeadingHalfTurnOff,
            Core::QuarterTurn => Self::HeadingQuarterTurnOff,
            Core::HeadingOff => Self::HeadingOff,
            Core::Clockwise => Self::HeadingClockwise,
            Core::MirroredX => Self::XMirrored,
            Core::MirroredY => Self::YMirrored,
            Core::Exchanged => Self::AxesExchanged,
            Core::Delay => Self::Delay,
            Core::Noise => Self::Noise,
            Core::WheelRadius => Self::WheelRadius,
            Core::TrackWidth => Self::TrackWidth,
            Core::Unclear => Self::Unclear,
        }
    }
}

impl From<&check::Finding> for Finding {
    fn from(core: &check::Finding) -> Self {
        let (name, remedy) = (core.fault().into(), core.remedy().to_owned());
        Self { name, seen: core.seen(), remedy }
    }
}

impl From<&check::Report> for Report {
    fn from(core: &check::Report) -> Self {
        let numbers = &core.numbers;
        Self {
            findings: core.findings.iter().map(Finding::from).collect(),
            delay_s: numbers.delay,
            described_delay_s: numbers.described_delay,
            noise_position_m: numbers.noise.map(|noise| noise.position),
            noise_heading_rad: numbers.noise.map(|noise| noise.heading),
            forward_ratio: numbers.forward,
            turn_ratio: numbers.turn,
            poses_per_second: numbers.poses_per_second,
            span_s: numbers.span,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot;
    use umwelt_core::check::Wiggle as Core;
    use umwelt_core::kinematics::Drive;

    #[test]
    fn names_are_those_of_the_wire_and_of_core() {
        for fault in check::Fault::ALL {
            let wire = Fault::from(fault);
            let json = serde_json::to_value(wire).unwrap();
            assert_eq!((json.as_str(), wire.name()), (Some(fault.name()), fault.name()));
        }
        assert_eq!(serde_json::from_str::<Fault>("\"of-tomorrow\"").unwrap(), Fault::Other);
    }

    /// What the contract says of room and time, held against core's own wiggle.
    #[test]
    fn room_and_time_are_those_of_core() {
        assert_eq!(task::Check::default(), Wiggle::default().convert());
        let truck =
            Drive { track_width: 1.3, max_linear: 2.0, max_wheel_speed: 80.0, ..Drive::default() };
        let slow = Drive { max_wheel_speed: 1.0, dead_time: 0.4, lag: 0.1, ..Drive::default() };
        let coarse = Drive { min_linear: 0.12, min_angular: 1.2, ..Drive::default() };
        for drive in [Drive::default(), truck, slow, coarse] {
            let (core, wire) = (Core::new(task::Check::default(), &drive), Wiggle::default());
            let described = robot::Drive::from(drive);
            assert!((core.length() - wire.length_m(&described)).abs() < 1e-12, "{drive:?}");
            assert!((core.duration() - wire.duration_s(&described)).abs() < 1e-9, "{drive:?}");
            let turn = core.part(1).map(|part| part.twist.angular * part.duration);
            assert!((turn.unwrap() - wire.turn_rad(&described)).abs() < 1e-12, "{drive:?}");
        }
    }
}
