//! The smallest speeds at which the robot moves: as the watch has raised them, and as its dead band is identified.

use super::Controller;
use super::compensation::{DelayModel, PathFollower, PoseEstimator};
use super::follows::Follows;
use crate::kinematics::Drive;
use crate::watch::{Floor, Floors};

/// Part of a speed at which the wheels surely turn from which on one at which the robot stood contradicts it.
const AS_FAST: f64 = 0.97;

/// Part of the largest speed from which on a robot that may stand moves at that: what stands there is stuck to the watch.
const NEXT_TO_FULL: f64 = 0.8;

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Controller<E, D, F> {
    /// The smallest speeds of this `drive` and those up to which it stands, where they are not those that it has.
    pub(super) fn floors(&self, drive: &Drive) -> Floors {
        let raised = *self.watch.floors();
        let Some(turning) = self.identified_band().map(|follows| follows.turning) else {
            return raised;
        };
        // In m/s and rad/s per rad/s of the wheels.
        let driven = drive.wheel_radius;
        let turned = 2.0 * drive.wheel_radius / drive.track_width;
        let floor = |raised: Floor, described: f64, fastest: f64, per: f64| {
            let (dead, surely) = (per * turning.likely, per * turning.surely);
            let least = if surely < NEXT_TO_FULL * fastest { surely } else { fastest };
            // Where the wheels turn at the smallest speed as likely as not that is no dead band.
            let is_none = dead <= described;
            let contradicts = raised.dead >= AS_FAST * least;
            let is_slope = raised.dead == 0.0 && raised.least > least;
            if is_none || contradicts || is_slope { raised } else { Floor { least, dead } }
        };
        Floors {
            drive: floor(raised.drive, drive.min_linear, drive.max_linear, driven),
            turn: floor(raised.turn, drive.min_angular, drive.max_angular, turned),
        }
    }

    /// The speed in rad/s up to which the wheels may stand, as far as is known; 0 where that is not identified.
    pub(super) fn may_stand(&self) -> f64 {
        self.identified_band().map_or(0.0, |follows| follows.turning.surely)
    }

    /// After how many s the drive follows a command.
    pub(super) fn settles(&self) -> f64 {
        self.follows.as_ref().map_or(0.0, |follows| follows.settles(&self.settings))
    }

    fn identified_band(&self) -> Option<&Follows> {
        self.follows.as_ref().filter(|follows| follows.identifies_band)
    }
}
