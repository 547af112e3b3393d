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
        Self { told, drive: told.over(Drive::default()), tag: 0, is_news: false }
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
        Ok(true)
    }

    /// Brings `horizon` within the limits; whether it was beyond.
    pub(crate) fn hold(&self, horizon: &mut Horizon) -> bool {
        let mut over = false;
        for speeds in &mut horizon.speeds {
            let twist = kinematics::forward(&self.drive, *speeds);
            let limited = self.drive.limited(twist);
            let excess = (twist.linear - limited.linear).abs();
            if excess.max((twist.angular - limited.angular).abs()) > ROUNDING {
                *speeds = kinematics::inverse(&self.drive, limited);
                over = true;
            }
        }
        over
    }
}
