//! What is said about a robot once.

use super::{Attribution, Drive, Method, Noise, Predictor, PriorChoice};
use crate::check::{Check, Range, Validate};
use crate::schema::ToSchema;
use crate::task::{DEFAULT_TOLERANCE, TOLERANCE};
use serde::{Deserialize, Serialize};

/// Most slots of one horizon: 2 s of 30 ms, beyond which no prediction is worth playing.
pub const MAX_SLOTS: usize = 67;
/// As long as the longest horizon; a robot farther away than that cannot be controlled.
pub const LOOP_DELAY: Range = Range::new(0.0, 2.0, "s");
/// A pose that is a second old when it is stamped steers no one.
pub const SENSOR_DELAY: Range = Range::new(0.0, 1.0, "s");
/// Longest watchdog that may be described. No robot holds for longer than 1 s
/// (`umwelt_core::horizon::MAX_WATCHDOG`); more was allowed once, and means as much.
pub const WATCHDOG: Range = Range::new(0.0, 5.0, "s");
/// Shortest watchdog other than 0: below it the jitter of a good link stops the robot.
pub const MIN_WATCHDOG: f64 = 0.05;
/// From 10 um to 1 m of standard deviation.
pub const POSITION_VARIANCE: Range = Range::new(1e-10, 1.0, "m^2");
/// Up to the variance of a heading that no one knows.
pub const HEADING_VARIANCE: Range = Range::new(1e-8, 10.0, "rad^2");
/// Speeds of the law as of the drive.
pub const ALPHA: Range = Range::new(1e-3, 10.0, "m/s");
/// Below 0.1 mm no pose is known; a metre from the waypoint is not at it.
pub const STOP_RADIUS: Range = Range::new(1e-4, 1.0, "m");
/// Below 1 mrad no heading is known; beyond a half turn there is none.
pub const TURN: Range = Range::new(1e-3, std::f64::consts::PI, "rad");

/// Largest predicted variance of a pose at which the robot may move as it likes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = VarianceLimits)]
pub struct VarianceLimits {
    /// Of the position, in its worst direction.
    pub position_m2: f64,
    /// Of the heading.
    pub heading_rad2: f64,
}

impl Default for VarianceLimits {
    fn default() -> Self {
        Self { position_m2: 1e-4, heading_rad2: 0.10 }
    }
}

impl Validate for VarianceLimits {
    fn check(&self, check: &mut Check) {
        check.number("position_m2", self.position_m2, POSITION_VARIANCE);
        check.number("heading_rad2", self.heading_rad2, HEADING_VARIANCE);
    }
}

/// The steering law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = Steering)]
pub struct Steering {
    /// Speed of the law on a straight line.
    pub alpha_m_per_s: f64,
    /// Distance to the waypoint at which the robot stops.
    pub stop_radius_m: f64,
    /// Distance from a waypoint within which the robot has arrived, where its task says none.
    pub tolerance_m: f64,
    /// Heading error that is good enough to drive.
    pub turn_tolerance_rad: f64,
    /// Heading error at which a driving robot stops to turn in place; above `turn_tolerance_rad`.
    pub turn_beyond_rad: f64,
}

impl Default for Steering {
    fn default() -> Self {
        Self {
            alpha_m_per_s: 0.2,
            stop_radius_m: 0.002,
            tolerance_m: DEFAULT_TOLERANCE,
            turn_tolerance_rad: 0.10,
            turn_beyond_rad: 0.6,
        }
    }
}

impl Validate for Steering {
    fn check(&self, check: &mut Check) {
        self.check_ranges(check);
        self.check_agreement(check);
    }
}

impl Steering {
    fn check_ranges(&self, check: &mut Check) {
        check.number("alpha_m_per_s", self.alpha_m_per_s, ALPHA);
        check.number("stop_radius_m", self.stop_radius_m, STOP_RADIUS);
        check.number("tolerance_m", self.tolerance_m, TOLERANCE);
        check.number("turn_tolerance_rad", self.turn_tolerance_rad, TURN);
        check.number("turn_beyond_rad", self.turn_beyond_rad, TURN);
    }

    fn check_agreement(&self, check: &mut Check) {
        check.agrees(
            "turn_beyond_rad",
            self.turn_beyond_rad > self.turn_tolerance_rad,
            self.turn_beyond_rad,
            "use more than turn_tolerance_rad",
        );
    }
}

/// What is said about a robot once. Everything may be left out; a response has it all filled in. What was not said has its
/// default, or follows from the rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = RobotSpec)]
pub struct Spec {
    /// Geometry, limits and lag of the drive.
    pub drive: Drive,
    /// How well its pose is seen.
    pub noise: Noise,
    /// How its environment is identified.
    pub method: Method,
    /// What errors are measured against: by default the commands as played, of the methods of the thesis those as sent.
    pub attribution: Attribution,
    /// Whether the drift channel (heading per metre) is used; of method `adaptive` it always is.
    pub drift: bool,
    /// Slots of 30 ms per horizon; 1 is the thesis.
    pub horizon_slots: usize,
    /// Time from a pose being taken to its reply being applied: where it is said, that; otherwise it is identified, and this
    /// is what counts until the first delivery.
    pub loop_delay_s: f64,
    /// Time from a pose being taken to the stamp that it comes with, where the tracker stamps late or not at all.
    pub sensor_delay_s: f64,
    /// How long the robot holds the last entry of a horizon before it ramps to rest: 0.05 or more,
    /// or 0 to hold for ever (refused by hardware drives). More than 1 s counts as 1 s.
    pub watchdog_s: f64,
    /// How poses are predicted.
    pub predictor: Predictor,
    /// Limits of the predicted variance.
    pub variance: VarianceLimits,
    /// The steering law.
    pub steering: Steering,
    /// Belief about the floor before any sample: the name of a prior, or one of the robot's own.
    pub prior: PriorChoice,
}

impl Default for Spec {
    fn default() -> Self {
        Self {
            drive: Drive::default(),
            noise: Noise::default(),
            method: Method::Adaptive,
            attribution: Attribution::Played,
            drift: false,
            horizon_slots: 40,
            loop_delay_s: 0.23,
            sensor_delay_s: 0.0,
            watchdog_s: 0.3,
            predictor: Predictor::Moments,
            variance: VarianceLimits::default(),
            steering: Steering::default(),
            prior: PriorChoice::default(),
        }
    }
}

impl Validate for Spec {
    fn check(&self, check: &mut Check) {
        self.check_ranges(check);
        self.check_agreement(check);
    }
}

impl Spec {
    /// Checks each field by itself.
    pub(super) fn check_ranges(&self, check: &mut Check) {
        check.field("drive", |check| self.drive.check_ranges(check));
        check.field("noise", |check| self.noise.check(check));
        check.integer("horizon_slots", self.horizon_slots as u64, 1..=MAX_SLOTS as u64);
        check.number("loop_delay_s", self.loop_delay_s, LOOP_DELAY);
        check.number("sensor_delay_s", self.sensor_delay_s, SENSOR_DELAY);
        check.number("watchdog_s", self.watchdog_s, WATCHDOG);
        check.agrees(
            "watchdog_s",
            !(self.watchdog_s > 0.0 && self.watchdog_s < MIN_WATCHDOG),
            self.watchdog_s,
            "use 0.05 s or more, or 0 to hold for ever",
        );
        check.field("predictor", |check| self.predictor.check(check));
        check.field("variance", |check| self.variance.check(check));
        check.field("steering", |check| self.steering.check_ranges(check));
        self.prior.check("prior", check);
    }

    /// Brings what follows from the rest within what may be said.
    #[cfg(feature = "core")]
    pub(crate) fn hold_derived(&mut self) {
        use super::{
            ANGULAR_ACCELERATION, ANGULAR_SPEED, LINEAR_ACCELERATION, LINEAR_SPEED, WHEEL_SPEED,
        };
        let Self { drive, variance, steering, watchdog_s, .. } = self;
        for (value, range) in [
            (&mut drive.max_linear_m_per_s, LINEAR_SPEED),
            (&mut drive.min_linear_m_per_s, LINEAR_SPEED),
            (&mut drive.max_angular_rad_per_s, ANGULAR_SPEED),
            (&mut drive.min_angular_rad_per_s, ANGULAR_SPEED),
            (&mut drive.max_linear_acceleration_m_per_s2, LINEAR_ACCELERATION),
            (&mut drive.max_angular_acceleration_rad_per_s2, ANGULAR_ACCELERATION),
            (&mut drive.max_wheel_speed_rad_per_s, WHEEL_SPEED),
            (&mut steering.alpha_m_per_s, ALPHA),
            (&mut steering.stop_radius_m, STOP_RADIUS),
            (&mut steering.tolerance_m, TOLERANCE),
            (&mut steering.turn_tolerance_rad, TURN),
            (&mut steering.turn_beyond_rad, TURN),
            (&mut variance.position_m2, POSITION_VARIANCE),
            (&mut variance.heading_rad2, HEADING_VARIANCE),
            (watchdog_s, WATCHDOG),
        ] {
            *value = value.clamp(range.min, range.max);
        }
    }

    /// Checks the fields against each other.
    pub(crate) fn check_agreement(&self, check: &mut Check) {
        check.field("drive", |check| self.drive.check_agreement(check));
        check.field("steering", |check| self.steering.check_agreement(check));
    }
}
