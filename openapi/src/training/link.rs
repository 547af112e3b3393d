//! The link of a simulated environment.

use super::simulator;
use crate::check::{Check, Range, Validate};
use crate::named::NameOr;
use crate::problem::reason;
use crate::schema::ToSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Up to five times the worst delay ever recorded.
pub const DELAY: Range = Range::new(0.0, 60.0, "s");
/// Longer than any episode.
pub const OUTAGE_START: Range = Range::new(0.0, 1e6, "s");
/// An outage of an hour is longer than any episode.
pub const OUTAGE_DURATION: Range = Range::new(0.0, 3600.0, "s");
/// At most one silence per two slots of 30 ms.
pub const SILENCE_RATE: Range = Range::new(0.0, 0.5 / SLOT, "1/s");
/// Most rows of a recorded round trip: longer recordings are for the simulated agent, which reads files.
pub const MAX_ROWS: usize = 1000;

/// Most outages: they are looked up per packet and checked per request.
pub const MAX_OUTAGES: usize = 1000;
/// The links that have a name, from the best to the worst.
pub const LINKS: [&str; 4] = ["clean", "normal", "bad", "wifi-bursty"];
/// Extra delay in s of a late packet, where nothing is said (thesis table 1).
const LATE_EXTRA: f64 = 0.4;
/// Time in s from a pose being taken to its being known on the robot, where nothing is said.
const SENSOR_DELAY: f64 = 0.13;
/// Length in s of a slot.
const SLOT: f64 = 0.030;

const PROBABILITY: Range = Range::new(0.0, 1.0, "");

/// A recorded round-trip time, in force from its own time on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = TraceRow)]
pub struct TraceRow {
    /// Time since the beginning of the recording; increasing.
    pub t_s: f64,
    /// Round-trip time.
    pub rtt_s: f64,
}

impl Validate for TraceRow {
    fn check(&self, check: &mut Check) {
        check.number("t_s", self.t_s, OUTAGE_START);
        check.number("rtt_s", self.rtt_s, DELAY);
    }
}

/// The ordinary round-trip time, shared by the two directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[schema(as = Rtt)]
pub enum Rtt {
    /// The same for every packet.
    Constant {
        /// Round-trip time.
        rtt_s: f64,
    },
    /// Its logarithm is normal.
    Lognormal {
        /// Median, above 0.
        median_s: f64,
        /// 99 % quantile, above the median.
        p99_s: f64,
    },
    /// A recording, repeated for ever.
    Trace {
        /// Rows in the order of time.
        rows: Vec<TraceRow>,
    },
}

impl Validate for Rtt {
    fn check(&self, check: &mut Check) {
        match self {
            Self::Constant { rtt_s } => check.number("rtt_s", *rtt_s, DELAY),
            Self::Lognormal { median_s, p99_s } => {
                check.number("median_s", *median_s, DELAY);
                check.number("p99_s", *p99_s, DELAY);
                let ordered = *median_s > 0.0 && median_s < p99_s;
                check.agrees("p99_s", ordered, *p99_s, "use 0 < median_s < p99_s");
            }
            Self::Trace { rows } => {
                check.length("rows", rows.len(), 1..=MAX_ROWS);
                check.items("rows", rows);
                for (index, pair) in rows.windows(2).enumerate() {
                    check.item("rows", index + 1, |check| {
                        let (before, at) = (pair[0].t_s, pair[1].t_s);
                        check.agrees("t_s", at > before, at, "use times that increase");
                    });
                }
            }
        }
    }
}

/// Late packets on the way to the robot; none by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = LatePackets)]
pub struct LatePackets {
    /// Probability that a slot of 30 ms is late, over the long run.
    pub probability: f64,
    /// Probability that a slot is late if the slot before it was; null for the same as ever.
    pub after_late: Option<f64>,
    /// Extra delay of packets sent in a late slot.
    pub extra_s: f64,
}

impl Default for LatePackets {
    fn default() -> Self {
        Self { probability: 0.0, after_late: None, extra_s: LATE_EXTRA }
    }
}

impl Validate for LatePackets {
    fn check(&self, check: &mut Check) {
        check.number("probability", self.probability, PROBABILITY);
        check.number("after_late", self.after_late.unwrap_or(0.0), PROBABILITY);
        check.number("extra_s", self.extra_s, DELAY);
    }
}

/// A window in which nothing gets through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Outage)]
pub struct Outage {
    /// When it begins, since the beginning of the episode.
    pub start_s: f64,
    /// How long it lasts.
    pub duration_s: f64,
}

impl Validate for Outage {
    fn check(&self, check: &mut Check) {
        check.number("start_s", self.start_s, OUTAGE_START);
        check.number("duration_s", self.duration_s, OUTAGE_DURATION);
    }
}

/// Outages at random; none by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = Silences)]
pub struct Silences {
    /// How many begin per second.
    pub rate_per_s: f64,
    /// Shortest duration, above 0.
    pub shortest_s: f64,
    /// Longest duration.
    pub longest_s: f64,
}

impl Default for Silences {
    fn default() -> Self {
        Self { rate_per_s: 0.0, shortest_s: 1.0, longest_s: 1.0 }
    }
}

impl Validate for Silences {
    fn check(&self, check: &mut Check) {
        check.number("rate_per_s", self.rate_per_s, SILENCE_RATE);
        check.number("shortest_s", self.shortest_s, DELAY);
        check.number("longest_s", self.longest_s, DELAY);
        let ordered = self.shortest_s > 0.0 && self.shortest_s <= self.longest_s;
        let remedy = "use 0 < shortest_s <= longest_s";
        check.agrees("longest_s", ordered, self.longest_s, remedy);
    }
}

/// What a link is like, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = LinkModel)]
pub struct LinkModel {
    /// From a pose being taken to its being known on the robot.
    #[serde(default = "sensor_delay")]
    #[schema(default = sensor_delay)]
    pub sensor_delay_s: f64,
    /// Ordinary round-trip time.
    pub rtt: Rtt,
    /// Late packets.
    #[serde(default)]
    pub late: LatePackets,
    /// Known outages in the order of time, none beginning within another.
    #[serde(default)]
    pub outages: Vec<Outage>,
    /// Outages at random.
    #[serde(default)]
    pub silences: Silences,
    /// Whether no packet overtakes an earlier one and none is lost, as over TCP.
    #[serde(default = "in_order")]
    #[schema(default = in_order)]
    pub in_order: bool,
}

fn sensor_delay() -> f64 {
    SENSOR_DELAY
}

fn in_order() -> bool {
    true
}

impl Validate for LinkModel {
    fn check(&self, check: &mut Check) {
        check.number("sensor_delay_s", self.sensor_delay_s, DELAY);
        check.field("rtt", |check| self.rtt.check(check));
        check.field("late", |check| self.late.check(check));
        check.length("outages", self.outages.len(), 0..=MAX_OUTAGES);
        check.items("outages", &self.outages);
        for (index, pair) in self.outages.windows(2).enumerate() {
            check.item("outages", index + 1, |check| {
                let end = pair[0].start_s + pair[0].duration_s;
                let start = pair[1].start_s;
                let remedy = "begin where the one before has ended";
                check.agrees("start_s", start >= end, start, remedy);
            });
        }
        check.field("silences", |check| self.silences.check(check));
        let LatePackets { probability, after_late, .. } = self.late;
        if let Err(why) = simulator::bursts(probability, after_late.unwrap_or(probability)) {
            check.report(reason::INCONSISTENT, "late.after_late", after_late, why);
        }
        let Silences { rate_per_s, shortest_s, longest_s } = self.silences;
        if let Err(why) = simulator::silences(rate_per_s, shortest_s, longest_s) {
            check.report(reason::INCONSISTENT, "silences.rate_per_s", rate_per_s, why);
        }
    }
}

/// A link: the name of a preset, or its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = TrainingLink)]
pub enum Link {
    /// One of `clean`, `normal`, `bad`, `wifi-bursty`; a later version may know more.
    Preset(String),
    /// Its numbers.
    Model(Box<LinkModel>),
}

impl<'de> Deserialize<'de> for Link {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match NameOr::read(deserializer, "the name of a link, or an object with its model")? {
            NameOr::Name(name) => Self::Preset(name),
            NameOr::Thing(model) => Self::Model(Box::new(model)),
        })
    }
}

impl Link {
    pub(super) fn check(&self, field: &str, check: &mut Check) {
        match self {
            Self::Model(model) => check.field(field, |check| model.check(check)),
            Self::Preset(name) => check.preset(field, name, &LINKS),
        }
    }
}
