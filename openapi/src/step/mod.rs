//! The hot path: observations in, horizon out.

mod horizon;

pub use horizon::{Horizon, Reply, SLOT, TaggedDrive, WHEEL_SPEED, WheelSpeeds};

use crate::body;
use crate::check::{Check, Range, Validate};
use crate::checked::Checked;
use crate::number;
use crate::problem::Problems;
use crate::robot::{LINEAR_SPEED, MAX_INTEGER};
use crate::schema::ToSchema;
use crate::task::COORDINATE;
use serde::{Deserialize, Serialize};

/// Largest body of a step in bytes; a full one has 6 KiB.
pub const MAX_BODY: usize = 64 * 1024;
/// Most poses of one request: a camera of 1000 Hz within a slot of 30 ms.
pub const MAX_OBSERVATIONS: usize = 32;
/// Most deliveries that one request reports; more than arrive in one slot after a stall.
pub const MAX_DELIVERIES: usize = 16;
/// Thirty years of a monotonic clock, at which f64 still resolves a microsecond.
pub const TIME: Range = Range::new(-1e9, 1e9, "s");
/// Headings may be counted without wrapping; beyond 160 000 turns their fraction gets lost.
pub const HEADING: Range = Range::new(-1e6, 1e6, "rad");
/// From a robot that is to rest to the fastest that there is.
pub const MAX_SPEED: Range = Range::new(0.0, LINEAR_SPEED.max, "m/s");
/// A reply that comes after a day teaches nothing.
pub const DELIVERY_DELAY: Range = Range::new(0.0, 86_400.0, "s");

/// A pose and when it was taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Observation)]
pub struct Observation {
    /// World x.
    #[serde(serialize_with = "number::finite")]
    pub x_m: f64,
    /// World y.
    #[serde(serialize_with = "number::finite")]
    pub y_m: f64,
    /// Counter-clockwise from world x, wrapped or not.
    #[serde(serialize_with = "number::finite")]
    pub heading_rad: f64,
    /// Robot time at which it was taken, not when it became known.
    #[serde(serialize_with = "number::finite")]
    pub taken_s: f64,
}

impl Validate for Observation {
    fn check(&self, check: &mut Check) {
        check.number("x_m", self.x_m, COORDINATE);
        check.number("y_m", self.y_m, COORDINATE);
        check.number("heading_rad", self.heading_rad, HEADING);
        check.number("taken_s", self.taken_s, TIME);
    }
}

/// The measured loop delay of one reply.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Delivery)]
pub struct Delivery {
    /// Sequence of the request that was answered.
    pub sequence: u64,
    /// Time from the newest pose of that request being taken to its reply arriving.
    #[serde(serialize_with = "number::finite")]
    pub loop_delay_s: f64,
}

impl Validate for Delivery {
    fn check(&self, check: &mut Check) {
        check.integer("sequence", self.sequence, 0..=MAX_INTEGER);
        check.number("loop_delay_s", self.loop_delay_s, DELIVERY_DELAY);
    }
}

/// What the robot plays now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Playing)]
pub struct Playing {
    /// Sequence of the horizon.
    pub horizon: u64,
    /// Robot time since when.
    #[serde(serialize_with = "number::finite")]
    pub since_s: f64,
}

impl Validate for Playing {
    fn check(&self, check: &mut Check) {
        check.integer("horizon", self.horizon, 0..=MAX_INTEGER);
        check.number("since_s", self.since_s, TIME);
    }
}

/// One request of the robot. All times are its own monotonic clock.
///
/// ```
/// use umwelt_api::step::Request;
/// let request = Request::read(br#"{
///     "sequence": 7, "epoch": 4711, "sent_s": 12.43,
///     "observations": [{"x_m": 0.1, "y_m": 0.0, "heading_rad": 0.02, "taken_s": 12.30}],
///     "deliveries": [{"sequence": 5, "loop_delay_s": 0.21}],
///     "playing": {"horizon": 4, "since_s": 12.40}
/// }"#)?;
/// assert_eq!(request.to_core().observations.len(), 1);
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = StepRequest)]
pub struct Request {
    /// Number of this request, strictly increasing within an epoch.
    pub sequence: u64,
    /// Random number of this run of the agent. One never seen takes the robot over.
    pub epoch: u64,
    /// Robot time of sending.
    #[serde(serialize_with = "number::finite")]
    pub sent_s: f64,
    /// Poses since the last request, oldest first.
    #[serde(default)]
    pub observations: Vec<Observation>,
    /// Replies that arrived since the last request.
    #[serde(default)]
    pub deliveries: Vec<Delivery>,
    /// What the robot plays now; null before the first horizon begins.
    #[serde(default)]
    pub playing: Option<Playing>,
    /// Whether the robot itself holds: a bumper, a lidar field, an e-stop button. It rests whatever it is told, plays nothing
    /// (`playing` is null), and goes on by itself with a horizon that it asked for after the hold.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub hold: bool,
    /// Largest speed that the robot itself allows for now; null for that of its drive. Less than the smallest speed at which
    /// its motors turn is a hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_m_per_s: Option<f64>,
    /// Tag of the drive by which the robot moves, as a reply gave it; 0 before it has one. Left out or null where it does not
    /// ask for one: it is told its drive elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive_tag: Option<u64>,
}

impl Validate for Request {
    fn check(&self, check: &mut Check) {
        check.integer("sequence", self.sequence, 0..=MAX_INTEGER);
        check.integer("epoch", self.epoch, 0..=MAX_INTEGER);
        check.number("sent_s", self.sent_s, TIME);
        if let Some(tag) = self.drive_tag {
            check.integer("drive_tag", tag, 0..=MAX_INTEGER);
        }
        check.length("observations", self.observations.len(), 0..=MAX_OBSERVATIONS);
        check.items("observations", &self.observations);
        for (index, observation) in self.observations.iter().enumerate() {
            let taken = observation.taken_s;
            check.item("observations", index, |check| {
                check.agrees("taken_s", taken <= self.sent_s, taken, "use at most sent_s");
            });
        }
        for (index, pair) in self.observations.windows(2).enumerate() {
            let (before, taken) = (pair[0].taken_s, pair[1].taken_s);
            check.item("observations", index + 1, |check| {
                let remedy = "send poses oldest first, each once: taken_s strictly increases";
                check.agrees("taken_s", before < taken, taken, remedy);
            });
        }
        check.length("deliveries", self.deliveries.len(), 0..=MAX_DELIVERIES);
        check.items("deliveries", &self.deliveries);
        for (index, delivery) in self.deliveries.iter().enumerate() {
            check.item("deliveries", index, |check| {
                let remedy = "report replies to earlier requests only";
                let earlier = delivery.sequence < self.sequence;
                check.agrees("sequence", earlier, delivery.sequence, remedy);
            });
        }
        if let Some(playing) = &self.playing {
            check.field("playing", |check| {
                playing.check(check);
                let since = playing.since_s;
                check.agrees("since_s", since <= self.sent_s, since, "use at most sent_s");
            });
        }
        if let Some(max_speed) = self.max_speed_m_per_s {
            check.number("max_speed_m_per_s", max_speed, MAX_SPEED);
        }
    }
}

impl Request {
    /// Reads the body of a step.
    ///
    /// # Errors
    /// Every problem of it: values out of range, times out of order. An unknown field or a value of a wrong type
    /// is reported alone.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read(json)
    }
}
