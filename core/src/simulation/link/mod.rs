//! The link between robot and server: constant and random delay, late packets, outages, silences, recorded traces.
//!
//! [`LinkModel`] says what a link is like, [`Link`] is one run of it under a seed. Times are s on one simulated clock.
//! A link is random by **slot** of 30 ms: all packets of one direction sent in one slot share delay, lateness and
//! loss, and what a slot is like depends on the seed and the slot's number alone, never on the traffic. Methods
//! compared under one seed therefore meet the same late slots however much they send.

mod check;
mod limits;
mod packets;
mod trace;

pub use check::LinkError;
pub use limits::{LONGEST_DELAY, MAX_LATE_CORRELATION, MAX_OUTAGES, MAX_SILENCE_LOAD};
pub use packets::Link;
pub use trace::{MAX_TRACE_ROWS, RttTrace, TRACE_HEADER, TraceError, parse_trace};

use crate::horizon::SLOT;

/// From the pose being taken to its being known on the robot, in s: 130 ms, stable (thesis table 1).
pub const SENSOR_DELAY: f64 = 0.13;

/// Extra delay in s of a late packet (thesis table 1).
pub const LATE_EXTRA: f64 = 0.4;

/// The names that [`LinkModel::preset`] knows, from the best link to the worst.
pub const PRESETS: [&str; 4] = ["clean", "normal", "bad", "wifi-bursty"];

/// The standard normal quantile of 99 %.
const Z_99: f64 = 2.326_347_874_040_841;

/// The ordinary round-trip time, shared by the two directions.
#[derive(Clone, Debug, PartialEq)]
pub enum Rtt {
    /// The same RTT in s for every packet.
    Constant(f64),
    /// An RTT whose logarithm is normal: the sum of two independent delays, one per direction, chosen so that the
    /// round trip has these quantiles (to a few percent for heavy tails).
    Lognormal {
        /// Median in s.
        median: f64,
        /// 99 % quantile in s.
        p99: f64,
    },
    /// A recording: half of the RTT in force when the packet is sent.
    Trace(RttTrace),
}

/// Late packets: a downlink slot is late with a probability that depends on the slot before (a two-state chain).
///
/// Independent slots are the chain whose `after_late` is `probability`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatePackets {
    /// Probability that a slot is late, over the long run.
    pub probability: f64,
    /// Probability that a slot is late if the slot before it was.
    pub after_late: f64,
    /// Extra delay in s of packets sent in a late slot.
    pub extra: f64,
}

impl LatePackets {
    /// No late packets.
    pub const NONE: Self = Self::independent(0.0);

    /// Slots that are late with `probability` whatever the slot before was, by [`LATE_EXTRA`].
    pub const fn independent(probability: f64) -> Self {
        Self { probability, after_late: probability, extra: LATE_EXTRA }
    }

    /// Probability that a slot is late if the slot before it was not: p (1 - a)/(1 - p).
    ///
    /// It is what keeps the long-run probability p where a is `after_late`.
    pub fn after_on_time(&self) -> f64 {
        if self.probability >= 1.0 {
            return 1.0;
        }
        self.probability * (1.0 - self.after_late) / (1.0 - self.probability)
    }

    /// Probability that a slot is late if the one `slots` before it was, or was not, `late`:
    /// p + (late - p) c^slots, where c = `after_late` - `after_on_time` is the correlation of neighbours.
    ///
    /// ```
    /// use umwelt_core::link::LatePackets;
    /// let late = LatePackets { probability: 0.05, after_late: 0.3, extra: 0.4 };
    /// assert!((late.probability_after(true, 1) - 0.3).abs() < 1e-12);
    /// assert!((late.probability_after(false, 100) - 0.05).abs() < 1e-12);
    /// ```
    pub fn probability_after(&self, late: bool, slots: u32) -> f64 {
        let correlation = self.after_late - self.after_on_time();
        let start = if late { 1.0 } else { 0.0 };
        self.probability + (start - self.probability) * correlation.powf(f64::from(slots))
    }
}

/// A window in which nothing gets through, in either direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outage {
    /// Begin in s; a packet sent at it is in the outage.
    pub start: f64,
    /// Length in s; a packet sent at the end is not in the outage.
    pub duration: f64,
}

/// Outages at random: each slot begins one with probability `rate` x [`SLOT`].
///
/// Durations are heavy-tailed: P(longer than d) falls as 1/d between `shortest` and `longest` (bounded Pareto).
/// Silences that overlap join, so the link may now and then be silent for more than `longest`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silences {
    /// Silences per s; 0 for none.
    pub rate: f64,
    /// Shortest duration in s.
    pub shortest: f64,
    /// Longest duration in s.
    pub longest: f64,
}

impl Silences {
    /// No silences.
    pub const NONE: Self = Self { rate: 0.0, shortest: 1.0, longest: 1.0 };

    /// The duration in s that a share `quantile` of all silences do not exceed.
    ///
    /// ```
    /// use umwelt_core::link::Silences;
    /// let silences = Silences { rate: 0.1, shortest: 0.5, longest: 12.0 };
    /// assert_eq!((silences.duration(0.0), silences.duration(1.0)), (0.5, 12.0));
    /// ```
    pub fn duration(&self, quantile: f64) -> f64 {
        let duration = self.shortest / (1.0 - quantile * (1.0 - self.shortest / self.longest));
        duration.min(self.longest)
    }

    /// The mean duration in s: ln(longest/shortest) shortest longest/(longest - shortest).
    pub fn mean_duration(&self) -> f64 {
        let Self { shortest, longest, .. } = *self;
        if longest - shortest < 1e-6 * longest {
            return shortest;
        }
        (longest / shortest).ln() * shortest * longest / (longest - shortest)
    }
}

/// What a link is like. Any values may stand in the fields; [`Link::new`] refuses those that mean nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkModel {
    /// From the pose being taken to its being known on the robot, in s.
    pub sensor_delay: f64,
    /// Ordinary delay.
    pub rtt: Rtt,
    /// Late packets of the downlink.
    pub late: LatePackets,
    /// Known outages in order of time, disjoint.
    pub outages: Vec<Outage>,
    /// Random outages.
    pub silences: Silences,
    /// Whether no packet overtakes an earlier one of its direction, and none is lost (as TCP does, over any number
    /// of connections); otherwise packets arrive as they come, and those of an outage are lost.
    pub in_order: bool,
}

impl LinkModel {
    /// In order, with the thesis's sensor delay and nothing but ordinary delay.
    pub const fn ordinary(rtt: Rtt) -> Self {
        Self {
            sensor_delay: SENSOR_DELAY,
            rtt,
            late: LatePackets::NONE,
            outages: Vec::new(),
            silences: Silences::NONE,
            in_order: true,
        }
    }

    /// The link called `name`, one of [`PRESETS`]; all are in order with a sensor delay of 130 ms.
    ///
    /// * `clean`: RTT 2 ms, the local network of a laboratory.
    /// * `normal`: RTT of median 40 ms and 99 % 100 ms (the thesis's: mostly below 100 ms).
    /// * `bad`: `normal` plus 400 ms with probability 5 % per downlink slot.
    /// * `wifi-bursty`: RTT of median 5 ms and 99 % 60 ms; 0.5 % of the slots late by 400 ms, 30 % after a late one
    ///   (the recordings: base rate 0.005-0.1, 0.1-0.4 after a late one); a silence of 0.5 to 12 s, 1.7 s in the mean,
    ///   every 30 s. The recording this follows was silent for half of the time; a task of half a minute that meets
    ///   one silence still ends, so methods can be compared on it.
    ///
    /// ```
    /// use umwelt_core::link::{LinkModel, PRESETS};
    /// assert!(PRESETS.iter().all(|name| LinkModel::preset(name).is_some()));
    /// assert_eq!(LinkModel::preset("worse"), None);
    /// ```
    pub fn preset(name: &str) -> Option<Self> {
        let normal = Self::ordinary(Rtt::Lognormal { median: 0.040, p99: 0.100 });
        match name {
            "clean" => Some(Self::ordinary(Rtt::Constant(0.002))),
            "normal" => Some(normal),
            "bad" => Some(Self { late: LatePackets::independent(0.05), ..normal }),
            "wifi-bursty" => Some(Self {
                late: LatePackets { probability: 0.005, after_late: 0.3, extra: LATE_EXTRA },
                silences: Silences { rate: 1.0 / 30.0, shortest: 0.5, longest: 12.0 },
                ..Self::ordinary(Rtt::Lognormal { median: 0.005, p99: 0.060 })
            }),
            _ => None,
        }
    }

    /// The median loop delay in s from a pose being taken to the reply to it arriving, late packets and silences
    /// aside; `None` for a trace.
    ///
    /// ```
    /// use umwelt_core::link::LinkModel;
    /// let normal = LinkModel::preset("normal").unwrap();
    /// assert!((normal.typical_loop_delay().unwrap() - 0.17).abs() < 1e-12);
    /// ```
    pub fn typical_loop_delay(&self) -> Option<f64> {
        match self.rtt {
            Rtt::Constant(rtt) | Rtt::Lognormal { median: rtt, .. } => {
                Some(self.sensor_delay + rtt)
            }
            Rtt::Trace(_) => None,
        }
    }
}

#[cfg(test)]
mod tests;
