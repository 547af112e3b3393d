//! The link of a simulated environment.

use crate::check::{Check, Checked, Range};
use crate::named::NameOr;
use crate::problem::{Problems, reason};
use serde::{Deserialize, Deserializer, Serialize};
use umwelt_core::link::{self, LONGEST_DELAY, LinkError, MAX_OUTAGES, PRESETS};
use utoipa::ToSchema;

/// Up to five times the worst delay ever recorded.
pub const DELAY: Range = Range::new(0.0, LONGEST_DELAY, "s");
/// Longer than any episode.
pub const OUTAGE_START: Range = Range::new(0.0, 1e6, "s");
/// An outage of an hour is longer than any episode.
pub const OUTAGE_DURATION: Range = Range::new(0.0, 3600.0, "s");
/// At most one silence per two slots of 30 ms.
pub const SILENCE_RATE: Range = Range::new(0.0, 0.5 / umwelt_core::horizon::SLOT, "1/s");
/// Most rows of a recorded round trip: longer recordings are for the simulated agent, which reads files.
pub const MAX_ROWS: usize = 1000;

const PROBABILITY: Range = Range::new(0.0, 1.0, "");

/// A recorded round-trip time, in force from its own time on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = training::TraceRow)]
pub struct TraceRow {
    /// Time since the beginning of the recording; increasing.
    pub t_s: f64,
    /// Round-trip time.
    pub rtt_s: f64,
}

impl Checked for TraceRow {
    fn check(&self, check: &mut Check) {
        check.number("t_s", self.t_s, OUTAGE_START);
        check.number("rtt_s", self.rtt_s, DELAY);
    }
}

/// The ordinary round-trip time, shared by the two directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[schema(as = training::Rtt)]
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

impl Checked for Rtt {
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

impl From<&link::Rtt> for Rtt {
    fn from(core: &link::Rtt) -> Self {
        match core {
            link::Rtt::Constant(rtt) => Self::Constant { rtt_s: *rtt },
            link::Rtt::Lognormal { median, p99 } => {
                Self::Lognormal { median_s: *median, p99_s: *p99 }
            }
            link::Rtt::Trace(trace) => {
                let rows = trace.rows().iter();
                Self::Trace { rows: rows.map(|&(t_s, rtt_s)| TraceRow { t_s, rtt_s }).collect() }
            }
        }
    }
}

impl Rtt {
    fn convert(&self) -> Result<link::Rtt, link::TraceError> {
        Ok(match self {
            Self::Constant { rtt_s } => link::Rtt::Constant(*rtt_s),
            Self::Lognormal { median_s, p99_s } => {
                link::Rtt::Lognormal { median: *median_s, p99: *p99_s }
            }
            Self::Trace { rows } => {
                let rows = rows.iter().map(|row| (row.t_s, row.rtt_s)).collect();
                link::Rtt::Trace(link::RttTrace::new(rows)?)
            }
        })
    }
}

/// Late packets on the way to the robot; none by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = training::LatePackets)]
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
        Self { probability: 0.0, after_late: None, extra_s: link::LATE_EXTRA }
    }
}

impl Checked for LatePackets {
    fn check(&self, check: &mut Check) {
        check.number("probability", self.probability, PROBABILITY);
        check.number("after_late", self.after_late.unwrap_or(0.0), PROBABILITY);
        check.number("extra_s", self.extra_s, DELAY);
    }
}

impl From<link::LatePackets> for LatePackets {
    fn from(core: link::LatePackets) -> Self {
        let after_late = Some(core.after_late);
        Self { probability: core.probability, after_late, extra_s: core.extra }
    }
}

impl LatePackets {
    fn convert(self) -> link::LatePackets {
        let after_late = self.after_late.unwrap_or(self.probability);
        link::LatePackets { probability: self.probability, after_late, extra: self.extra_s }
    }
}

/// A window in which nothing gets through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = training::Outage)]
pub struct Outage {
    /// When it begins, since the beginning of the episode.
    pub start_s: f64,
    /// How long it lasts.
    pub duration_s: f64,
}

impl Checked for Outage {
    fn check(&self, check: &mut Check) {
        check.number("start_s", self.start_s, OUTAGE_START);
        check.number("duration_s", self.duration_s, OUTAGE_DURATION);
    }
}

/// Outages at random; none by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = training::Silences)]
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
        link::Silences::NONE.into()
    }
}

impl Checked for Silences {
    fn check(&self, check: &mut Check) {
        check.number("rate_per_s", self.rate_per_s, SILENCE_RATE);
        check.number("shortest_s", self.shortest_s, DELAY);
        check.number("longest_s", self.longest_s, DELAY);
        let ordered = self.shortest_s > 0.0 && self.shortest_s <= self.longest_s;
        let remedy = "use 0 < shortest_s <= longest_s";
        check.agrees("longest_s", ordered, self.longest_s, remedy);
    }
}

impl From<link::Silences> for Silences {
    fn from(core: link::Silences) -> Self {
        Self { rate_per_s: core.rate, shortest_s: core.shortest, longest_s: core.longest }
    }
}

impl Silences {
    fn convert(self) -> link::Silences {
        link::Silences { rate: self.rate_per_s, shortest: self.shortest_s, longest: self.longest_s }
    }
}

/// What a link is like, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = training::LinkModel)]
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
    link::SENSOR_DELAY
}

fn in_order() -> bool {
    true
}

impl Checked for LinkModel {
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
        self.agree(check);
    }
}

impl LinkModel {
    /// What core alone can say: that late slots form a chain, that silences leave a link.
    fn agree(&self, check: &mut Check) {
        let ordinary = link::LinkModel::ordinary(link::Rtt::Constant(0.0));
        let late = link::LinkModel { late: self.late.convert(), ..ordinary.clone() };
        if let Err(error @ LinkError::Burst { .. }) = late.validate() {
            let after_late = self.late.after_late;
            check.report(reason::INCONSISTENT, "late.after_late", after_late, error.to_string());
        }
        let silences = link::LinkModel { silences: self.silences.convert(), ..ordinary };
        if let Err(error @ LinkError::SilenceLoad { .. }) = silences.validate() {
            let rate = self.silences.rate_per_s;
            check.report(reason::INCONSISTENT, "silences.rate_per_s", rate, error.to_string());
        }
    }

    /// The link in core's terms, whatever its ranges: what a program keeps was checked when it came.
    ///
    /// # Errors
    /// Where a recording is none at all.
    pub fn convert(&self) -> Result<link::LinkModel, link::TraceError> {
        let outages = self.outages.iter();
        Ok(link::LinkModel {
            sensor_delay: self.sensor_delay_s,
            rtt: self.rtt.convert()?,
            late: self.late.convert(),
            outages: outages
                .map(|it| link::Outage { start: it.start_s, duration: it.duration_s })
                .collect(),
            silences: self.silences.convert(),
            in_order: self.in_order,
        })
    }
}

impl From<&link::LinkModel> for LinkModel {
    fn from(core: &link::LinkModel) -> Self {
        let outages = core.outages.iter();
        Self {
            sensor_delay_s: core.sensor_delay,
            rtt: (&core.rtt).into(),
            late: core.late.into(),
            outages: outages
                .map(|it| Outage { start_s: it.start, duration_s: it.duration })
                .collect(),
            silences: core.silences.into(),
            in_order: core.in_order,
        }
    }
}

/// A link: the name of a preset, or its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = training::Link)]
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
            Self::Preset(name) => check.preset(field, name, &PRESETS),
        }
    }

    /// The link in core's terms.
    ///
    /// # Errors
    /// An unknown preset, or everything that is wrong with the numbers; fields are named from `link` on.
    pub fn to_core(&self) -> Result<link::LinkModel, Problems> {
        let mut check = Check::default();
        self.check("link", &mut check);
        let model = match self {
            Self::Preset(name) => link::LinkModel::preset(name),
            Self::Model(model) => check.ok("link", model.convert()),
        };
        check.finish()?;
        Ok(model.unwrap_or_else(|| link::LinkModel::ordinary(link::Rtt::Constant(0.0))))
    }
}

impl From<&link::LinkModel> for Link {
    /// By its name where it is a preset.
    fn from(core: &link::LinkModel) -> Self {
        let same = |name: &&str| link::LinkModel::preset(name).as_ref() == Some(core);
        match PRESETS.into_iter().find(same) {
            Some(name) => Self::Preset(name.to_owned()),
            None => Self::Model(Box::new(core.into())),
        }
    }
}
