//! The hot path.

use crate::check::Validate;
use crate::checked::Checked;
use crate::problem::Problems;
use crate::step::{Delivery, Horizon, Observation, Playing, Request, WheelSpeeds};
use umwelt_core::actuation;
use umwelt_core::exchange;
use umwelt_core::geometry;
use umwelt_core::horizon;
use umwelt_core::local::LocalLimits;
use umwelt_core::time::RobotTime;

impl From<exchange::Observation> for Observation {
    fn from(core: exchange::Observation) -> Self {
        Self {
            x_m: core.pose.x,
            y_m: core.pose.y,
            heading_rad: core.pose.heading.radians(),
            taken_s: core.taken.seconds(),
        }
    }
}

impl Observation {
    fn convert(self) -> exchange::Observation {
        exchange::Observation {
            pose: geometry::Pose::new(self.x_m, self.y_m, self.heading_rad),
            taken: RobotTime::new(self.taken_s),
        }
    }
}

impl From<exchange::Delivery> for Delivery {
    fn from(core: exchange::Delivery) -> Self {
        Self { sequence: core.sequence, loop_delay_s: core.loop_delay }
    }
}

impl Delivery {
    fn convert(self) -> exchange::Delivery {
        exchange::Delivery { sequence: self.sequence, loop_delay: self.loop_delay_s }
    }
}

impl From<actuation::Playing> for Playing {
    fn from(core: actuation::Playing) -> Self {
        Self { horizon: core.horizon, since_s: core.since.seconds() }
    }
}

impl Request {
    /// The request of the robot in `epoch`. The connection stays behind: it is the transport's.
    pub fn from_core(core: &exchange::Request, epoch: u64) -> Self {
        Self {
            sequence: core.sequence,
            epoch,
            sent_s: core.sent.seconds(),
            observations: core.observations.iter().copied().map(Observation::from).collect(),
            deliveries: core.deliveries.iter().copied().map(Delivery::from).collect(),
            playing: core.playing.map(Playing::from),
            hold: core.limits.hold,
            max_speed_m_per_s: core.limits.max_speed,
            drive_tag: None,
        }
    }
}

impl Checked<Request> {
    /// The request in core's terms, on connection 0.
    pub fn to_core(&self) -> exchange::Request {
        exchange::Request {
            sequence: self.sequence,
            connection: 0,
            sent: RobotTime::new(self.sent_s),
            observations: self.observations.iter().copied().map(Observation::convert).collect(),
            deliveries: self.deliveries.iter().copied().map(Delivery::convert).collect(),
            playing: self.playing.map(|playing| actuation::Playing {
                horizon: playing.horizon,
                since: RobotTime::new(playing.since_s),
            }),
            limits: LocalLimits { hold: self.hold, max_speed: self.max_speed_m_per_s },
        }
    }
}

impl Horizon {
    /// The horizon to play. `valid_until_s` is for readers; the robot computes it from the rest.
    ///
    /// # Errors
    /// Every field that is out of its range: a robot plays nothing that it cannot believe.
    pub fn to_core(&self) -> Result<horizon::Horizon, Problems> {
        self.validate()?;
        let speeds = self.wheel_speeds.iter().map(|speeds| geometry::WheelSpeeds {
            left: speeds.left_rad_per_s,
            right: speeds.right_rad_per_s,
        });
        Ok(horizon::Horizon {
            sequence: self.sequence,
            answers: self.answers,
            start: RobotTime::new(self.start_s),
            slot: self.slot_s,
            watchdog: self.watchdog_s,
            speeds: speeds.collect(),
        })
    }
}

impl From<&horizon::Horizon> for Horizon {
    fn from(core: &horizon::Horizon) -> Self {
        Self {
            sequence: core.sequence,
            answers: core.answers,
            start_s: core.start.seconds(),
            slot_s: core.slot,
            watchdog_s: core.watchdog,
            valid_until_s: super::known(core.valid_until().seconds()),
            wheel_speeds: core.speeds.iter().copied().map(WheelSpeeds::from).collect(),
        }
    }
}

impl From<geometry::WheelSpeeds> for WheelSpeeds {
    fn from(core: geometry::WheelSpeeds) -> Self {
        Self { left_rad_per_s: core.left, right_rad_per_s: core.right }
    }
}
