//! By which drive the robot moves: that of the server, and its limits hold whatever comes from there.

use crate::told::{Difference, Told};
use umwelt_client::api::Validate;
use umwelt_client::api::problem::Problems;
use umwelt_client::api::step::TaggedDrive;
use umwelt_core::horizon::Horizon;
use umwelt_core::kinematics::{self, Drive};

/// A commanded twist beyond the robot's limits by no more than this, in m/s and rad/s, is rounding.
const ROUNDING: f64 = 1e-9;

/// The drive of a robot and where it comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    told: Told,
    drive: Drive,
    /// How many times its largest speeds it may be commanded.
    corrected_up_to: f64,
    /// Tag of the drive, 0 while the server has not said it.
    tag: u64,
    /// Whether no one has looked at it yet.
    is_news: bool,
}

/// Why a drive from the server is not taken.
#[derive(Debug)]
pub(crate) enum Refused {
    /// Its numbers mean nothing.
    Unbelievable(Problems),
    /// The agent was told another one.
    Differs(Vec<Difference>),
}

impl Limits {
    /// Those of a robot whose agent was `told` so much.
    pub(crate) fn new(told: Told) -> Self {
        let drive = told.over(Drive::default());
        Self { told, drive, corrected_up_to: 1.0, tag: 0, is_news: false }
    }

    /// The drive.
    pub(crate) fn drive(&self) -> &Drive {
        &self.drive
    }

    /// The tag of the drive.
    pub(crate) fn tag(&self) -> u64 {
        self.tag
    }

    /// The drive, where the server has said it since this was asked last.
    pub(crate) fn news(&mut self) -> Option<Drive> {
        std::mem::take(&mut self.is_news).then_some(self.drive)
    }

    /// The server says by which drive the robot is to move; whether that is another one.
    pub(crate) fn describe(&mut self, tagged: &TaggedDrive) -> Result<bool, Refused> {
        if tagged.tag == self.tag {
            return Ok(false);
        }
        tagged.validate().map_err(Refused::Unbelievable)?;
        let drive = tagged.drive.convert();
        let differences = self.told.differences(&drive);
        if !differences.is_empty() {
            return Err(Refused::Differs(differences));
        }
        (self.drive, self.tag, self.is_news) = (drive, tagged.tag, true);
        self.corrected_up_to = tagged.corrected_up_to.unwrap_or(1.0);
        Ok(true)
    }

    /// Brings `horizon` within the limits; whether it was beyond.
    pub(crate) fn hold(&self, horizon: &mut Horizon) -> bool {
        let mut over = false;
        let drive = Drive {
            max_linear: self.drive.max_linear * self.corrected_up_to,
            max_angular: self.drive.max_angular * self.corrected_up_to,
            ..self.drive
        };
        for speeds in &mut horizon.speeds {
            let twist = kinematics::forward(&self.drive, *speeds);
            let limited = drive.limited(twist);
            let excess = (twist.linear - limited.linear).abs();
            if excess.max((twist.angular - limited.angular).abs()) > ROUNDING {
                *speeds = kinematics::inverse(&self.drive, limited);
                over = true;
            }
        }
        over
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_core::geometry::WheelSpeeds;

    fn tagged(wheel_radius: f64) -> TaggedDrive {
        let drive = Drive { wheel_radius, ..Drive::default() };
        TaggedDrive {
            tag: wheel_radius.to_bits() >> 11,
            drive: drive.into(),
            corrected_up_to: None,
        }
    }

    /// Guards against: commands that are corrected for small wheels are cut, and what is cut is corrected for again.
    #[test]
    fn corrected_commands_may_be_faster_by_so_much() {
        let fast = 1.4 * 0.13 / 0.03;
        let hold = |corrected_up_to| {
            let mut limits = Limits::new(Told::default());
            let tagged = TaggedDrive { corrected_up_to, ..tagged(0.03) };
            assert!(matches!(limits.describe(&tagged), Ok(true)));
            let mut horizon = Horizon::EMPTY;
            horizon.speeds.push(WheelSpeeds { left: fast, right: fast });
            limits.hold(&mut horizon)
        };
        assert!(hold(None) && hold(Some(1.2)) && !hold(Some(1.5)));
        let mut limits = Limits::new(Told::default());
        let wrong = TaggedDrive { corrected_up_to: Some(9.0), ..tagged(0.03) };
        assert!(matches!(limits.describe(&wrong), Err(Refused::Unbelievable(_))));
    }

    /// Guards against: the robot moves by default wheels, and what is missing is taken for slip.
    #[test]
    fn the_drive_of_the_server_is_taken_once_and_again_where_it_is_another() {
        let mut limits = Limits::new(Told::default());
        assert_eq!((limits.tag(), limits.news()), (0, None));
        assert!(matches!(limits.describe(&tagged(0.021)), Ok(true)));
        assert_eq!((limits.drive().wheel_radius, limits.tag()), (0.021, tagged(0.021).tag));
        assert_eq!(limits.news().map(|drive| drive.wheel_radius), Some(0.021));
        assert!(matches!(limits.describe(&tagged(0.021)), Ok(false)) && limits.news().is_none());
        assert!(matches!(limits.describe(&tagged(0.033)), Ok(true)) && limits.news().is_some());
    }

    #[test]
    fn what_differs_or_means_nothing_is_not_taken() {
        let told = Told { wheel_radius: Some(0.03), ..Told::default() };
        let mut limits = Limits::new(told);
        let Err(Refused::Differs(differences)) = limits.describe(&tagged(0.021)) else {
            panic!("both were told wheels")
        };
        assert_eq!((differences[0].here, differences[0].there), (0.03, 0.021));
        assert!(matches!(limits.describe(&tagged(-1.0)), Err(Refused::Unbelievable(_))));
        assert!(limits.news().is_none() && limits.drive().wheel_radius == 0.03);
        assert!(matches!(limits.describe(&tagged(0.03)), Ok(true)));
    }

    #[test]
    fn what_is_too_fast_for_the_wheels_is_slowed_down() {
        let mut limits = Limits::new(Told::default());
        let mut horizon = Horizon {
            speeds: std::iter::once(WheelSpeeds { left: 4.0, right: 4.0 }).collect(),
            ..Horizon::EMPTY
        };
        assert!(!limits.hold(&mut horizon), "0.12 m/s");
        limits.describe(&tagged(0.06)).unwrap();
        assert!(limits.hold(&mut horizon), "0.24 m/s");
        let twist = kinematics::forward(limits.drive(), horizon.speeds[0]);
        assert!((twist.linear - 0.13).abs() < 1e-12);
    }
}
